//! The layout of branches of periodic orbits: one tab per branch.

use rerun::external::re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint,
    components::{LoopMode, PanelState, PlayState},
};

use super::{
    layout::{named, screen_of},
    tree::{self, Part, View},
};
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
    let tabs = courses.iter();
    let mut tabs: Vec<Part> = tabs
        .filter_map(|(course, [diagram, portrait, multipliers])| {
            let picture = |(name, path, bounds): &Picture| View::picture(*name, path, *bounds);
            let screen = screen_of("branch", &mut |view| {
                Some(match view {
                    "point" => View::text("Orbit", &root(course.number).at(paths::POINT_TEXT)),
                    "diagram" => picture(diagram),
                    "portrait" => picture(portrait),
                    _ => picture(multipliers),
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
    if let Some((course, _)) = courses.first() {
        time_panel = time_panel
            .with_timeline(course.timeline.name.as_str())
            .with_fps(PLAYS * course.timeline.gap().abs());
    }
    tree::send(rec, tabs, &time_panel)
}
