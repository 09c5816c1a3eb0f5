//! The layout of the cost study: one tab per setting.

use rerun::external::re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint, components::PanelState,
};

use super::{ContainerLike, Layout, Parts, tab};
use crate::{
    record::{
        cost::Picture,
        error::RecordError,
        panel_view,
        paths::{self, Root},
        stream::RecordingStream,
        style::capitalize,
    },
    study::cost::CostSetting,
};

/// Sends the layout of the cost study.
pub fn send(
    rec: &RecordingStream,
    settings: &[(CostSetting, Vec<Picture>)],
) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let tabs = settings.iter();
    let tabs = tabs.filter_map(|(setting, pictures)| layout.setting_tab(*setting, pictures));
    let mut tabs: Vec<_> = tabs.collect();
    let about = layout.text("About this recording", paths::ABOUT);
    tabs.extend(tab("About", Some(about)));
    // All data are static.
    let time_panel = TimePanelBlueprint::new().with_state(PanelState::Hidden);
    layout.send(rec, tabs, &time_panel)
}

impl Layout {
    /// The description, and the error over each measure of work.
    fn setting_tab(&mut self, setting: CostSetting, pictures: &[Picture]) -> Option<ContainerLike> {
        let root = Root::of_setting(setting.name());
        let words = self.text("Description", &root.at(paths::SETTING_TEXT));
        let mut row = Parts::new().add(0.26, words);
        for picture in pictures {
            let bounds = picture.view.bounds(&picture.panel);
            let share = 0.74 / pictures.len() as f32;
            let view = self.picture(picture.name, picture.view.path(), bounds);
            let (points, crosses) = panel_view::default_styles();
            self.set_default(&view, &points);
            self.set_default(&view, &crosses);
            row = row.add(share, view);
        }
        tab(&capitalize(setting.name()), row.row())
    }
}
