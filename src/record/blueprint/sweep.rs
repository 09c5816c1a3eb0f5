//! The screens of a sweep: its starts side by side, and each by itself.

use rerun::{
    datatypes::{TimeInt, TimeRangeBoundary},
    external::re_sdk_types::blueprint::{
        archetypes::{TimeAxis, TimePanelBlueprint},
        components::{LoopMode, PanelState, PlayState, TimeRange},
    },
};

use super::{ContainerLike, Layout, Parts, View, tab};
use crate::record::{
    error::RecordError,
    paths::{self, Root},
    plot::{Axis, Bounds},
    portrait::Portrait,
    recurrence::Recurrence,
    stream::RecordingStream,
    sweep::{self, BodyView, Ladder, Scope, StartView, SweepView, square},
};

/// Values a second while playing.
const PLAYS: f64 = 1.5;

/// Sends the layout of a sweep.
pub fn send(rec: &RecordingStream, sweep: &SweepView, scope: &Scope) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let mut tabs = Vec::new();
    if sweep.starts.len() > 1 {
        tabs.push(layout.shapes_tab(sweep, scope));
        tabs.push(layout.tones_tab(sweep, scope));
    }
    for start in &sweep.starts {
        tabs.push(layout.start_tab(start, scope));
    }
    if let Some(body) = &sweep.body {
        tabs.push(tab("Mode shapes", Some(layout.mode_shapes(body))));
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

impl Layout {
    /// What the motions look like, a row a start.
    fn shapes_tab(&mut self, sweep: &SweepView, scope: &Scope) -> Option<ContainerLike> {
        let mut rows = Parts::new();
        for start in &sweep.starts {
            let words = self.point_words(start);
            let row = Parts::new()
                .add(0.2, words)
                .add(0.36, self.diagram(start, scope))
                .add(0.22, self.sweep_portrait(start))
                .add(0.22, self.sweep_recurrence(start));
            rows = rows.add(1.0, row.row());
        }
        tab("Side by side: shapes", rows.column())
    }

    /// How they sound, and whether neighbours part, a row a start.
    fn tones_tab(&mut self, sweep: &SweepView, scope: &Scope) -> Option<ContainerLike> {
        let mut rows = Parts::new();
        for start in &sweep.starts {
            let row = Parts::new()
                .add(0.42, self.sweep_spectrum(start, scope))
                .add(0.24, self.sweep_section(start))
                .add(0.34, self.sweep_exponents(start, scope));
            rows = rows.add(1.0, row.row());
        }
        tab("Side by side: tones", rows.column())
    }

    /// All of one start.
    fn start_tab(&mut self, start: &StartView, scope: &Scope) -> Option<ContainerLike> {
        let words = self.point_words(start);
        let top = Parts::new()
            .add(1.5, self.diagram(start, scope))
            .add(1.0, self.sweep_portrait(start))
            .add(1.0, self.sweep_embedding(start))
            .add(1.0, self.sweep_recurrence(start))
            .row();
        let low = Parts::new()
            .add(1.5, self.sweep_spectrum(start, scope))
            .add(1.0, self.sweep_section(start))
            .add(1.0, self.sweep_exponents(start, scope))
            .row();
        let right = Parts::new().add(1.0, top).add(1.0, low);
        let screen = Parts::new().add(0.2, words).add(0.8, right.column());
        tab(&sweep::title(start), screen.row())
    }

    fn point_words(&mut self, start: &StartView) -> ContainerLike {
        let root = Root::of_start(&start.key);
        self.text(&sweep::title(start), &root.at(paths::POINT_WORDS))
    }

    fn of_start(
        &mut self,
        start: &StartView,
        name: &str,
        path: &str,
        bounds: Bounds,
    ) -> ContainerLike {
        let name = format!("{name}: {}", start.words);
        self.picture(&name, &Root::of_start(&start.key).at(path), bounds)
    }

    fn diagram(&mut self, start: &StartView, scope: &Scope) -> ContainerLike {
        let bounds = scope.diagram.0.bounds();
        self.of_start(start, "Maxima", paths::DIAGRAM, bounds)
    }

    fn sweep_portrait(&mut self, start: &StartView) -> ContainerLike {
        self.of_start(start, "Phase portrait", paths::PORTRAIT, Portrait::bounds())
    }

    /// Delay vectors in their cube.
    fn sweep_embedding(&mut self, start: &StartView) -> ContainerLike {
        let name = format!("Delay vectors: {}", start.words);
        let origin = Root::of_start(&start.key).at(paths::EMBEDDING);
        self.cube(&name, &origin, 4.6)
    }

    /// The natural modes side by side, from the front and a little from above.
    fn mode_shapes(&mut self, body: &BodyView) -> ContainerLike {
        let view: ContainerLike = View::in_3d("Natural modes, yellow moves most")
            .with_origin(paths::SHAPES)
            .into();
        let distance = 60.0 * body.modes.len().max(6) as f64;
        let middle = [0.0, 0.0, -95.0];
        let eye = [0.0, -0.98, 0.2].map(|c: f64| c * distance);
        let from = [eye[0], eye[1], eye[2] + middle[2]];
        self.eye(&view, from, middle, [0.0, 0.0, 1.0]);
        view
    }

    fn sweep_recurrence(&mut self, start: &StartView) -> ContainerLike {
        let bounds = Recurrence::bounds();
        self.of_start(start, "Recurrence plot", paths::RECURRENCE, bounds)
    }

    fn sweep_spectrum(&mut self, start: &StartView, scope: &Scope) -> ContainerLike {
        let symbol = &scope.spectrum.frequency.symbol;
        let name = format!("Spectrum (lines in {symbol})");
        let bounds = scope.spectrum.plot.bounds();
        self.of_start(start, &name, paths::SPECTRUM, bounds)
    }

    fn sweep_section(&mut self, start: &StartView) -> ContainerLike {
        let axis = || Axis::linear("", -1.0, 1.0, 1);
        let bounds = square(axis(), axis()).bounds();
        self.of_start(start, "Poincaré section", paths::SECTION, bounds)
    }

    /// The exponents over the parameter; nothing if none were followed.
    fn sweep_exponents(&mut self, start: &StartView, scope: &Scope) -> Option<ContainerLike> {
        if scope.exponents == 0 {
            return None;
        }
        let root = Root::of_start(&start.key);
        let contents = [paths::EXPONENTS_RUNNING, paths::EXPONENTS_ZERO];
        let contents = contents.map(|path| format!("+ /{}", root.at(path)));
        // In words it would not fit over a narrow view.
        let name = format!("Lyapunov exponents, 1/s: {}", start.key);
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
