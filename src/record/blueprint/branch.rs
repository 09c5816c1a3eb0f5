//! The layout of branches of periodic orbits: one tab per branch.

use re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint,
    components::{LoopMode, PlayState},
};

use super::{
    layout::{Row, screen_of},
    tree::{self, Part, View},
};
use crate::record::{
    branch::{BranchStudy, Course, diagram},
    panel_view::PanelView,
    paths::{self, Root},
    stream::RecordingStream,
};

/// Orbits per second during playback.
const PLAYS: f64 = 8.0;

/// Sends the layout of branches.
pub fn send(rec: &RecordingStream, study: &BranchStudy<'_>, courses: &[Course<'_>]) {
    let tabs = courses.iter();
    let mut tabs: Vec<Part> = tabs
        .filter_map(|course| {
            let screen = screen_of("branch", &mut |view| {
                let root = Root::of_branch(course.number);
                match view {
                    "point" => Some(View::text("Orbit", &root.at(paths::POINT_TEXT))),
                    "diagram" => {
                        let panel = diagram(study).with_title("Branch diagram");
                        Some(PanelView::of("branch-diagram", &root).view(&panel))
                    }
                    name => {
                        let row = Row::of(name)?;
                        row.picture(row.title, &root)
                    }
                }
            });
            Some(Part::tab(
                &format!("Branch {}", course.number),
                vec![screen?],
            ))
        })
        .collect();
    let about = View::text("About this recording", paths::ABOUT);
    tabs.push(Part::tab("About", vec![Part::View(about)]));
    let mut time_panel = TimePanelBlueprint::new()
        .with_loop_mode(LoopMode::All)
        .with_play_state(PlayState::Paused);
    if let Some(course) = courses.first() {
        time_panel = time_panel
            .with_timeline(course.timeline.name.as_str())
            .with_fps(PLAYS * course.timeline.gap().abs());
    }
    tree::send(rec, tabs, time_panel);
}
