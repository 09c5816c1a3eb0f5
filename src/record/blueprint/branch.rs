//! The layout of branches of periodic orbits: one tab per branch.

use rerun::external::re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint,
    components::{LoopMode, PanelState, PlayState},
};

use super::{ContainerLike, Layout, Parts, tab};
use crate::record::{
    branch::{Course, Picture, root},
    error::RecordError,
    paths,
    stream::RecordingStream,
};

/// Orbits per second during playback.
const PLAYS: f64 = 8.0;

/// Sends the layout of branches.
pub fn send(
    rec: &RecordingStream,
    courses: &[(&Course<'_>, [Picture; 3])],
) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let tabs = courses.iter();
    let tabs = tabs.filter_map(|(course, pictures)| layout.branch_tab(course, pictures));
    let mut tabs: Vec<_> = tabs.collect();
    let about = layout.text("About this recording", paths::ABOUT);
    tabs.extend(tab("About", Some(about)));
    let mut time_panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_loop_mode(LoopMode::All)
        .with_play_state(PlayState::Paused);
    if let Some((course, _)) = courses.first() {
        time_panel = time_panel
            .with_timeline(course.timeline.name.as_str())
            .with_fps(PLAYS * course.timeline.gap().abs());
    }
    layout.send(rec, tabs, &time_panel)
}

impl Layout {
    /// Text, branch diagram, phase portrait and multipliers of a branch.
    fn branch_tab(
        &mut self,
        course: &Course<'_>,
        pictures: &[Picture; 3],
    ) -> Option<ContainerLike> {
        let words = self.text("Orbit", &root(course.number).at(paths::POINT_TEXT));
        let [diagram, portrait, multipliers] = pictures
            .each_ref()
            .map(|(name, path, bounds)| self.picture(name, path, *bounds));
        let low = Parts::new().add(1.0, portrait).add(1.0, multipliers);
        let right = Parts::new().add(1.0, diagram).add(1.1, low.row());
        let screen = Parts::new().add(0.24, words).add(0.76, right.column());
        tab(&format!("Branch {}", course.number), screen.row())
    }
}
