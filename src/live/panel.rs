//! Main numbers of a live run, for the control panel.

use std::collections::VecDeque;
use std::iter::once;
use std::path::Path;
use std::sync::{Arc, Mutex};

use serde::Serialize;

use super::command::Promise;
use super::lock;
use super::tour::TourStep;
use crate::analysis::{regime::Regime, stats::range};
use crate::escape;
use crate::number::{counted, format_range};
use crate::pipeline::message::{
    Appearance, ContactSample, Frame, Header, Lesson, Observation, Record, SpectralLine,
};
use crate::pipeline::{RunState, Sink, SinkError};
use crate::scene::{Control, Parameter};
use crate::text::{self, capitalize};

/// Number of events on the panel.
const EVENTS: usize = 12;
/// Number of spectral lines on the panel.
const LINES: usize = 5;
/// Most values of a state that a bookmark keeps: a command with it fits into a message.
const MAX_STATE: usize = 1000;

/// Values of the control panel at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Panel {
    /// Number of the run, from 1. Another scene or a restart is a new run.
    pub run: u64,
    /// Name of the scene.
    pub scene: String,
    /// Title of the scene: what it shows as written, before any command.
    pub title: String,
    /// Description of the scene as written, Markdown.
    pub about: String,
    /// The present motion in words, the verdict that all parts of the page show: its type, or that the tilt moves.
    pub motion: String,
    /// The same with the tilt, in one line.
    pub now: String,
    /// Simulated time analysed so far, s.
    pub time_s: f64,
    /// Requested playback speed, simulated seconds per second of wall time.
    pub speed: f64,
    /// Measured playback speed, same unit.
    pub measured_speed: Option<f64>,
    /// Whether the run is paused.
    pub paused: bool,
    /// Whether the tilt has changed notably within the last 40 ms of simulated time: the type of motion is that of a window in
    /// which it moved.
    pub tilt_moves: bool,
    /// Present tilt, degrees; `None` for a scene without tilt.
    pub tilt_deg: Option<f64>,
    /// The numbers of the scene that can be changed: those that it names first.
    pub controls: Vec<Slider>,
    /// Range of the slider of the tilt, degrees; `None` without one.
    pub tilt_range: Option<[f64; 2]>,
    /// What the branch diagram does not hold for: numbers that commands have changed, besides the tilt; `None` while it holds.
    pub diagram_condition: Option<String>,
    /// Whether Lyapunov exponents and perturbed trajectory are computed; `None` if the scene requests
    /// neither.
    pub lyapunov: Option<bool>,
    /// Commentary on the present motion, Markdown with a heading.
    pub narration: String,
    /// Measurements for the scene's mechanism, Markdown with a heading; empty without a mechanism.
    pub lesson: String,
    /// Type of motion by the last classification, or `at rest`.
    pub regime: Option<String>,
    /// Confidence of the classification, 0 to 1.
    pub confidence: Option<f64>,
    /// Strongest spectral lines of the velocity (m/s), in descending order.
    pub lines: Vec<SpectralLine>,
    /// Peak velocity of the probe over the last 5 ms of simulated time, mm/s.
    pub peak_velocity_mm_per_s: f64,
    /// Mean number of contact nodes that stick, slip or are separated over the last 5 ms of simulated time;
    /// `None` for a scene without contact nodes.
    pub nodes: Option<[f64; 3]>,
    /// Commands and messages, newest last.
    pub events: Vec<Event>,
    /// File of the present recording.
    pub recording: Option<String>,
    /// File names of the complete recordings of the session.
    pub recordings: Vec<String>,
    /// Number of pages that show the run.
    pub watching: usize,
    /// Number of the branch diagram within the session, from 1, or of the part of it that is computed so far; `None` without a
    /// diagram of the present scene.
    pub diagram: Option<u64>,
    /// Note on the diagram: what is computed at present, or why the scene has none; `None` for a complete one.
    pub diagram_note: Option<String>,
    /// Step of the tour, from 0, while it is shown.
    pub tour_step: Option<usize>,
    /// Whether all pages are black.
    pub blank: bool,
    /// How the motion reached differs from the one that was promised.
    pub departure: Option<String>,
}

/// A number of the scene that a command can change, in the unit of its key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Slider {
    /// The number.
    #[serde(skip)]
    pub parameter: Parameter,
    /// Dotted path of the key.
    pub key: &'static str,
    /// Name in words.
    pub label: String,
    /// Unit; empty for a dimensionless number.
    pub unit: &'static str,
    /// Meaning, in one sentence.
    pub meaning: &'static str,
    /// Lowest and highest value.
    pub range: [f64; 2],
    /// Value at the start of the run.
    pub start: f64,
    /// Present value; a tilt may also follow the schedule of the scene.
    pub value: f64,
    /// Whether the scene names it.
    pub named: bool,
}

impl From<&Control> for Slider {
    fn from(control: &Control) -> Self {
        let parameter = control.parameter;
        Self {
            parameter,
            key: parameter.path(),
            label: parameter.label(),
            unit: parameter.unit(),
            meaning: parameter.meaning(),
            range: control.range,
            start: control.value,
            value: control.value,
            named: control.is_named,
        }
    }
}

impl Panel {
    /// The numbers, besides the tilt, that differ from those of the scene, for which the diagram holds.
    fn diagram_condition(&self) -> Option<String> {
        let is_changed = |it: &&Slider| it.parameter != Parameter::tilt() && it.value != it.start;
        let changed = self.controls.iter().filter(is_changed);
        let conditions: Vec<String> = changed
            .map(|slider| slider.parameter.with_value(slider.start))
            .collect();
        (!conditions.is_empty())
            .then(|| format!("rows and branches hold for {}", conditions.join(", ")))
    }

    /// How the settled motion differs from a promised one; `None` before it is settled and classified.
    pub(super) fn departure_from(&self, promise: &Promise) -> Option<String> {
        let motion = self.regime.as_deref()?;
        let line = self.lines.first().map(|line| line.frequency);
        let is_early =
            1e3 * self.time_s < promise.after_ms || self.confidence.is_some() && line.is_none();
        if is_early || promise.is_kept(motion, line) {
            return None;
        }
        let line = line.map_or_else(String::new, |hz| format!(", {:.2} kHz", 1e-3 * hz));
        Some(format!("expected here: {promise}; reached: {motion}{line}"))
    }
}

/// A command that was applied, or a message to the user.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Consecutive number within the session.
    pub number: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// Text of the message.
    pub text: String,
}

/// The values of the panel, and what they are derived from: above all the samples of the last 5 ms of simulated time, so
/// that the numbers do not depend on the lengths of the frames, hence not on the playback speed.
#[derive(Debug, Default)]
struct Status {
    /// Values as they arrive.
    panel: Panel,
    /// Peak velocity below which the vibration is at rest, m/s.
    rest_speed: f64,
    /// Peak velocity below which the lines are not named, m/s.
    silence: f64,
    /// Scheduled tilts of the scene, degrees.
    scheduled_deg: Option<[f64; 2]>,
    /// Magnitude of the probe's velocity, m/s.
    speeds: VecDeque<f64>,
    contacts: VecDeque<ContactSample>,
    /// State at the last sample.
    state: Option<RunState>,
    /// Ends of the last frames, s, with their tilts, degrees, and the peak velocities there, m/s.
    frames: VecDeque<(f64, [f64; 2])>,
    /// Numbers of spectral lines, and of harmonics of the first tone among them.
    lines: (usize, usize),
    /// The last measurements for the lesson, and the last type of motion.
    lesson: Option<Arc<Lesson>>,
    regime: Option<Regime>,
    /// What the vibration looks like, if the commentary is about it.
    appearance: Option<Appearance>,
}

impl Status {
    /// Span of time, s: some periods of a low squeak.
    const SPAN: f64 = 5e-3;
    /// Time after which a tilt counts as held, s: a window of the classification; and the range of tilts that does not matter,
    /// degrees.
    const HOLD: f64 = 40e-3;
    const HELD: f64 = 0.15;
    /// Relative range of the peak velocity over that time within which a vibration neither grows nor decays.
    const STEADY: f64 = 0.01;

    /// Starts again for a run. What belongs to the session stays.
    fn begin(&mut self, header: &Header) {
        let before = std::mem::take(self).panel;
        self.panel = Panel {
            run: before.run,
            lyapunov: before.lyapunov,
            recording: before.recording,
            recordings: before.recordings,
            events: before.events,
            scene: header.scene.clone(),
            title: escape::line(&header.title),
            about: escape::lines(&header.about),
            controls: header.controls.iter().map(Slider::from).collect(),
            tilt_range: header.tilt_slider(),
            tilt_deg: header.joint().map(|_| 0.0),
            ..Panel::default()
        };
        self.rest_speed = header.rest_speed;
        self.silence = header.silence();
        let joint = header.joint();
        self.scheduled_deg = joint.map(|it| [it.min_tilt, it.max_tilt].map(f64::to_degrees));
    }

    fn update(&mut self, frame: &Frame) {
        let end = frame.end();
        self.panel.time_s = end;
        let tilt = frame.tilt.to_degrees();
        self.panel.tilt_deg = self.panel.tilt_deg.map(|_| tilt);
        for slider in &mut self.panel.controls {
            let mut changed = frame.changed.iter();
            if slider.parameter == Parameter::tilt() {
                // Rounded: the tilt is converted from radians.
                slider.value = (1e9 * tilt).round() / 1e9;
            } else if let Some((_, value)) = changed.find(|(known, _)| *known == slider.parameter) {
                slider.value = *value;
            }
        }
        self.speeds.extend(frame.velocity.iter().map(|v| v.abs()));
        let length = (Self::SPAN / frame.dt).round() as usize;
        self.speeds
            .drain(..self.speeds.len().saturating_sub(length));
        self.frames.push_back((end, [tilt, self.peak_velocity()]));
        self.frames.retain(|(t, _)| end - *t <= Self::HOLD);
        self.contacts.extend(&frame.contacts);
        // Half a sample of tolerance: times are rounded.
        let start = end - Self::SPAN - 0.5 * frame.dt;
        self.contacts.retain(|counts| counts.time >= start);
        let state = frame.state.clone();
        self.state = state.filter(|state| state.values.len() <= MAX_STATE);
    }

    /// Peak velocity of the probe, m/s.
    fn peak_velocity(&self) -> f64 {
        self.speeds.iter().copied().fold(0.0, f64::max)
    }

    /// Range of the tilt, or of the peak velocity, within the last frames.
    fn recent_range(&self, which: usize) -> [f64; 2] {
        range(self.frames.iter().map(|(_, now)| now[which]))
    }

    /// Whether the vibration neither grows nor decays any more.
    fn is_steady(&self) -> bool {
        let [low, high] = self.recent_range(1);
        let is_level = self.frames.len() > 1 && high - low <= Self::STEADY * high;
        is_level || matches!(self.appearance, Some(Appearance::Settling))
    }

    /// Mean number of nodes that stick, slip or are separated.
    fn nodes(&self) -> Option<[f64; 3]> {
        let mean = |count: fn(&ContactSample) -> usize| {
            self.contacts.iter().map(count).sum::<usize>() as f64 / self.contacts.len() as f64
        };
        (!self.contacts.is_empty()).then(|| {
            let [all, stuck, separated] =
                [mean(|c| c.nodes), mean(|c| c.stuck), mean(|c| c.separated)];
            [stuck, all - stuck - separated, separated]
        })
    }

    /// Present values of the panel.
    fn read(&self) -> Panel {
        let mut panel = self.panel.clone();
        let peak_velocity = self.peak_velocity();
        let [lowest, highest] = self.recent_range(0);
        panel.tilt_moves = highest - lowest > Self::HELD;
        panel.peak_velocity_mm_per_s = 1e3 * peak_velocity;
        panel.nodes = self.nodes();
        if peak_velocity <= self.rest_speed && panel.time_s > 0.0 {
            (panel.regime, panel.confidence) = (Some("at rest".to_owned()), None);
        }
        if panel.regime.as_deref() == Some("transient") && self.is_steady() {
            // The growth or decay is in the window of the classification, but over.
            (panel.regime, panel.confidence) = (None, None);
        }
        if peak_velocity < self.silence {
            panel.lines.clear();
        }
        panel.motion = self.motion(&panel);
        panel.narration = commentary(&panel, self.appearance);
        panel.now = self.now(&panel);
        panel.diagram_condition = panel.diagram_condition();
        panel
    }

    /// The present motion in words.
    fn motion(&self, panel: &Panel) -> String {
        let (lines, harmonics) = self.lines;
        match panel.regime.as_deref() {
            Some("at rest") => "at rest".to_owned(),
            _ if panel.tilt_moves => "the tilt moves".to_owned(),
            Some("periodic") if lines == 1 => "periodic: a pure tone".to_owned(),
            Some("periodic") if harmonics > 0 => {
                format!("periodic: a tone with {}", counted(harmonics, "harmonic"))
            }
            Some(regime) => regime.to_owned(),
            // A scene may have commentary without a classification.
            None => heading(&panel.narration)
                .unwrap_or("not yet classified")
                .to_owned(),
        }
    }

    /// What is observed now, in one line.
    fn now(&self, panel: &Panel) -> String {
        let motion = &panel.motion;
        let tilted = panel.tilt_deg.zip(self.scheduled_deg);
        // A tolerance for degrees that were converted.
        let off = |(tilt, [low, high]): &(f64, [f64; 2])| *tilt < low - 1e-6 || *tilt > high + 1e-6;
        let Some((tilt, [low, high])) = tilted.filter(off) else {
            return motion.clone();
        };
        let scheduled = format_range([low, high], |deg| format!("{deg:.2}°"));
        format!("{motion}, at a tilt of {tilt:.2}° instead of the scene's {scheduled}")
    }

    fn log(&mut self, time_s: f64, text: &str) {
        let events = &mut self.panel.events;
        events.push(Event {
            number: events.last().map_or(0, |event| event.number) + 1,
            time_s,
            text: escape::line(text),
        });
        events.drain(..events.len().saturating_sub(EVENTS));
    }

    /// Fills the text of the lesson with the last type of motion, which is newer than its measurements.
    fn update_lesson(&mut self) {
        if let Some(lesson) = &self.lesson {
            let mut lesson = Lesson::clone(lesson);
            lesson.measured.regime = self.regime;
            self.panel.lesson = text::lesson(&lesson);
        }
    }
}

/// The store of the status that the panel shows, shared by all threads.
#[derive(Debug, Default)]
pub struct StatusStore(Mutex<Status>);

impl StatusStore {
    /// Present values of the panel, as far as they follow from the records.
    pub fn read(&self) -> Panel {
        lock(&self.0).read()
    }

    /// A bookmark of the present motion, without a name: scene, changed numbers, state, and the motion if it is classified at a
    /// tilt that holds. A tilt that a schedule moves is held.
    pub fn bookmark(&self) -> TourStep {
        let status = lock(&self.0);
        let panel = status.read();
        let is_settled = panel.confidence.is_some() && !panel.tilt_moves;
        let changed = panel.controls.iter().filter(|it| it.value != it.start);
        TourStep {
            set: changed.map(|it| (it.key.to_owned(), it.value)).collect(),
            scene: panel.scene,
            state: status.state.clone(),
            promise: panel.regime.filter(|_| is_settled).map(|motion| Promise {
                motion,
                line_khz: panel.lines.first().map(|line| 1e-3 * line.frequency),
                after_ms: 1e3 * panel.time_s,
            }),
            ..TourStep::default()
        }
    }

    /// Starts another run.
    pub fn begin_run(&self, header: &Header, lyapunov: Option<bool>) {
        let mut status = lock(&self.0);
        status.panel.run += 1;
        status.panel.lyapunov = lyapunov;
        status.begin(header);
    }

    /// Adds a message at a simulated time (s).
    pub fn log(&self, time_s: f64, text: impl AsRef<str>) {
        lock(&self.0).log(time_s, text.as_ref());
    }

    /// Sets the file of the present recording.
    pub fn set_recording(&self, file: Option<String>) {
        lock(&self.0).panel.recording = file.map(|file| escape::line(&file));
    }

    /// Adds a complete recording.
    pub fn add_recording(&self, file: &Path) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        lock(&self.0).panel.recordings.push(name.into_owned());
    }
}

/// The heading of a commentary.
fn heading(text: &str) -> Option<&str> {
    text.lines().next()?.strip_prefix("## ")
}

/// The commentary under the verdict on the present motion as its heading. What the spectrum looks like is left out if it
/// contradicts the type of motion, whose classification has more evidence.
fn commentary(panel: &Panel, appearance: Option<Appearance>) -> String {
    let text = &panel.narration;
    let (Some(appearance), Some(regime)) = (appearance, panel.regime.as_deref()) else {
        return text.clone();
    };
    let agrees = match appearance {
        Appearance::Tone => regime == "periodic",
        Appearance::TwoTones => regime == "quasi-periodic",
        Appearance::Broad => ["chaotic", "noise"].contains(&regime),
        Appearance::AtRest | Appearance::Silent => ["at rest", "silent"].contains(&regime),
        Appearance::Unsettled => false,
        // A change that the classification of a longer window may not see yet.
        Appearance::Growing | Appearance::Fading | Appearance::Settling => return text.clone(),
    };
    let omitted = if agrees && !panel.tilt_moves { 1 } else { 2 };
    let parts = text.split("\n\n").skip(omitted).map(str::to_owned);
    let heading = format!("## {}", capitalize(&panel.motion));
    Vec::from_iter(once(heading).chain(parts)).join("\n\n")
}

/// Sink that updates the values of the panel.
pub struct StatusSink(pub Arc<StatusStore>);

impl Sink for StatusSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let status = &mut *lock(&self.0.0);
        match record {
            Record::Header(header) => status.begin(&header),
            Record::Samples(frame) => status.update(&frame),
            Record::Spectrum { peaks, .. } => {
                let harmonics = peaks.iter().filter(|line| line.is_harmonic());
                status.lines = (peaks.len(), harmonics.count());
                status.panel.lines = peaks.into_iter().take(LINES).collect();
            }
            Record::Regime { verdict, .. } => {
                let before = status.regime.replace(verdict.regime);
                if before != Some(verdict.regime) {
                    status.update_lesson();
                }
                status.panel.confidence = verdict.decided_confidence();
                status.panel.regime = Some(verdict.name());
            }
            Record::Narration { observation, .. } => {
                status.appearance = match &observation {
                    Observation::Vibration(vibration) => Some(vibration.appearance),
                    Observation::Separated { .. } | Observation::Exponents(_) => None,
                };
                status.panel.narration = text::narration(&observation);
            }
            Record::Lesson(lesson) => {
                status.lesson = Some(lesson);
                status.update_lesson();
            }
            Record::Event { time, text } | Record::Warning { time, text } => {
                status.log(time, &text);
            }
            _ => {}
        }
        Ok(())
    }

    fn may_skip_pictures(&self) -> bool {
        true
    }
}

#[cfg(test)]
#[path = "panel_tests.rs"]
mod tests;
