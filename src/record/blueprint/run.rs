//! The layout of a run: a joint, a small system or a signal.

use rerun::external::re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint,
    components::{Corner2D, PanelState, PlayState},
};

use super::{
    layout::{named, tab},
    tree::{self, Container, Part, View},
};
use crate::{
    pipeline::message::{AnalysisKind, Header, JointInfo, Subject},
    plot::prediction_panel,
    record::{
        camera::Camera, chaos::Chaos, controls, delay::Delay, error::RecordError,
        exponents::ExponentsPlot, lesson, patch, paths, perturbed::PerturbedTrajectory,
        plot::Bounds, portrait::Portrait, recurrence::Recurrence, samples, section::Section, small,
        spectrum, stream::RecordingStream, style,
    },
    scene::{Mechanism, RecordSpec},
};

/// Playback speed of a joint, simulated seconds per second; others play in [`PLAYS`].
const JOINT_SPEED: f64 = 0.01;
/// Playback time of a signal or a small system, s.
const PLAYS: f64 = 30.0;
/// Time window of the series of a joint, s: about twenty periods of a 4 kHz squeak.
const WINDOW: f64 = 5e-3;
/// Natural periods in the time window of a small system.
const SMALL_PERIODS: f64 = 12.0;
/// Periods of the highest frequency shown that the detail of a signal covers.
const SIGNAL_PERIODS: f64 = 100.0;
/// Minimum number of contact snapshots in the time window of a series.
const SNAPSHOTS: f64 = 50.0;

/// The tabs of each subject; of a scene with a mechanism, its lesson comes first.
const JOINT: &[&str] = &["overview", "contact", "modes"];
const SMALL: &[&str] = &["overview-small"];
const SIGNAL: &[&str] = &[
    "overview-signal",
    "embedding",
    "recurrence",
    "regime",
    "about-signal",
];
const ANALYSES: &[&str] = &["embedding", "recurrence", "regime", "lyapunov", "perturbed"];
const LAST: &[&str] = &["solver", "about"];

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
    let run = Run { header, spec };
    let tabs = |keys: &[&str]| -> Vec<Part> {
        let tabs = keys.iter().filter(|key| run.has_tab(key));
        tabs.filter_map(|key| tab(key, &mut |name| run.view(name)))
            .collect()
    };
    let (mut shown, speed) = match &header.subject {
        Subject::Joint(_) => (tabs(JOINT), JOINT_SPEED),
        Subject::Small(_) => (tabs(SMALL), header.duration / PLAYS),
        Subject::Signal(_) => (tabs(SIGNAL), header.duration / PLAYS),
    };
    if !matches!(header.subject, Subject::Signal(_)) {
        let lesson = run.lesson_tab().map_or(Vec::new(), |key| tabs(&[key]));
        shown.splice(..0, lesson);
        shown.extend(tabs(ANALYSES));
        shown.extend(controls_tab(header));
        shown.extend(tabs(LAST));
    }
    shown.rotate_left(first);
    let time_panel = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(paths::TIMELINE)
        .with_playback_speed(speed)
        .with_play_state(PlayState::Following);
    tree::send(rec, shown, &time_panel)
}

/// The numbers that commands change during a live run: those that the scene names.
fn controls_tab(header: &Header) -> Option<Part> {
    let controls = controls::recorded(header).filter(|control| control.is_named);
    let views = controls.map(|control| {
        let [path, name] = controls::series(control);
        Part::View(View::series(name, &path))
    });
    let views: Vec<Part> = views.collect();
    let shares = vec![1.0; views.len()];
    (!views.is_empty()).then(|| named("Controls", Container::column(views, shares).into()))
}

/// What the views of a run depend on.
struct Run<'a> {
    header: &'a Header,
    spec: RecordSpec,
}

impl Run<'_> {
    /// The tab of the lesson, if the scene has one.
    fn lesson_tab(&self) -> Option<&'static str> {
        let is_joint = self.header.joint().is_some();
        Some(match self.header.computed.as_deref()?.mechanism {
            Mechanism::NegativeSlope
            | Mechanism::ModeCoupling
            | Mechanism::ExchangedFriction
            | Mechanism::Bristles
            | Mechanism::ContactAge
            | Mechanism::MeasuredFriction => {
                if is_joint {
                    "lesson-growth"
                } else {
                    "lesson-growth-small"
                }
            }
            Mechanism::Articulation => "lesson-turning",
            Mechanism::StickSlip | Mechanism::LiftOff => {
                if is_joint {
                    "lesson-contact"
                } else {
                    "lesson-contact-small"
                }
            }
            Mechanism::WhichModeWins | Mechanism::Prediction => "lesson-modes",
            Mechanism::Hysteresis => "lesson-loop",
            Mechanism::Torus => "lesson-torus",
            Mechanism::TorusBirth => "lesson-birth",
            Mechanism::Chaos => "lesson-divergence",
        })
    }

    /// Whether a tab is shown that has views in other tabs, too.
    fn has_tab(&self, key: &str) -> bool {
        match key {
            "contact" => self.spec.patch_rate > 0.0,
            "embedding" => {
                self.header.has(AnalysisKind::Delay) || self.header.has(AnalysisKind::Section)
            }
            "recurrence" => self.header.has(AnalysisKind::Quantification),
            _ => true,
        }
    }

    /// A view by its name in the layout; `None` if the run has no data for it.
    fn view(&self, name: &str) -> Option<View> {
        let header = self.header;
        match &header.subject {
            Subject::Joint(joint) => self.joint_view(joint, name),
            Subject::Small(info) => {
                let window = (SMALL_PERIODS / info.frequency_hz).min(header.duration);
                let last = style::Quantity::Time.format(window);
                let series = |name: String, path| View::series(name, path).with_window(window);
                Some(match name {
                    "displacement" => series(
                        format!("Displacement x, µm (last {last})"),
                        paths::DISPLACEMENT,
                    ),
                    "velocity" => {
                        series(format!("Velocity v, mm/s (last {last})"), paths::VELOCITY)
                    }
                    "velocity-of-lesson" => {
                        let key = small::key(info);
                        series(
                            format!("Velocity, mm/s (last {last}): {key}"),
                            paths::VELOCITY,
                        )
                    }
                    "status" => {
                        let name = format!("Status: {}", small::key(info));
                        View::states(name, paths::STATUS).with_window(window)
                    }
                    _ => return self.common_view(name),
                })
            }
            Subject::Signal(signal) => {
                let title = style::with_unit(style::signal_name(signal), &signal.unit);
                let [low, high] = signal.span;
                let margin = 0.05 * (high - low);
                let range = [low - margin, high + margin];
                match name {
                    "waveform-near" => {
                        let window =
                            (SIGNAL_PERIODS / signal.highest_frequency).min(header.duration);
                        let last = style::Quantity::Time.format(window);
                        let near = View::series(format!("{title} (last {last})"), paths::WAVEFORM);
                        Some(near.with_window(window).with_range(range))
                    }
                    "waveform" => {
                        let name = format!("{title} (whole signal)");
                        Some(View::series(name, paths::WAVEFORM).with_range(range))
                    }
                    _ => self.common_view(name),
                }
            }
        }
    }

    /// A view of a joint.
    fn joint_view(&self, joint: &JointInfo, name: &str) -> Option<View> {
        let series = |name, path| View::series(name, path).with_window(WINDOW);
        let spec = self.spec;
        let speed = joint.largest_sliding_speed();
        Some(match name {
            "body" => body(joint, spec),
            "patch" => patch_view(joint),
            "portrait-of-centre" => {
                let name = "Phase portrait of the patch centre";
                View::picture(name, paths::PORTRAIT, Portrait::bounds())
            }
            "displacement" => series("Displacement u, µm (last 5 ms)", paths::DISPLACEMENT)
                .with_range(displacement_range(joint)),
            "velocity" => series("Velocity v, mm/s (last 5 ms)", paths::VELOCITY)
                .with_range([-2e3 * speed, 2e3 * speed]),
            "velocity-of-lesson" => series("Velocity, mm/s (last 5 ms)", paths::VELOCITY),
            "tilt-in-range" => {
                let reach = joint.tilt_range.unwrap_or([joint.min_tilt, joint.max_tilt]);
                let [lowest, highest] = reach.map(|tilt| 1.15 * tilt.to_degrees());
                let least = if lowest < 0.0 { 0.0 } else { 1.0 };
                let tilt = self.common_view("tilt")?;
                tilt.with_range([lowest.min(0.0), highest.max(least)])
            }
            "load" if joint.load_varies() => View::series("Load, N (whole run)", paths::LOAD_NOW)
                .with_range([0.0, 1.15 * joint.largest_load()]),
            "rotation" if joint.rotation_varies() => {
                let [low, high] = joint.rotation_span;
                View::series("Rotation factor (whole run)", paths::ROTATION_FACTOR)
                    .with_range([1.15 * low.min(0.0), 1.15 * high])
            }
            "node-counts" | "contact-force" if spec.patch_rate > 0.0 => {
                let rate = style::short(1e-3 * spec.patch_rate);
                let window = WINDOW.max(SNAPSHOTS / spec.patch_rate);
                if name == "node-counts" {
                    let name =
                        "Number of nodes slipping (blue), sticking (orange), separated (white)";
                    View::series(format!("{name}; {rate} kHz snapshots"), paths::NODE_COUNTS)
                        .with_window(window)
                } else {
                    let name = "Contact force on the ball, N: normal (yellow), friction (pink)";
                    View::series(
                        format!("{name}; {rate} kHz snapshots"),
                        paths::CONTACT_FORCE,
                    )
                    .with_window(window)
                    .with_range([0.0, 1.6 * joint.largest_load()])
                }
            }
            "modal-coordinates" => series("Modal coordinates, √kg µm (last 5 ms)", paths::MODES_Q),
            "modal-velocities" => {
                series("Modal velocities, √kg mm/s (last 5 ms)", paths::MODES_QDOT)
            }
            "mode-colours" => {
                View::picture("Modes", paths::MODES_LEGEND, samples::mode_legend_bounds())
            }
            "modal-energy" if spec.energy_rate > 0.0 => View::series(
                "Vibration energy of each mode, µJ (whole run)",
                paths::MODES_ENERGY,
            ),
            "energy" if spec.energy_rate > 0.0 => View::series(
                "Energy, µJ: stored (blue), work of friction (pink), residual of the balance (orange)",
                paths::ENERGY,
            ),
            "energy-of-lesson" if spec.energy_rate > 0.0 => View::series(
                "Energy of each mode, µJ (whole run); colours: tab “Modes”",
                paths::MODES_ENERGY,
            ),
            // The energy balance is known for a joint only.
            "energy-residual" => View::series(
                "Energy audit: residual over the exchanged energy",
                paths::SOLVER_ENERGY_RESIDUAL,
            ),
            _ => return self.common_view(name),
        })
    }

    /// A view of any subject: of an analysis, or of the program.
    fn common_view(&self, name: &str) -> Option<View> {
        let (name, argument) = name.split_once(' ').unwrap_or((name, ""));
        if needed(name).is_some_and(|kind| !self.header.has(kind)) {
            return None;
        }
        let view = self
            .picture(name)
            .map(|(title, path, bounds)| View::picture(title, path, bounds))
            .or_else(|| text(name).map(|(title, path)| View::text(title, path)))
            .or_else(|| series(name).map(|(title, path)| View::series(title, path)))
            .or_else(|| {
                let (title, paths, corner) = with_legend(name)?;
                Some(View::with_legend(title, paths, corner))
            });
        Some(match (name, view) {
            ("recurrence-shares" | "confidence" | "solver-error", Some(view)) => {
                // An accepted step has a ratio of at most 1; the margin keeps a value of 1 visible.
                view.with_range([0.0, 1.05])
            }
            ("zero-one", Some(view)) => view.with_range([-0.1, 1.1]),
            (_, Some(view)) => view,
            ("log", None) => View::log("Log", paths::LOG),
            // A narrow view needs a larger distance.
            ("embedding", None) => {
                let of = if self.is_signal() {
                    ""
                } else {
                    " of the displacement"
                };
                let name = format!("Delay embedding{of}");
                View::cube(name, paths::EMBEDDING, argument.parse().ok()?)
            }
            ("running-exponents", None) => View::series_of(
                "Running Lyapunov exponents λ, 1/s, with 95 % intervals (whole run)",
                &[paths::EXPONENTS_RUNNING, paths::EXPONENTS_ZERO],
            ),
            ("both-displacements", None) => {
                let name = "Displacement u of both trajectories, µm (last 5 ms)";
                let both = [paths::DISPLACEMENT, paths::PERTURBED_DISPLACEMENT];
                let view = View::series_of(name, &both).with_window(WINDOW);
                match self.header.joint() {
                    Some(joint) => view.with_range(displacement_range(joint)),
                    None => view,
                }
            }
            _ => return None,
        })
    }

    fn is_signal(&self) -> bool {
        matches!(self.header.subject, Subject::Signal(_))
    }

    /// Title, path and bounds of a plot with its own axes.
    fn picture(&self, name: &str) -> Option<(String, &'static str, Bounds)> {
        let header = self.header;
        let of = if self.is_signal() {
            ""
        } else {
            " of the velocity"
        };
        let (title, path, bounds) = match name {
            "spectrum" => {
                let plot = spectrum::SpectrumPlot::new(header);
                let title = format!("Spectrum{of} (lines in {})", plot.frequency.symbol);
                return Some((title, paths::SPECTRUM, plot.plot().bounds()));
            }
            "spectrogram" => {
                let bounds = spectrum::spectrogram_plot(header).plot.bounds();
                return Some((format!("Spectrogram{of}"), paths::SPECTROGRAM, bounds));
            }
            "computed" => {
                let picture = header.computed.as_deref()?.picture.as_ref()?;
                let title = prediction_panel(picture).title;
                return Some((
                    title,
                    paths::LESSON_COMPUTED,
                    lesson::picture_bounds(picture),
                ));
            }
            "line-over-tilt" => (
                "Strongest line over tilt: increasing (blue), decreasing (orange)",
                paths::HYSTERESIS,
                lesson::loop_bounds(header)?,
            ),
            "portrait" => ("Phase portrait", paths::PORTRAIT, Portrait::bounds()),
            "recurrence" => (
                "Recurrence plot (bright: recurrent)",
                paths::RECURRENCE,
                Recurrence::bounds(),
            ),
            "mutual-information" => (
                "Delay τ: mutual information",
                paths::DELAY_MUTUAL,
                Delay::bounds(),
            ),
            "false-neighbours" => (
                "Dimension m: false nearest neighbours",
                paths::DELAY_NEIGHBOURS,
                Delay::bounds(),
            ),
            "section" => ("Poincaré section", paths::SECTION, Section::bounds()),
            "return-map" => ("Return map", paths::RETURN_MAP, Section::bounds()),
            "divergence" => (
                "Divergence of nearby states",
                paths::DIVERGENCE,
                Chaos::divergence_bounds(),
            ),
            "zero-one-path" => (
                "0-1 test: bounded path or random walk",
                paths::ZERO_ONE_PICTURE,
                Chaos::path_bounds(),
            ),
            "largest-exponent" => (
                "Largest Lyapunov exponent λ ± error of each window",
                paths::EXPONENT,
                Chaos::exponent_bounds(),
            ),
            "lyapunov-spectrum" => (
                "Current Lyapunov spectrum",
                paths::EXPONENTS_SPECTRUM,
                ExponentsPlot::bounds(),
            ),
            "both-portraits" => (
                "Phase portraits of both trajectories (last 4 ms)",
                paths::DIVERGENCE_PORTRAIT,
                PerturbedTrajectory::bounds(),
            ),
            _ => return None,
        };
        Some((title.to_owned(), path, bounds))
    }
}

/// The analysis without which a view has no data.
fn needed(name: &str) -> Option<AnalysisKind> {
    Some(match name {
        "spectrum" => AnalysisKind::Spectrum,
        "spectrogram" => AnalysisKind::Spectrogram,
        "recurrence" | "embedding" => AnalysisKind::Recurrence,
        "mutual-information" | "false-neighbours" => AnalysisKind::Delay,
        "section" | "return-map" => AnalysisKind::Section,
        "verdict" | "confidence" => AnalysisKind::Regime,
        "divergence" | "zero-one-path" | "largest-exponent" | "zero-one" => AnalysisKind::Chaos,
        "running-exponents" | "lyapunov-spectrum" | "exponents-text" => AnalysisKind::Exponents,
        "both-displacements" | "distance" | "both-portraits" | "divergence-text" => {
            AnalysisKind::PerturbedTrajectory
        }
        _ => return None,
    })
}

/// Title and path of a text.
fn text(name: &str) -> Option<(&'static str, &'static str)> {
    Some(match name {
        "observations" => ("Observations", paths::NARRATION),
        "classification" => ("Classification", paths::NARRATION),
        "lesson" => ("Lesson", paths::LESSON),
        "about" => ("About this recording", paths::ABOUT),
        "verdict" => ("Classification", paths::REGIME_VERDICT),
        "exponents-text" => ("Exponents and attractor", paths::EXPONENTS_TEXT),
        "divergence-text" => ("Divergence", paths::DIVERGENCE_TEXT),
        "solver-text" => ("Current accuracy and cost", paths::SOLVER_TEXT),
        _ => return None,
    })
}

/// Title and path of a time series without a legend.
fn series(name: &str) -> Option<(&'static str, &'static str)> {
    Some(match name {
        "tilt" => ("Tilt of the load, deg (whole run)", paths::TILT),
        "zero-one" => ("0-1 test: K (0 regular, 1 chaotic)", paths::ZERO_ONE),
        "solver-error" => (
            "Largest local error estimate per frame, over the tolerance",
            paths::SOLVER_ERROR,
        ),
        "evaluations" => (
            "Right-hand-side evaluations per simulated ms",
            paths::SOLVER_RHS_EVALS,
        ),
        "speed" => (
            "Simulation speed, simulated seconds per second",
            paths::SOLVER_SPEED,
        ),
        "steps" => (
            "Per simulated ms: steps (blue), rejected steps (orange), transitions (green)",
            paths::SOLVER_STEPS,
        ),
        "queues" => (
            "Queues: frames (blue), records (orange); replaced pictures (green)",
            paths::SOLVER_QUEUES,
        ),
        _ => return None,
    })
}

/// Title and paths of time series with a legend, and the corner of the legend: where a clear motion has no points.
fn with_legend(name: &str) -> Option<(&'static str, &'static [&'static str], Corner2D)> {
    Some(match name {
        "level" => (
            "Velocity level: log₁₀ of mm/s (blue); computed growth (orange)",
            &[paths::LESSON_VELOCITY_LEVEL, paths::LESSON_PREDICTED],
            Corner2D::RightBottom,
        ),
        "distance" => (
            "log₁₀ of the distance of both trajectories, relative to the motion (whole run)",
            &[paths::DIVERGENCE_DISTANCE, paths::DIVERGENCE_FIT],
            Corner2D::RightBottom,
        ),
        "confidence" => (
            "Confidence of each type of motion (0 to 1)",
            &[paths::REGIME_CONFIDENCE],
            Corner2D::RightBottom,
        ),
        "recurrence-shares" => (
            "Recurrence rate RR, determinism DET, laminarity LAM (0 to 1)",
            &[
                paths::RECURRENCE_RATE,
                paths::DETERMINISM,
                paths::LAMINARITY,
            ],
            Corner2D::LeftTop,
        ),
        "diagonals" => (
            "Diagonal lines: mean length L, longest Lmax",
            &[paths::MEAN_DIAGONAL, paths::LONGEST_DIAGONAL],
            Corner2D::LeftTop,
        ),
        "recurrence-times" => (
            "Period, recurrence times T1 and T2, trapping time TT",
            &[
                paths::PERIOD,
                paths::RECURRENCE_TIME_1,
                paths::RECURRENCE_TIME_2,
                paths::TRAPPING_TIME,
            ],
            Corner2D::LeftTop,
        ),
        "entropy" => (
            "Entropy ENTR of diagonal line lengths; divergence DIV = 1/Lmax",
            &[paths::ENTROPY, paths::DIVERGENCE_RATE],
            Corner2D::LeftTop,
        ),
        "trend" => (
            "TREND: drift of the recurrence rate",
            &[paths::TREND],
            Corner2D::LeftTop,
        ),
        _ => return None,
    })
}

/// Range of the displacement, µm. A squeak grows until the slip just reverses, so its velocity is of the order of the
/// sliding speed, and its displacement at most that of the lowest mode at this velocity.
fn displacement_range(joint: &JointInfo) -> [f64; 2] {
    let largest = joint.modes.first().map_or(0.0, |lowest| {
        joint.largest_sliding_speed() / (std::f64::consts::TAU * lowest.frequency_hz)
    });
    [-1e6 * largest, 1e6 * largest]
}

/// The body from the side, slightly from above.
fn body(joint: &JointInfo, spec: RecordSpec) -> View {
    let name = match (joint.outline.vertices.is_empty(), spec.body_rate > 0.0) {
        (true, true) => format!("{}: load and rotation (surface not known)", joint.body),
        (true, false) => format!("{}: load and rotation", joint.body),
        (false, _) => format!(
            "{}, displacements × {}",
            joint.body,
            style::short(spec.deformation_scale)
        ),
    };
    let vertices = &joint.outline.vertices;
    let lowest = vertices.iter().map(|v| v[2]).fold(-0.2, f64::min);
    let highest = 3.3 * joint.ball_radius;
    let middle = 1e3 * 0.5 * (lowest + highest);
    let distance = 1e3 * 1.12 * (highest - lowest);
    let eye = [0.80, -0.55, 0.22].map(|c: f64| c * distance);
    let entities = [
        paths::BODY,
        paths::BODY_LEGEND,
        paths::LOAD,
        paths::ROTATION,
        paths::RIM,
    ];
    View::in_3d(name)
        .with_origin(paths::SCENE_3D)
        .with_contents(&entities)
        .with_eye(
            [eye[0], eye[1], middle + eye[2]],
            [0.0, 0.0, middle],
            [0.0, 0.0, 1.0],
        )
}

/// The ball from above; the patch is visible at every tilt of the run.
fn patch_view(joint: &JointInfo) -> View {
    let step = style::short(patch::circle_step(joint));
    let entities = [
        paths::NODES,
        paths::FRICTION,
        paths::RIM,
        paths::TILT_CIRCLES,
        paths::NODE_LEGEND,
        paths::FRICTION_LEGEND,
        paths::POLE,
    ];
    let camera = Camera::new(joint);
    // The view is tilted slightly, and aimed below the centre to show the legend.
    let target = camera.point([0.0, -0.12, 0.0]);
    let from = camera.point([0.0, -0.6, 2.55]);
    View::in_3d(format!("Contact patch (circles {step}° apart)"))
        .with_origin(paths::SCENE_3D)
        .with_contents(&entities)
        .with_eye(from, target, camera.up())
}
