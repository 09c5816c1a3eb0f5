//! The viewer's screen: which views, where, with which ranges and eyes.
//!
//! The Rust interface of Rerun has views and containers but no setters for a view's properties
//! (time range, axis range, legend, bounds, eye). A blueprint is itself a recording, though: a
//! property is an archetype logged at `view/<id>/<archetype>`. So the blueprint is written to
//! memory, the properties are added to the same store, and all of it is sent on together.

use rerun::{
    Archetype, EntityPath, RecordingStream, RecordingStreamBuilder,
    blueprint::{
        Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel,
        Spatial2DView, Spatial3DView, Tabs, TextDocumentView, TextLogView, TimePanel,
        TimeSeriesView, Vertical,
        components::{PanelState, PlayState},
    },
    datatypes::{TimeInt, TimeRange, TimeRangeBoundary, VisibleTimeRange},
    external::{
        re_log_types::BlueprintActivationCommand,
        re_sdk_types::blueprint::{
            archetypes::{
                Background, EyeControls3D, LineGrid3D, PlotLegend, ScalarAxis, VisibleTimeRanges,
                VisualBounds2D,
            },
            components::BackgroundKind,
        },
    },
    log::LogMsg,
};

use super::{
    error::RecordError, patch, paths, plot::Bounds, portrait::Portrait, recurrence::Recurrence,
    samples, sink::APPLICATION, spectrum, stream, style, vantage::Vantage,
};
use crate::{
    pipeline::message::{Header, JointInfo, SignalInfo, Subject},
    scene::RecordSpec,
};

/// Simulated time that the time series show, s: some twenty periods of a 4 kHz squeak.
const SERIES_WINDOW: f64 = 5e-3;
/// Snapshots of the contact that time series show where they are rarer than samples.
const SNAPSHOTS: f64 = 50.0;
/// Simulated seconds a second while playing.
const PLAYBACK_SPEED: f64 = 0.01;

/// Sends the layout for a run.
pub fn send(rec: &RecordingStream, header: &Header, spec: RecordSpec) -> Result<(), RecordError> {
    let mut layout = Layout::default();
    let tabs = match &header.subject {
        Subject::Joint(joint) => vec![
            layout.squeak_tab(header, joint, spec),
            layout.contact_tab(joint, spec),
            layout.modes_tab(),
            layout.health_tab(),
            layout.about_tab(),
        ],
        Subject::Signal(signal) => vec![layout.signal_tab(header, signal), layout.about_tab()],
    };
    let blueprint = Blueprint::new(Tabs::new(tabs))
        .with_auto_layout(false)
        .with_auto_views(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
        .with_time_panel(
            TimePanel::new()
                .with_state(PanelState::Collapsed)
                .with_timeline(paths::TIMELINE)
                .with_playback_speed(PLAYBACK_SPEED)
                .with_play_state(PlayState::Following),
        );
    layout.send(rec, &blueprint)
}

/// Collects the properties of views while these are laid out.
#[derive(Default)]
struct Layout {
    properties: Vec<(EntityPath, Vec<rerun::SerializedComponentBatch>)>,
}

impl Layout {
    /// Adds a property to a view.
    fn set<A: Archetype + rerun::AsComponents>(&mut self, view: &ContainerLike, property: &A) {
        if let ContainerLike::View(view) = view {
            let path = view
                .blueprint_path()
                .join(&EntityPath::from_single_string(A::name().short_name()));
            self.properties
                .push((path, property.as_serialized_batches()));
        }
    }

    fn squeak_tab(
        &mut self,
        header: &Header,
        joint: &JointInfo,
        spec: RecordSpec,
    ) -> ContainerLike {
        let words = self.text("What you see", paths::NARRATION);
        let body = self.body(joint, spec);
        let patch = self.patch(joint);
        let portrait = self.picture(
            "Phase portrait of the contact's centre",
            paths::PORTRAIT,
            Portrait::bounds(),
        );
        let recurrence = self.picture(
            "Recurrence plot: bright = same again",
            paths::RECURRENCE,
            Recurrence::bounds(),
        );
        let spectrogram = self.picture(
            "Spectrogram of the velocity",
            paths::SPECTROGRAM,
            spectrum::spectrogram_plot(header).plot.bounds(),
        );
        let spectrum = self.picture(
            "Spectrum of the velocity (lines in kHz)",
            paths::SPECTRUM,
            spectrum::spectrum_plot(header).plot.bounds(),
        );
        let displacement = self.series(
            "Displacement u, µm (last 5 ms)",
            paths::DISPLACEMENT,
            Some(SERIES_WINDOW),
        );
        let velocity = self.series(
            "Velocity v, mm/s (last 5 ms)",
            paths::VELOCITY,
            Some(SERIES_WINDOW),
        );
        let tilt = self.series("Tilt of the load, degrees (whole run)", paths::TILT, None);
        let [lowest, highest] = [joint.min_tilt, joint.max_tilt].map(|t| 1.15 * t.to_degrees());
        self.range(
            &tilt,
            lowest.min(0.0),
            highest.max(if lowest < 0.0 { 0.0 } else { 1.0 }),
        );
        // Squeak grows until the slip just about reverses: its velocity is of the order of the
        // sliding speed, its displacement no more than that of the lowest mode so excited.
        let speed = joint.sliding_speed;
        if let Some(lowest) = joint.modes.first() {
            let largest = speed / (std::f64::consts::TAU * lowest.frequency_hz);
            self.range(&displacement, -1e6 * largest, 1e6 * largest);
        }
        self.range(&velocity, -2e3 * speed, 2e3 * speed);

        let left = Vertical::new([words, body]).with_row_shares(vec![0.42, 0.58]);
        let top =
            Horizontal::new([patch, portrait, recurrence]).with_column_shares(vec![1.0, 1.0, 1.0]);
        let middle = Horizontal::new([spectrogram, spectrum]).with_column_shares(vec![1.62, 1.0]);
        let bottom =
            Horizontal::new([displacement, velocity, tilt]).with_column_shares(vec![1.0, 1.0, 1.0]);
        let right = Vertical::new([top.into(), middle.into(), bottom.into()])
            .with_row_shares(vec![0.44, 0.35, 0.21]);
        Horizontal::new([left.into(), right.into()])
            .with_column_shares(vec![0.25, 0.75])
            .with_name("Squeak")
            .into()
    }

    /// A signal from a file: what it looks like, and how it sounds.
    fn signal_tab(&mut self, header: &Header, signal: &SignalInfo) -> ContainerLike {
        let words = self.text("What you see", paths::NARRATION);
        let name = style::with_unit(style::signal_name(signal), &signal.unit);
        let waveform = self.series(&name, paths::WAVEFORM, None);
        let embedding = self.embedding();
        let recurrence = self.picture(
            "Recurrence plot: bright = same again",
            paths::RECURRENCE,
            Recurrence::bounds(),
        );
        let spectrogram = self.picture(
            "Spectrogram",
            paths::SPECTROGRAM,
            spectrum::spectrogram_plot(header).plot.bounds(),
        );
        let spectrum = self.picture(
            "Spectrum",
            paths::SPECTRUM,
            spectrum::spectrum_plot(header).plot.bounds(),
        );
        let top = Horizontal::new([embedding, recurrence]);
        let middle = Horizontal::new([spectrogram, spectrum]).with_column_shares(vec![1.62, 1.0]);
        let right = Vertical::new([top.into(), middle.into(), waveform])
            .with_row_shares(vec![0.44, 0.35, 0.21]);
        Horizontal::new([words, right.into()])
            .with_column_shares(vec![0.25, 0.75])
            .with_name("Signal")
            .into()
    }

    fn contact_tab(&mut self, joint: &JointInfo, spec: RecordSpec) -> ContainerLike {
        let patch = self.patch(joint);
        let rate = style::short(1e-3 * spec.patch_rate);
        let window = Some(SERIES_WINDOW.max(SNAPSHOTS / spec.patch_rate));
        let counts = self.series(
            &format!(
                "Nodes that slide (blue), stick (orange), are open (white); {rate} kHz snapshots"
            ),
            paths::NODE_COUNTS,
            window,
        );
        let force = self.series(
            &format!(
                "Forces on the ball, N: normal (yellow), friction (pink); {rate} kHz snapshots"
            ),
            paths::CONTACT_FORCE,
            window,
        );
        self.range(&force, 0.0, 1.6 * joint.load);
        let embedding = self.embedding();
        let left = Vertical::new([patch, embedding]);
        let right = Vertical::new([counts, force]);
        Horizontal::new([left.into(), right.into()])
            .with_column_shares(vec![0.45, 0.55])
            .with_name("Contact")
            .into()
    }

    fn modes_tab(&mut self) -> ContainerLike {
        let window = Some(SERIES_WINDOW);
        let q = self.series(
            "Modal coordinates, √kg µm (last 5 ms)",
            paths::MODES_Q,
            window,
        );
        let qdot = self.series(
            "Modal velocities, √kg mm/s (last 5 ms)",
            paths::MODES_QDOT,
            window,
        );
        let energy = self.series(
            "Vibration energy of each mode, µJ (whole run)",
            paths::MODES_ENERGY,
            None,
        );
        let audit = self.series(
            "Energy, µJ: stored (blue), friction's work (pink), unaccounted (orange)",
            paths::ENERGY,
            None,
        );
        let key = self.picture("Modes", paths::MODES_KEY, samples::mode_key_bounds());
        let left = Vertical::new([q, qdot]);
        let right = Vertical::new([energy, audit]);
        Horizontal::new([left.into(), key, right.into()])
            .with_column_shares(vec![1.0, 0.3, 1.0])
            .with_name("Modes")
            .into()
    }

    fn health_tab(&mut self) -> ContainerLike {
        let speed = self.series(
            "Speed: simulated seconds per second",
            paths::HEALTH_SPEED,
            None,
        );
        let work = self.series(
            "Per simulated ms: steps (blue), rejected (orange), right-hand sides (green), transitions (pink)",
            paths::HEALTH_WORK,
            None,
        );
        let queues = self.series(
            "Waiting: frames (blue), records (orange); pictures replaced (green)",
            paths::HEALTH_QUEUES,
            None,
        );
        let audit = self.series(
            "Energy audit: unaccounted, relative to what was turned over",
            paths::HEALTH_AUDIT,
            None,
        );
        let log: ContainerLike = TextLogView::new("Log").with_origin(paths::LOG).into();
        let left = Vertical::new([speed, work]);
        let right = Vertical::new([queues, audit]);
        let plots = Horizontal::new([left.into(), right.into()]);
        Vertical::new([plots.into(), log])
            .with_row_shares(vec![0.8, 0.2])
            .with_name("Health")
            .into()
    }

    fn about_tab(&mut self) -> ContainerLike {
        let about = self.text("About this recording", paths::ABOUT);
        Vertical::new([about]).with_name("About").into()
    }

    fn text(&mut self, name: &str, path: &str) -> ContainerLike {
        TextDocumentView::new(name).with_origin(path).into()
    }

    /// A time series of the last `window` s before the cursor, or of the whole run. A legend
    /// would cover data: the name says what the colours mean.
    fn series(&mut self, name: &str, path: &str, window: Option<f64>) -> ContainerLike {
        let view: ContainerLike = TimeSeriesView::new(name).with_origin(path).into();
        if let Some(window) = window {
            self.set(
                &view,
                &VisibleTimeRanges::new([VisibleTimeRange {
                    timeline: paths::TIMELINE.into(),
                    range: before_cursor(window),
                }]),
            );
        }
        self.set(&view, &PlotLegend::new().with_visible(false));
        view
    }

    /// Fixes the vertical range of a time series; an empty range is left to the viewer.
    fn range(&mut self, view: &ContainerLike, low: f64, high: f64) {
        if low < high {
            let range = rerun::components::Range1D::new(low, high);
            self.set(view, &ScalarAxis::new().with_range(range));
        }
    }

    /// A picture with its own axes, shown whole.
    fn picture(&mut self, name: &str, path: &str, bounds: Bounds) -> ContainerLike {
        let view: ContainerLike = Spatial2DView::new(name).with_origin(path).into();
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

    /// Ball and beam from the side, a little from above.
    fn body(&mut self, joint: &JointInfo, spec: RecordSpec) -> ContainerLike {
        let name = format!(
            "Ball and beam, motion drawn {} times larger",
            style::short(spec.exaggeration)
        );
        let view: ContainerLike = Spatial3DView::new(name)
            .with_origin(paths::SCENE_3D)
            .with_contents(
                [
                    paths::BODY,
                    paths::BODY_LEGEND,
                    paths::LOAD,
                    paths::ROTATION,
                    paths::RIM,
                ]
                .map(|path| format!("+ /{path}")),
            )
            .into();
        let vertices = &joint.outline.vertices;
        let lowest = vertices.iter().map(|v| v[2]).fold(-0.2, f64::min);
        let highest = 3.3 * joint.ball_radius;
        let middle = 1e3 * 0.5 * (lowest + highest);
        let distance = 1e3 * 1.12 * (highest - lowest);
        let eye = [0.80, -0.55, 0.22].map(|c: f64| c * distance);
        self.eye(
            &view,
            [eye[0], eye[1], middle + eye[2]],
            [0.0, 0.0, middle],
            [0.0, 0.0, 1.0],
        );
        view
    }

    /// The ball from above, near enough to see the patch at every tilt of the run.
    fn patch(&mut self, joint: &JointInfo) -> ContainerLike {
        let name = format!(
            "Contact patch; circles {}° apart",
            style::short(patch::circle_step(joint)),
        );
        let view: ContainerLike = Spatial3DView::new(name)
            .with_origin(paths::SCENE_3D)
            .with_contents(
                [
                    paths::NODES,
                    paths::FRICTION,
                    paths::RIM,
                    paths::TILT_CIRCLES,
                    paths::NODE_KEY,
                    paths::FRICTION_KEY,
                    paths::POLE,
                ]
                .map(|path| format!("+ /{path}")),
            )
            .into();
        let vantage = Vantage::new(joint);
        // A little from below, and aimed below the middle to make room for the key.
        let target = vantage.point([0.0, -0.12, 0.0]);
        let from = vantage.point([0.0, -0.6, 2.55]);
        self.eye(&view, from, target, vantage.up());
        view
    }

    fn embedding(&mut self) -> ContainerLike {
        let view: ContainerLike = Spatial3DView::new("Delay embedding of the displacement")
            .with_origin(paths::EMBEDDING)
            .into();
        self.eye(&view, [2.2, -2.65, 1.75], [0.0; 3], [0.0, 0.0, 1.0]);
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

    /// Joins the blueprint's own messages and the properties, and sends them.
    fn send(self, rec: &RecordingStream, blueprint: &Blueprint) -> Result<(), RecordError> {
        let (stream, storage) = RecordingStreamBuilder::new(APPLICATION).memory()?;
        blueprint.send(&stream, BlueprintActivation::default())?;
        let mut messages = Vec::new();
        let mut activation = None;
        for message in storage.take() {
            match message {
                LogMsg::BlueprintActivationCommand(command) => activation = Some(command),
                message if message.store_id().is_blueprint() => messages.push(message),
                // The memory recording's own introduction.
                _ => {}
            }
        }
        let Some(activation): Option<BlueprintActivationCommand> = activation else {
            return Err(RecordError::Encode(
                "the blueprint has no activation".to_owned(),
            ));
        };

        let store = RecordingStreamBuilder::from_store_id(&activation.blueprint_id);
        let (stream, storage) = store.memory()?;
        stream.set_log_tick_enabled(false);
        stream.set_log_time_enabled(false);
        stream.set_time_sequence("blueprint", 0);
        for (path, batches) in self.properties {
            stream.log_serialized_batches(path, false, batches)?;
        }
        let properties = storage.take().into_iter();
        messages.extend(properties.filter(|m| matches!(m, LogMsg::ArrowMsg(..))));
        rec.send_blueprint(messages, activation);
        Ok(())
    }
}

/// The last `window` s before the time cursor.
fn before_cursor(window: f64) -> TimeRange {
    TimeRange {
        start: TimeRangeBoundary::CursorRelative(TimeInt(-stream::nanos(window))),
        end: TimeRangeBoundary::AT_CURSOR,
    }
}
