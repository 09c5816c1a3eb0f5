//! The layout of branches of periodic orbits: one tab per branch.

use re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint,
    components::{LoopMode, PanelState, PlayState},
};

use super::{
    layout::{named, screen_of},
    tree::{self, Part, View},
};
use crate::record::{
    branch::{BranchStudy, Course, picture, root},
    error::RecordError,
    paths,
    stream::RecordingStream,
};

/// Orbits per second during playback.
const PLAYS: f64 = 8.0;

/// Sends the layout of branches.
pub fn send(
    rec: &RecordingStream,
    study: &BranchStudy<'_>,
    courses: &[Course<'_>],
) -> Result<(), RecordError> {
    let tabs = courses.iter();
    let mut tabs: Vec<Part> = tabs
        .filter_map(|course| {
            let screen = screen_of("branch", &mut |view| {
                Some(match view {
                    "point" => View::text("Orbit", &root(course.number).at(paths::POINT_TEXT)),
                    name => picture(study, course, name),
                })
            });
            Some(named(&format!("Branch {}", course.number), screen?))
        })
        .collect();
    let about = View::text("About this recording", paths::ABOUT);
    tabs.push(named("About", Part::View(about)));
    let mut time_panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_loop_mode(LoopMode::All)
        .with_play_state(PlayState::Paused);
    if let Some(course) = courses.first() {
        time_panel = time_panel
            .with_timeline(course.timeline.name.as_str())
            .with_fps(PLAYS * course.timeline.gap().abs());
    }
    tree::send(rec, tabs, &time_panel)
}
