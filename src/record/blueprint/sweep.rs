//! The layout of a sweep: its starts side by side, and each one separately.

use re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint,
    components::{LoopMode, PlayState},
};

use super::{
    layout::screen_of,
    tree::{self, Part, View},
};
use crate::{
    plot,
    record::{
        paths::{self, Root},
        stream::RecordingStream,
        sweep::{self, SharedScales, SweepStudy},
    },
    study::sweep::Start,
};

/// Parameter values per second during playback.
const PLAYS: f64 = 1.5;

/// Sends the layout of a sweep: its starts side by side, and each one separately.
pub fn send(rec: &RecordingStream, sweep: &SweepStudy<'_>, scales: &SharedScales) {
    let starts: Vec<Start> = sweep.starts().collect();
    let mut tabs = Vec::new();
    if starts.len() > 1 {
        for (key, title) in [
            ("starts-in-phase-space", "Comparison: phase space"),
            ("starts-in-frequency", "Comparison: spectra and exponents"),
        ] {
            let rows = starts
                .iter()
                .filter_map(|start| screen_of(key, &mut |view| self::view(sweep, *start, view)));
            tabs.push(Part::tab(title, rows.collect()));
        }
    }
    for start in &starts {
        let screen = screen_of("start", &mut |view| self::view(sweep, *start, view));
        tabs.extend(screen.map(|screen| Part::tab(&sweep::title(*start), vec![screen])));
    }
    if let Some(body) = sweep.ball.and_then(|ball| ball.body().ok()) {
        let shapes = Part::View(mode_shapes(body.families().len()));
        tabs.push(Part::tab("Mode shapes", vec![shapes]));
    }
    let about = View::text("About this recording", paths::ABOUT);
    tabs.push(Part::tab("About", vec![Part::View(about)]));
    let time_panel = TimePanelBlueprint::new()
        .with_timeline(scales.timeline.name.as_str())
        .with_fps(PLAYS * scales.timeline.gap())
        .with_loop_mode(LoopMode::All)
        .with_play_state(PlayState::Paused);
    tree::send(rec, tabs, time_panel);
}

/// A view of a start.
fn view(sweep: &SweepStudy<'_>, start: Start, name: &str) -> Option<View> {
    let root = Root::of_start(&start.to_string());
    match name {
        "point" => Some(View::text(sweep::title(start), &root.at(paths::POINT_TEXT))),
        "embedding" => {
            let name = format!("Delay embedding: {}", plot::start_label(start));
            Some(View::cube(name, &root.at(paths::EMBEDDING), 4.6))
        }
        _ => sweep::picture(sweep, start, name),
    }
}

/// The natural modes side by side, from the front and slightly from above.
fn mode_shapes(count: usize) -> View {
    let distance = 60.0 * count.max(6) as f64;
    let middle = [0.0, 0.0, -95.0];
    let eye = [0.0, -0.98, 0.2].map(|c: f64| c * distance);
    let from = [eye[0], eye[1], eye[2] + middle[2]];
    View::in_3d("Natural modes (yellow: largest displacement)")
        .with_origin(paths::MODE_SHAPES)
        .with_eye(from, middle, [0.0, 0.0, 1.0])
}
