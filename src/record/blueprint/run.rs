//! The layout of a run: a joint, a small system or a signal.

use re_sdk_types::blueprint::{
    archetypes::TimePanelBlueprint,
    components::{PanelState, PlayState},
};

use super::{
    layout::{Row, named, tab},
    tree::{self, Container, Part, View},
};
use crate::{
    pipeline::message::{AnalysisKind, Header, JointInfo, Subject},
    plot::{Unit, prediction_panel},
    record::{
        camera::Camera,
        controls,
        error::RecordError,
        lesson,
        panel_view::PanelView,
        patch,
        paths::{self, Root},
        samples, small,
        stream::RecordingStream,
        style,
    },
    scene::{Evidence, RecordSpec},
};

/// Playback speed of a joint, simulated seconds per second; others play in [`PLAYS`].
const JOINT_SPEED: f64 = 0.01;
/// Playback time of a signal or a small system, s.
const PLAYS: f64 = 30.0;
/// Time window of the series of a joint, s: about twenty periods of a 4 kHz squeak.
pub const WINDOW: f64 = 5e-3;
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
        let lesson = run.lesson_tab().map_or(Vec::new(), |key| tabs(&[&key]));
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
    fn lesson_tab(&self) -> Option<String> {
        let evidence = self.header.computed.as_deref()?.mechanism.evidence();
        let is_small = self.header.joint().is_none()
            && matches!(evidence, Evidence::Growth | Evidence::Contact);
        let evidence: &str = evidence.into();
        Some(format!(
            "lesson-{evidence}{}",
            if is_small { "-small" } else { "" }
        ))
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
                let last = Unit::write(window, "s");
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
                let title = format!("{}, {}", style::signal_name(signal), signal.unit);
                let title = title.trim_end_matches(", ");
                let [low, high] = signal.span;
                let margin = 0.05 * (high - low);
                let range = [low - margin, high + margin];
                match name {
                    "waveform-near" => {
                        let window =
                            (SIGNAL_PERIODS / signal.highest_frequency).min(header.duration);
                        let last = Unit::write(window, "s");
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
            "displacement" => series("Displacement u, µm (last 5 ms)", paths::DISPLACEMENT)
                .with_range(displacement_range(joint)),
            "velocity" => series("Velocity v, mm/s (last 5 ms)", paths::VELOCITY)
                .with_range([-2e3 * speed, 2e3 * speed]),
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
            "mode-colours" => {
                View::picture("Modes", paths::MODES_LEGEND, samples::mode_legend_bounds())
            }
            _ => return self.common_view(name),
        })
    }

    /// A view of any subject: of an analysis, or of the program.
    fn common_view(&self, name: &str) -> Option<View> {
        let (name, argument) = name.split_once(' ').unwrap_or((name, ""));
        let header = self.header;
        match name {
            "both-displacements" if header.has(AnalysisKind::PerturbedTrajectory) => {
                let name = "Displacement u of both trajectories, µm (last 5 ms)";
                let both = [paths::DISPLACEMENT, paths::PERTURBED_DISPLACEMENT];
                let view = View::series_of(name, &both).with_window(WINDOW);
                return Some(match header.joint() {
                    Some(joint) => view.with_range(displacement_range(joint)),
                    None => view,
                });
            }
            "computed" => {
                let picture = header.computed.as_deref()?.picture.as_ref()?;
                return Some(PanelView::of(name, &Root::of_run()).view(&prediction_panel(picture)));
            }
            "line-over-tilt" => {
                let panel = lesson::empty_loop(header)?.with_title(Row::of(name)?.title);
                return Some(PanelView::of(name, &Root::of_run()).view(&panel));
            }
            _ => {}
        }
        let row = Row::of(name)?;
        let has_data = match row.needs {
            "" => true,
            "Joint" => header.joint().is_some(),
            "Energy" => header.joint().is_some() && self.spec.energy_rate > 0.0,
            analysis => header
                .analyses
                .iter()
                .any(|kind| format!("{kind:?}") == analysis),
        };
        if !has_data {
            return None;
        }
        let of = |what: &str| match header.subject {
            Subject::Signal(_) => String::new(),
            Subject::Joint(_) | Subject::Small(_) => format!(" of the {what}"),
        };
        let title = row.title.replace("{velocity}", &of("velocity"));
        let title = title.replace("{displacement}", &of("displacement"));
        let frequency = Unit::of("Hz", header.highest_frequency()).symbol;
        row.view(title.replace("{frequency}", &frequency), argument)
    }
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
