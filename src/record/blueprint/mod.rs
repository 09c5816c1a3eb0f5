//! The layout of the viewer: views, their positions, ranges and cameras.
//!
//! Rerun's Rust interface has views and containers, but no setters for most properties of a view (time range,
//! axis range, legend, bounds, camera). The module `tree` therefore writes blueprints itself.

mod analyses;
mod branch;
mod flow;
mod joint;
mod lesson;
mod signal;
mod small;
mod sweep;
mod tree;

use rerun::{
    Archetype,
    datatypes::{TimeInt, TimeRange, TimeRangeBoundary, VisibleTimeRange},
    external::re_sdk_types::blueprint::{
        archetypes::{
            Background, EyeControls3D, LineGrid3D, PlotLegend, ScalarAxis, TimePanelBlueprint,
            VisibleTimeRanges, VisualBounds2D,
        },
        components::{BackgroundKind, Corner2D, PanelState, PlayState},
    },
};

use super::{
    controls,
    error::RecordError,
    paths,
    plot::Bounds,
    recurrence::Recurrence,
    spectrum,
    stream::{self, RecordingStream},
    style,
};
use crate::{
    pipeline::message::{AnalysisKind, Header, Subject},
    scene::RecordSpec,
};

use tree::{Container, ContainerLike, Properties, View};

pub use branch::send as send_branch;
pub use sweep::send as send_sweep;

/// Playback speed of a joint, simulated seconds per second; others play in [`SIGNAL_PLAYS`].
const JOINT_SPEED: f64 = 0.01;
/// Playback time of a signal or a small system, s.
const SIGNAL_PLAYS: f64 = 30.0;

/// Sends the layout of a run.
pub fn send(rec: &RecordingStream, header: &Header, spec: RecordSpec) -> Result<(), RecordError> {
    send_with_first_tab(rec, header, spec, 0)
}

/// Sends the layout of a run with the tabs rotated, so that tab `first` is the one that the viewer opens.
pub fn send_with_first_tab(
    rec: &RecordingStream,
    header: &Header,
    spec: RecordSpec,
    first: usize,
) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let (mut tabs, speed) = match &header.subject {
        Subject::Joint(joint) => {
            let tabs = vec![
                layout.lesson_tab(header, spec),
                layout.overview_tab(header, joint, spec),
                layout.contact_tab(header, joint, spec),
                layout.modes_tab(spec),
            ];
            (tabs, JOINT_SPEED)
        }
        Subject::Small(small) => {
            let tabs = vec![
                layout.lesson_tab(header, spec),
                layout.motion_tab(header, small),
            ];
            (tabs, header.duration / SIGNAL_PLAYS)
        }
        Subject::Signal(signal) => {
            let tabs = vec![layout.signal_tab(header, signal)];
            (tabs, header.duration / SIGNAL_PLAYS)
        }
    };
    tabs.extend([
        layout.embedding_tab(header),
        layout.recurrence_tab(header),
        layout.regime_tab(header),
    ]);
    if !matches!(header.subject, Subject::Signal(_)) {
        tabs.extend([
            layout.lyapunov_tab(header),
            layout.perturbed_tab(header),
            layout.controls_tab(header),
            layout.health_tab(header),
        ]);
    }
    tabs.push(layout.about_tab(header));
    let mut tabs: Vec<_> = tabs.into_iter().flatten().collect();
    tabs.rotate_left(first);
    let time_panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(paths::TIMELINE)
        .with_playback_speed(speed)
        .with_play_state(PlayState::Following);
    layout.send(rec, tabs, &time_panel)
}

/// The properties of the views, collected during the layout.
#[derive(Default)]
struct Layout {
    properties: Properties,
}

impl Layout {
    /// Adds a property to a view.
    fn set<A: Archetype + rerun::AsComponents>(&mut self, view: &ContainerLike, property: &A) {
        self.add(view, A::name().short_name(), property);
    }

    fn add(&mut self, view: &ContainerLike, name: &'static str, what: &impl rerun::AsComponents) {
        if let ContainerLike::View(view) = view {
            let properties = self.properties.entry(view.key()).or_default();
            properties.push((name, what.as_serialized_batches()));
        }
    }

    /// Description of the run and of its views; for a signal also the log.
    fn about_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        let about = self.text("About this recording", paths::ABOUT);
        // The log of a simulation is in the tab "Solver".
        let log = matches!(header.subject, Subject::Signal(_)).then(log);
        tab(
            "About",
            Parts::new().add(0.85, about).add(0.15, log).column(),
        )
    }

    /// The numbers that commands change during a live run: those that the scene names.
    fn controls_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        let views = controls::recorded(header)
            .filter(|control| control.is_named)
            .map(|control| {
                let [path, name] = controls::series(control);
                self.series(&name, &path, None)
            });
        let views = views.fold(Parts::new(), |parts, view| parts.add(1.0, view));
        tab("Controls", views.column())
    }

    fn text(&mut self, name: &str, path: &str) -> ContainerLike {
        View::text_document(name).with_origin(path).into()
    }

    /// A time series of the last `window` s before the cursor, or of the whole run. It has no legend, which
    /// would cover data; the title explains the colours.
    fn series(&mut self, name: &str, path: &str, window: Option<f64>) -> ContainerLike {
        let view = View::time_series(name).with_origin(path).into();
        self.windowed(view, window)
    }

    /// As [`Layout::series`], for several entities.
    fn series_of(&mut self, name: &str, paths: &[&str], window: Option<f64>) -> ContainerLike {
        let contents = paths.iter().map(|path| format!("+ /{path}"));
        let view = View::time_series(name).with_contents(contents).into();
        self.windowed(view, window)
    }

    /// A time series without a legend, of a window before the cursor or of the whole run.
    fn windowed(&mut self, view: ContainerLike, window: Option<f64>) -> ContainerLike {
        if let Some(window) = window {
            self.window(&view, window);
        }
        self.set(&view, &PlotLegend::new().with_visible(false));
        view
    }

    /// Limits a view to the last `window` s before the cursor.
    fn window(&mut self, view: &ContainerLike, window: f64) {
        let range = VisibleTimeRange {
            timeline: paths::TIMELINE.into(),
            range: before_cursor(window),
        };
        self.set(view, &VisibleTimeRanges::new([range]));
    }

    /// Several entities over the whole run, with a legend.
    fn many_series(&mut self, name: &str, paths: &[&str], legend: Corner2D) -> ContainerLike {
        let contents = paths.iter().map(|path| format!("+ /{path}"));
        let view: ContainerLike = View::time_series(name).with_contents(contents).into();
        self.set(&view, &PlotLegend::new().with_corner(legend));
        view
    }

    /// Fixes the vertical range of a time series; the viewer chooses it if the range is empty.
    fn range(&mut self, view: &ContainerLike, low: f64, high: f64) {
        if low < high {
            let range = rerun::components::Range1D::new(low, high);
            self.set(view, &ScalarAxis::new().with_range(range));
        }
    }

    /// A two-dimensional plot with its own axes, completely visible.
    fn picture(&mut self, name: &str, path: &str, bounds: Bounds) -> ContainerLike {
        let view: ContainerLike = View::in_2d(name).with_origin(path).into();
        let range =
            |[low, high]: [f32; 2]| rerun::datatypes::Range1D([f64::from(low), f64::from(high)]);
        self.set(
            &view,
            &VisualBounds2D::new(rerun::datatypes::Range2D {
                x_range: range(bounds.x),
                y_range: range(bounds.y),
            }),
        );
        view
    }

    /// The current spectrum.
    fn spectrum(&mut self, header: &Header) -> Option<ContainerLike> {
        let plot = spectrum::SpectrumPlot::new(header);
        let name = match header.subject {
            Subject::Joint(_) | Subject::Small(_) => {
                format!(
                    "Spectrum of the velocity (lines in {})",
                    plot.frequency.symbol
                )
            }
            Subject::Signal(_) => format!("Spectrum (lines in {})", plot.frequency.symbol),
        };
        let bounds = plot.plot().bounds();
        header
            .has(AnalysisKind::Spectrum)
            .then(|| self.picture(&name, paths::SPECTRUM, bounds))
    }

    /// The spectrogram of the run.
    fn spectrogram(&mut self, header: &Header) -> Option<ContainerLike> {
        let name = match header.subject {
            Subject::Joint(_) | Subject::Small(_) => "Spectrogram of the velocity",
            Subject::Signal(_) => "Spectrogram",
        };
        let bounds = spectrum::spectrogram_plot(header).plot.bounds();
        header
            .has(AnalysisKind::Spectrogram)
            .then(|| self.picture(name, paths::SPECTROGRAM, bounds))
    }

    fn recurrence(&mut self, header: &Header) -> Option<ContainerLike> {
        let name = "Recurrence plot (bright: recurrent)";
        header
            .has(AnalysisKind::Recurrence)
            .then(|| self.picture(name, paths::RECURRENCE, Recurrence::bounds()))
    }

    /// The delay embedding in a cube, seen from `distance` (in half edges); a narrow view needs a larger one.
    fn embedding(&mut self, header: &Header, distance: f64) -> Option<ContainerLike> {
        if !header.has(AnalysisKind::Recurrence) {
            return None;
        }
        let name = match header.subject {
            Subject::Joint(_) | Subject::Small(_) => "Delay embedding of the displacement",
            Subject::Signal(_) => "Delay embedding",
        };
        Some(self.cube(name, paths::EMBEDDING, distance))
    }

    /// A cube of side 2 centred at the origin.
    fn cube(&mut self, name: &str, origin: &str, distance: f64) -> ContainerLike {
        let view: ContainerLike = View::in_3d(name).with_origin(origin).into();
        let from = [0.57, -0.69, 0.45].map(|c| distance * c);
        self.eye(&view, from, [0.0; 3], [0.0, 0.0, 1.0]);
        view
    }

    fn eye(&mut self, view: &ContainerLike, from: [f64; 3], to: [f64; 3], up: [f64; 3]) {
        let [from, to, up] = [from, to, up].map(|v| v.map(|c| c as f32));
        self.set(
            view,
            &EyeControls3D::new()
                .with_position(from)
                .with_look_target(to)
                .with_eye_up(up),
        );
        self.set(view, &LineGrid3D::new().with_visible(false));
        self.set(
            view,
            &Background::new(BackgroundKind::SolidColor).with_color(style::BACKGROUND),
        );
    }

    /// Sends the layout.
    fn send(
        self,
        rec: &RecordingStream,
        tabs: Vec<ContainerLike>,
        time_panel: &TimePanelBlueprint,
    ) -> Result<(), RecordError> {
        tree::send(rec, &Container::tabs(tabs), time_panel, self.properties)
    }
}

/// Log of warnings and the summary.
fn log() -> ContainerLike {
    View::text_log("Log").with_origin(paths::LOG).into()
}

/// A tab; `None` without content.
fn tab(name: &str, content: Option<ContainerLike>) -> Option<ContainerLike> {
    Some(
        Container::column(vec![content?], Vec::new())
            .with_name(name)
            .into(),
    )
}

/// The views of a row or column with their shares. A missing view takes no space.
#[derive(Default)]
struct Parts {
    views: Vec<ContainerLike>,
    shares: Vec<f32>,
}

impl Parts {
    fn new() -> Self {
        Self::default()
    }

    fn add(mut self, share: f32, view: impl Into<Option<ContainerLike>>) -> Self {
        if let Some(view) = view.into() {
            self.views.push(view);
            self.shares.push(share);
        }
        self
    }

    /// The views side by side; `None` if there are none.
    fn row(self) -> Option<ContainerLike> {
        let Self { views, shares } = self;
        (!views.is_empty()).then(|| Container::row(views, shares).into())
    }

    /// The views below each other; `None` if there are none.
    fn column(self) -> Option<ContainerLike> {
        let Self { views, shares } = self;
        (!views.is_empty()).then(|| Container::column(views, shares).into())
    }
}

/// The last `window` s before the time cursor.
fn before_cursor(window: f64) -> TimeRange {
    TimeRange {
        start: TimeRangeBoundary::CursorRelative(TimeInt(-stream::nanos(window))),
        end: TimeRangeBoundary::AT_CURSOR,
    }
}
