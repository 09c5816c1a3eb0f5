//! The layout of a run: a joint, a small system or a signal.

use re_sdk_types::blueprint::{archetypes::TimePanelBlueprint, components::PlayState};

use super::layout::{Row, tab};
use super::tree::{self, Part, View};
use crate::pipeline::message::{Header, JointInfo, Subject};
use crate::plot::response::WINDOW;
use crate::plot::{Panel, Unit, letter, prediction_panel};
use crate::record::camera::Camera;
use crate::record::figures::series_panel;
use crate::record::panel_view::PanelView;
use crate::record::paths::{self, Root};
use crate::record::stream::RecordingStream;
use crate::record::{controls, lesson, patch, samples, small, style};
use crate::scene::{Evidence, RecordSpec};

/// Playback speed of a joint, simulated seconds per second; others play in [`PLAYS`].
const JOINT_SPEED: f64 = 0.01;
/// Playback time of a signal or a small system, s.
const PLAYS: f64 = 30.0;
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

/// Sends the layout of a run with the tabs rotated, so that tab `first` is the one that the viewer opens.
pub fn send(rec: &RecordingStream, header: &Header, spec: RecordSpec, first: usize) {
    let run = Run { header, spec };
    let tabs = |keys: &[&str]| -> Vec<Part> {
        let keys = keys.iter().filter(|key| run.has_tab(key));
        let tabs = keys.filter_map(|key| tab(key, &mut |name| run.view(name)));
        tabs.collect()
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
        .with_timeline(paths::TIMELINE)
        .with_playback_speed(speed)
        .with_play_state(PlayState::Following);
    tree::send(rec, shown, time_panel);
}

/// The numbers that commands change during a live run: those that the scene names.
fn controls_tab(header: &Header) -> Option<Part> {
    let controls = controls::recorded(header).filter(|control| control.is_named);
    let views = controls.map(|control| {
        let [path, name] = controls::series(control);
        Part::View(View::series(name, &[&path], None))
    });
    let views: Vec<Part> = views.collect();
    (!views.is_empty()).then(|| Part::tab("Controls", views))
}

/// What the views of a run depend on.
pub struct Run<'a> {
    /// The header of the run.
    pub header: &'a Header,
    /// What the scene records.
    pub spec: RecordSpec,
}

impl Run<'_> {
    /// The tab of the lesson, if the scene has one.
    fn lesson_tab(&self) -> Option<String> {
        let evidence = self.header.computed.as_deref()?.mechanism.evidence();
        let is_small = self.header.joint().is_none()
            && matches!(evidence, Evidence::Growth | Evidence::Contact);
        let evidence: &str = evidence.into();
        let ending = if is_small { "-small" } else { "" };
        Some(format!("lesson-{evidence}{ending}"))
    }

    /// Whether a tab is shown that has views in other tabs, too.
    fn has_tab(&self, key: &str) -> bool {
        match key {
            "contact" => self.spec.patch_rate > 0.0,
            "embedding" => self.has_data("delay") || self.has_data("section"),
            "recurrence" => self.has_data("quantification"),
            _ => true,
        }
    }

    /// A view by its name in the layout; `None` if the run has no data for it.
    fn view(&self, name: &str) -> Option<View> {
        let (name, argument) = name.split_once(' ').unwrap_or((name, ""));
        let header = self.header;
        match (name, header.joint()) {
            ("body", Some(joint)) => return Some(body(joint, self.spec)),
            ("patch", Some(joint)) => return Some(patch_view(joint)),
            ("mode-colours", Some(_)) => {
                let bounds = samples::mode_legend_bounds();
                return Some(View::picture("Modes", paths::MODES_LEGEND, bounds));
            }
            ("computed", _) => {
                let picture = header.computed.as_deref()?.picture.as_ref()?;
                return Some(PanelView::of(name, &Root::of_run()).view(&prediction_panel(picture)));
            }
            ("line-over-tilt", _) => {
                let panel = lesson::empty_loop(header)?.with_title(Row::of(name)?.title_with(&[]));
                return Some(PanelView::of(name, &Root::of_run()).view(&panel));
            }
            _ => {}
        }
        let row = Row::of(name).filter(|row| self.has_data(row.needs))?;
        let view = row.view(self.title(&row), argument)?;
        let range = self.range(name).or_else(|| row.range());
        Some(view.with_window(self.window_of(&row)).with_range(range))
    }

    /// Whether the run has what a view needs.
    fn has_data(&self, needs: &str) -> bool {
        let joint = self.header.joint();
        let is_joint = |condition: &dyn Fn(&JointInfo) -> bool| joint.is_some_and(condition);
        match needs {
            "" => true,
            "joint" => is_joint(&|_| true),
            "energy" => is_joint(&|_| self.spec.energy_rate > 0.0),
            "patch" => is_joint(&|_| self.spec.patch_rate > 0.0),
            "load" => is_joint(&JointInfo::load_varies),
            "rotation" => is_joint(&JointInfo::rotation_varies),
            analysis => self.header.analysis.names().contains(&analysis),
        }
    }

    /// A view as a panel of a figure, from what a stream for figures has kept.
    pub fn panel(&self, rec: &RecordingStream, name: &str) -> Option<Panel> {
        let Some(row) = Row::of(name) else {
            return rec.panel(name);
        };
        let mut row = Some(row).filter(|row| self.has_data(row.needs))?;
        row.key = "";
        let window = self.window_of(&row);
        let curves = row.paths.iter().flat_map(|path| rec.curves(path, window));
        let start = self.header.start();
        let run = [start, start + self.header.duration];
        let whole = Some(run).filter(|_| window.is_infinite());
        let series = series_panel(&self.title(&row), curves, whole);
        let mut panel = series.or_else(|| rec.panel(row.paths[0]))?;
        panel.y.range = row.range().unwrap_or(panel.y.range);
        Some(panel)
    }

    /// Time window of a view, s; infinite for the whole run.
    fn window_of(&self, row: &Row) -> f64 {
        match row.kind[0] {
            "recent" | "states" => self.window(),
            "snapshots" => WINDOW.max(SNAPSHOTS / self.spec.patch_rate),
            _ => f64::INFINITY,
        }
    }

    /// Time window of recent series, s.
    fn window(&self) -> f64 {
        match &self.header.subject {
            Subject::Joint(_) => WINDOW,
            Subject::Small(small) => (SMALL_PERIODS / small.frequency_hz).min(self.header.duration),
            Subject::Signal(signal) => {
                (SIGNAL_PERIODS / signal.highest_frequency).min(self.header.duration)
            }
        }
    }

    /// The title of a view with its placeholders replaced.
    fn title(&self, row: &Row) -> String {
        let subject = &self.header.subject;
        let of_run = [" of the velocity", " of the displacement"];
        let none = String::new;
        let last = Some(self.window_of(row)).filter(|window| window.is_finite());
        let last = last.map_or_else(none, |window| Unit::write(window, "s"));
        let ([velocity, displacement], key, signal) = match subject {
            Subject::Joint(_) => (of_run, none(), none()),
            Subject::Small(small) => (of_run, format!(": {}", small::key(small)), none()),
            Subject::Signal(signal) => ([""; 2], none(), style::signal_title(signal)),
        };
        let values = [
            ("{velocity}", velocity),
            ("{displacement}", displacement),
            (
                "{frequency}",
                &Unit::of("Hz", self.header.highest_frequency()).symbol,
            ),
            ("{letter}", letter(subject)),
            ("{last}", &last),
            ("{rate}", &style::short(1e-3 * self.spec.patch_rate)),
            ("{key}", &key),
            ("{signal}", &signal),
        ];
        row.title_with(&values)
    }

    /// The range of a series whose size is known before the run.
    fn range(&self, name: &str) -> Option<[f64; 2]> {
        if let Subject::Signal(signal) = &self.header.subject {
            let [low, high] = signal.span;
            let margin = 0.05 * (high - low);
            let is_signal = ["waveform", "waveform-near"].contains(&name);
            return is_signal.then_some([low - margin, high + margin]);
        }
        let joint = self.header.joint()?;
        Some(match name {
            "displacement" | "both-displacements" => displacement_range(joint),
            "velocity" => [-2e3, 2e3].map(|factor| factor * joint.largest_sliding_speed()),
            "tilt-in-range" => {
                let reach = joint.tilt_range.unwrap_or([joint.min_tilt, joint.max_tilt]);
                let [lowest, highest] = reach.map(|tilt| 1.15 * tilt.to_degrees());
                let least = if lowest < 0.0 { 0.0 } else { 1.0 };
                [lowest.min(0.0), highest.max(least)]
            }
            "load" => [0.0, 1.15 * joint.largest_load()],
            "rotation" => {
                let [low, high] = joint.rotation_span;
                [1.15 * low.min(0.0), 1.15 * high]
            }
            "contact-force" => [0.0, 1.6 * joint.largest_load()],
            _ => return None,
        })
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
        (false, _) => {
            let scale = style::short(spec.deformation_scale);
            format!("{}, displacements × {scale}", joint.body)
        }
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
    View::of("3D", name, paths::SCENE_3D)
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
    let camera = Camera::new(joint);
    // The view is tilted slightly, and aimed below the centre to show the legend.
    let target = camera.point([0.0, -0.12, 0.0]);
    let from = camera.point([0.0, -0.6, 2.55]);
    let name = format!("Contact patch (circles {step}° apart)");
    View::of("3D", name, paths::SCENE_3D)
        .with_contents(&["joint/patch/**"])
        .with_eye(from, target, camera.up())
}
