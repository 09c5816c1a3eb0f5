//! The screen of what accuracy costs: a tab a knob.

use rerun::external::re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint, components::PanelState,
};

use super::{ContainerLike, Layout, Parts, tab};
use crate::{
    record::{
        cost::Picture,
        error::RecordError,
        figure,
        paths::{self, Root},
        stream::RecordingStream,
        style::capital,
    },
    study::cost::Knob,
};

/// Sends the layout of what accuracy costs.
pub fn send(rec: &RecordingStream, knobs: &[(Knob, Vec<Picture>)]) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let tabs = knobs.iter();
    let tabs = tabs.filter_map(|(knob, pictures)| layout.knob_tab(*knob, pictures));
    let mut tabs: Vec<_> = tabs.collect();
    let about = layout.text("About this recording", paths::ABOUT);
    tabs.extend(tab("About", Some(about)));
    // Nothing changes with time.
    let time_panel = TimePanelBlueprint::new().with_state(PanelState::Hidden);
    layout.send(rec, tabs, &time_panel)
}

impl Layout {
    /// Words, and error over each kind of work.
    fn knob_tab(&mut self, knob: Knob, pictures: &[Picture]) -> Option<ContainerLike> {
        let root = Root::of_knob(knob.name());
        let words = self.text("In words", &root.at(paths::KNOB_WORDS));
        let mut row = Parts::new().add(0.26, words);
        for picture in pictures {
            let bounds = picture.view.bounds(&picture.panel);
            let share = 0.74 / pictures.len() as f32;
            let view = self.picture(picture.name, picture.view.path(), bounds);
            let (points, crosses) = figure::default_looks();
            self.set_default(&view, &points);
            self.set_default(&view, &crosses);
            row = row.add(share, view);
        }
        tab(&capital(knob.name()), row.row())
    }
}
