//! The screens of a sweep: its starts side by side, and each by itself.

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
        sweep::{self, Ladder, Scope, SweepStudy},
    },
    study::sweep::Start,
};

/// Values a second while playing.
const PLAYS: f64 = 1.5;

/// Sends the layout of a sweep.
pub fn send(
    rec: &RecordingStream,
    sweep: &SweepStudy<'_>,
    scope: &Scope,
) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let starts = sweep.starts().map(|start| StartPictures {
        start,
        scope,
        pictures: sweep::pictures(sweep, start, scope),
    });
    let starts: Vec<StartPictures<'_>> = starts.collect();
    let mut tabs = Vec::new();
    if starts.len() > 1 {
        tabs.push(layout.shapes_tab(&starts));
        tabs.push(layout.tones_tab(&starts));
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
        .with_timeline(scope.ladder.name.as_str())
        .with_fps(PLAYS * scope.ladder.gap())
        .with_loop_mode(LoopMode::All)
        .with_play_state(PlayState::Paused);
    layout.send(rec, tabs, &time_panel)
}

/// All ticks, and a little more to either side; nothing if there is but one.
fn whole(ladder: &Ladder) -> Option<TimeRange> {
    let [first, .., last] = ladder.ticks[..] else {
        return None;
    };
    let margin = (0.3 * ladder.gap()).ceil() as i64;
    let at = |tick| TimeRangeBoundary::Absolute(TimeInt(tick));
    Some(TimeRange(rerun::datatypes::TimeRange {
        start: at(first - margin),
        end: at(last + margin),
    }))
}

/// A way of starting with its pictures.
struct StartPictures<'a> {
    start: Start,
    scope: &'a Scope,
    pictures: [sweep::Picture; 5],
}

/// Places of the pictures of a start.
const DIAGRAM: usize = 0;
const PORTRAIT: usize = 1;
const RECURRENCE: usize = 2;
const SPECTRUM: usize = 3;
const SECTION: usize = 4;

impl Layout {
    /// What the motions look like, a row a start.
    fn shapes_tab(&mut self, starts: &[StartPictures<'_>]) -> Option<ContainerLike> {
        let rows = starts.iter().fold(Parts::new(), |rows, start| {
            let row = Parts::new()
                .add(0.2, self.point_words(start.start))
                .add(0.36, self.start_picture(start, DIAGRAM))
                .add(0.22, self.start_picture(start, PORTRAIT))
                .add(0.22, self.start_picture(start, RECURRENCE));
            rows.add(1.0, row.row())
        });
        tab("Side by side: shapes", rows.column())
    }

    /// How they sound, and whether neighbours diverge, a row a start.
    fn tones_tab(&mut self, starts: &[StartPictures<'_>]) -> Option<ContainerLike> {
        let rows = starts.iter().fold(Parts::new(), |rows, start| {
            let row = Parts::new()
                .add(0.42, self.start_picture(start, SPECTRUM))
                .add(0.24, self.start_picture(start, SECTION))
                .add(0.34, self.sweep_exponents(start));
            rows.add(1.0, row.row())
        });
        tab("Side by side: tones", rows.column())
    }

    /// All of one start.
    fn start_tab(&mut self, start: &StartPictures<'_>) -> Option<ContainerLike> {
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
        let words = self.point_words(start.start);
        let screen = Parts::new().add(0.2, words).add(0.8, right.column());
        tab(&sweep::title(start.start), screen.row())
    }

    fn point_words(&mut self, start: Start) -> ContainerLike {
        let root = Root::of_start(&start.to_string());
        self.text(&sweep::title(start), &root.at(paths::POINT_WORDS))
    }

    fn start_picture(&mut self, start: &StartPictures<'_>, place: usize) -> ContainerLike {
        let (name, path, bounds) = &start.pictures[place];
        let name = format!("{name}: {}", plot::words(start.start));
        self.picture(&name, path, *bounds)
    }

    /// Delay vectors in their cube.
    fn sweep_embedding(&mut self, start: Start) -> ContainerLike {
        let name = format!("Delay vectors: {}", plot::words(start));
        let origin = Root::of_start(&start.to_string()).at(paths::EMBEDDING);
        self.cube(&name, &origin, 4.6)
    }

    /// The natural modes side by side, from the front and a little from above.
    fn mode_shapes(&mut self, count: usize) -> ContainerLike {
        let view: ContainerLike = View::in_3d("Natural modes, yellow moves most")
            .with_origin(paths::SHAPES)
            .into();
        let distance = 60.0 * count.max(6) as f64;
        let middle = [0.0, 0.0, -95.0];
        let eye = [0.0, -0.98, 0.2].map(|c: f64| c * distance);
        let from = [eye[0], eye[1], eye[2] + middle[2]];
        self.eye(&view, from, middle, [0.0, 0.0, 1.0]);
        view
    }

    /// The exponents over the parameter; nothing if none were followed.
    fn sweep_exponents(
        &mut self,
        StartPictures { start, scope, .. }: &StartPictures<'_>,
    ) -> Option<ContainerLike> {
        if scope.exponents == 0 {
            return None;
        }
        let root = Root::of_start(&start.to_string());
        let contents = [paths::EXPONENTS_RUNNING, paths::EXPONENTS_ZERO];
        let contents = contents.map(|path| format!("+ /{}", root.at(path)));
        // In words it would not fit over a narrow view.
        let name = format!("Lyapunov exponents, 1/s: {start}");
        let view = View::time_series(name).with_contents(contents).into();
        let view = self.windowed(view, None);
        let [low, high] = scope.exponent_range;
        self.range(&view, low, high);
        // Left alone the viewer shows the neighbourhood of the cursor.
        if let Some(whole) = whole(&scope.ladder) {
            self.set(&view, &TimeAxis::new().with_view_range(whole));
        }
        Some(view)
    }
}
