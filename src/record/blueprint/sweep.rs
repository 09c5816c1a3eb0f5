//! The layout of a sweep: its starts side by side, and each one separately.

use rerun::{
    datatypes::{TimeInt, TimeRangeBoundary},
    external::re_sdk_types::blueprint::{
        archetypes::{TimeAxis, TimePanelBlueprint},
        components::{LoopMode, PanelState, PlayState, TimeRange},
    },
};

use super::{ContainerLike, Layout, Parts, View, tab};
use crate::{
    plot,
    record::{
        error::RecordError,
        paths::{self, Root},
        stream::RecordingStream,
        sweep::{self, SharedScales, SweepStudy, TimelineTicks},
    },
    study::sweep::Start,
};

/// Parameter values per second during playback.
const PLAYS: f64 = 1.5;

/// Sends the layout of a sweep.
pub fn send(
    rec: &RecordingStream,
    sweep: &SweepStudy<'_>,
    scales: &SharedScales,
) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let starts = sweep.starts().map(|start| StartPanels {
        start,
        scales,
        pictures: sweep::pictures(sweep, start, scales),
    });
    let starts: Vec<StartPanels<'_>> = starts.collect();
    let mut tabs = Vec::new();
    if starts.len() > 1 {
        tabs.push(layout.portraits_tab(&starts));
        tabs.push(layout.spectra_tab(&starts));
    }
    tabs.extend(starts.iter().map(|start| layout.start_tab(start)));
    if let Some(body) = sweep.ball.and_then(|ball| ball.body().ok()) {
        let shapes = layout.mode_shapes(body.families().len());
        tabs.push(tab("Mode shapes", Some(shapes)));
    }
    let about = layout.text("About this recording", paths::ABOUT);
    tabs.push(tab("About", Some(about)));
    let tabs: Vec<_> = tabs.into_iter().flatten().collect();
    let time_panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(scales.timeline.name.as_str())
        .with_fps(PLAYS * scales.timeline.gap())
        .with_loop_mode(LoopMode::All)
        .with_play_state(PlayState::Paused);
    layout.send(rec, tabs, &time_panel)
}

/// The range of all ticks with a margin; `None` if there is only one.
fn whole(timeline: &TimelineTicks) -> Option<TimeRange> {
    let [first, .., last] = timeline.ticks[..] else {
        return None;
    };
    let margin = (0.3 * timeline.gap()).ceil() as i64;
    let at = |tick| TimeRangeBoundary::Absolute(TimeInt(tick));
    Some(TimeRange(rerun::datatypes::TimeRange {
        start: at(first - margin),
        end: at(last + margin),
    }))
}

/// A start with its panels.
struct StartPanels<'a> {
    start: Start,
    scales: &'a SharedScales,
    pictures: [sweep::Picture; 5],
}

/// Indices of the panels of a start.
const DIAGRAM: usize = 0;
const PORTRAIT: usize = 1;
const RECURRENCE: usize = 2;
const SPECTRUM: usize = 3;
const SECTION: usize = 4;

impl Layout {
    /// Shape of the motions: one row per start.
    fn portraits_tab(&mut self, starts: &[StartPanels<'_>]) -> Option<ContainerLike> {
        let rows = starts.iter().fold(Parts::new(), |rows, start| {
            let row = Parts::new()
                .add(0.2, self.point_text(start.start))
                .add(0.36, self.start_picture(start, DIAGRAM))
                .add(0.22, self.start_picture(start, PORTRAIT))
                .add(0.22, self.start_picture(start, RECURRENCE));
            rows.add(1.0, row.row())
        });
        tab("Comparison: phase space", rows.column())
    }

    /// Spectra, Poincaré sections and exponents: one row per start.
    fn spectra_tab(&mut self, starts: &[StartPanels<'_>]) -> Option<ContainerLike> {
        let rows = starts.iter().fold(Parts::new(), |rows, start| {
            let row = Parts::new()
                .add(0.42, self.start_picture(start, SPECTRUM))
                .add(0.24, self.start_picture(start, SECTION))
                .add(0.34, self.sweep_exponents(start));
            rows.add(1.0, row.row())
        });
        tab("Comparison: spectra and exponents", rows.column())
    }

    /// All panels of one start.
    fn start_tab(&mut self, start: &StartPanels<'_>) -> Option<ContainerLike> {
        let top = Parts::new()
            .add(1.5, self.start_picture(start, DIAGRAM))
            .add(1.0, self.start_picture(start, PORTRAIT))
            .add(1.0, self.sweep_embedding(start.start))
            .add(1.0, self.start_picture(start, RECURRENCE));
        let low = Parts::new()
            .add(1.5, self.start_picture(start, SPECTRUM))
            .add(1.0, self.start_picture(start, SECTION))
            .add(1.0, self.sweep_exponents(start));
        let right = Parts::new().add(1.0, top.row()).add(1.0, low.row());
        let words = self.point_text(start.start);
        let screen = Parts::new().add(0.2, words).add(0.8, right.column());
        tab(&sweep::title(start.start), screen.row())
    }

    fn point_text(&mut self, start: Start) -> ContainerLike {
        let root = Root::of_start(&start.to_string());
        self.text(&sweep::title(start), &root.at(paths::POINT_TEXT))
    }

    fn start_picture(&mut self, start: &StartPanels<'_>, place: usize) -> ContainerLike {
        let (name, path, bounds) = &start.pictures[place];
        let name = format!("{name}: {}", plot::start_label(start.start));
        self.picture(&name, path, *bounds)
    }

    /// The delay embedding in a cube.
    fn sweep_embedding(&mut self, start: Start) -> ContainerLike {
        let name = format!("Delay embedding: {}", plot::start_label(start));
        let origin = Root::of_start(&start.to_string()).at(paths::EMBEDDING);
        self.cube(&name, &origin, 4.6)
    }

    /// The natural modes side by side, from the front and slightly from above.
    fn mode_shapes(&mut self, count: usize) -> ContainerLike {
        let view: ContainerLike = View::in_3d("Natural modes (yellow: largest displacement)")
            .with_origin(paths::MODE_SHAPES)
            .into();
        let distance = 60.0 * count.max(6) as f64;
        let middle = [0.0, 0.0, -95.0];
        let eye = [0.0, -0.98, 0.2].map(|c: f64| c * distance);
        let from = [eye[0], eye[1], eye[2] + middle[2]];
        self.eye(&view, from, middle, [0.0, 0.0, 1.0]);
        view
    }

    /// The exponents over the parameter; `None` if they were not computed.
    fn sweep_exponents(
        &mut self,
        StartPanels { start, scales, .. }: &StartPanels<'_>,
    ) -> Option<ContainerLike> {
        if scales.exponents == 0 {
            return None;
        }
        let root = Root::of_start(&start.to_string());
        let contents = [paths::EXPONENTS_RUNNING, paths::EXPONENTS_ZERO];
        let contents = contents.map(|path| format!("+ /{}", root.at(path)));
        // The symbol of the start instead of its name, because the view is narrow.
        let name = format!("Lyapunov exponents, 1/s: {start}");
        let view = View::time_series(name).with_contents(contents).into();
        let view = self.windowed(view, None);
        let [low, high] = scales.exponent_range;
        self.range(&view, low, high);
        // By default the viewer shows only the neighbourhood of the cursor.
        if let Some(whole) = whole(&scales.timeline) {
            self.set(&view, &TimeAxis::new().with_view_range(whole));
        }
        Some(view)
    }
}
