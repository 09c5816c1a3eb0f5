//! The screen of what accuracy costs: a tab a knob.

use rerun::external::re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint, components::PanelState,
};

use super::{ContainerLike, Layout, Parts, tab};
use crate::record::{
    cost::{self, CostView, KnobView, Scope},
    error::RecordError,
    paths::{self, Root},
    stream::RecordingStream,
    style::capital,
};

/// Sends the layout of what accuracy costs.
pub fn send(rec: &RecordingStream, cost: &CostView, scopes: &[Scope]) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let knobs = cost.knobs.iter().zip(scopes);
    let mut tabs: Vec<_> = knobs
        .filter_map(|(knob, scope)| layout.knob_tab(knob, scope))
        .collect();
    let about = layout.text("About this recording", paths::ABOUT);
    tabs.extend(tab("About", Some(about)));
    // Nothing changes with time.
    let time_panel = TimePanelBlueprint::new().with_state(PanelState::Hidden);
    layout.send(rec, tabs, &time_panel)
}

impl Layout {
    /// Words, and error over each kind of work.
    fn knob_tab(&mut self, knob: &KnobView, scope: &Scope) -> Option<ContainerLike> {
        let root = Root::of_knob(knob.name);
        let words = self.text("In words", &root.at(paths::KNOB_WORDS));
        let mut row = Parts::new().add(0.26, words);
        for picture in &scope.pictures {
            let bounds = picture.plot.bounds();
            let path = root.at(picture.work.path());
            let share = 0.74 / scope.pictures.len() as f32;
            let view = self.picture(picture.work.title(), &path, bounds);
            let (points, crosses) = cost::default_looks();
            self.set_default(&view, &points);
            self.set_default(&view, &crosses);
            row = row.add(share, view);
        }
        tab(&capital(knob.name), row.row())
    }
}
