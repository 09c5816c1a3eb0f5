//! Main numbers of a live run, for the control panel.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard};

use serde::Serialize;

use super::command::Promise;
use super::lock;
use super::tour::TourStep;
use crate::analysis::{regime::Regime, stats::range};
use crate::escape;
use crate::pipeline::message::{
    Appearance, ContactSample, Frame, Header, Lesson, Observation, Record, SpectralLine, Subject,
};
use crate::pipeline::{RunState, RunStatus, Sink, SinkError};
use crate::scene::{Control, Parameter};

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

/// Samples of the last 5 ms of simulated time, from which the numbers of the panel are computed: they do not
/// depend on the lengths of the frames, hence not on the playback speed.
#[derive(Debug, Default)]
struct RecentSamples {
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

impl RecentSamples {
    /// Span of time, s: some periods of a low squeak.
    const SPAN: f64 = 5e-3;
    /// Time after which a tilt counts as held, s: a window of the classification; and the range of tilts that does not matter,
    /// degrees.
    const HOLD: f64 = 40e-3;
    const HELD: f64 = 0.15;
    /// Relative range of the peak velocity over that time within which a vibration neither grows nor decays.
    const STEADY: f64 = 0.01;

    fn push(&mut self, frame: &Frame) {
        let end = frame.end();
        self.speeds.extend(frame.velocity.iter().map(|v| v.abs()));
        let length = (Self::SPAN / frame.dt).round() as usize;
        self.speeds
            .drain(..self.speeds.len().saturating_sub(length));
        let now = [frame.tilt.to_degrees(), self.peak_velocity()];
        self.frames.push_back((end, now));
        self.frames.retain(|(t, _)| end - *t <= Self::HOLD);
        self.contacts.extend(&frame.contacts);
        self.state = frame
            .state
            .clone()
            .filter(|state| state.values.len() <= MAX_STATE);
        // Half a sample of tolerance: times are rounded.
        let start = frame.end() - Self::SPAN - 0.5 * frame.dt;
        self.contacts.retain(|counts| counts.time >= start);
    }

    /// Peak velocity of the probe, m/s.
    fn peak_velocity(&self) -> f64 {
        self.speeds.iter().copied().fold(0.0, f64::max)
    }

    fn is_at_rest(&self) -> bool {
        self.peak_velocity() <= self.rest_speed
    }

    fn is_silent(&self) -> bool {
        self.peak_velocity() < self.silence
    }

    /// Range of the tilt, or of the peak velocity, within the last frames.
    fn recent_range(&self, which: usize) -> [f64; 2] {
        range(self.frames.iter().map(|(_, now)| now[which]))
    }

    fn tilt_moves(&self) -> bool {
        let [low, high] = self.recent_range(0);
        high - low > Self::HELD
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

/// The store of the status that the panel shows, shared by all threads.
#[derive(Debug, Default)]
pub struct StatusStore {
    panel: Mutex<Panel>,
    recent: Mutex<RecentSamples>,
    /// Newest last.
    events: Mutex<VecDeque<Event>>,
}

impl StatusStore {
    /// Present values of the panel.
    pub fn read(&self, status: Option<RunStatus>, watching: usize) -> Panel {
        let mut panel = self.panel().clone();
        if let Some(status) = status {
            panel.speed = status.speed;
            panel.measured_speed = status.measured_speed;
            panel.paused = status.paused;
        }
        if lock(&self.recent).is_at_rest() && panel.time_s > 0.0 {
            (panel.regime, panel.confidence) = (Some("at rest".to_owned()), None);
        }
        if panel.regime.as_deref() == Some("transient") && lock(&self.recent).is_steady() {
            // The growth or decay is in the window of the classification, but over.
            (panel.regime, panel.confidence) = (None, None);
        }
        if lock(&self.recent).is_silent() {
            panel.lines.clear();
        }
        panel.motion = self.motion(&panel);
        panel.narration = commentary(&panel, lock(&self.recent).appearance);
        panel.now = self.now(&panel);
        panel.diagram_condition = panel.diagram_condition();
        panel.watching = watching;
        panel.events = lock(&self.events).iter().cloned().collect();
        panel
    }

    /// The present motion in words.
    fn motion(&self, panel: &Panel) -> String {
        let (lines, harmonics) = lock(&self.recent).lines;
        match panel.regime.as_deref() {
            Some("at rest") => "at rest".to_owned(),
            _ if panel.tilt_moves => "the tilt moves".to_owned(),
            Some("periodic") if lines == 1 => "periodic: a pure tone".to_owned(),
            Some("periodic") if harmonics == 1 => "periodic: a tone with 1 harmonic".to_owned(),
            Some("periodic") if harmonics > 1 => {
                format!("periodic: a tone with {harmonics} harmonics")
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
        let tilted = panel.tilt_deg.zip(lock(&self.recent).scheduled_deg);
        // A tolerance for degrees that were converted.
        let off = |(tilt, [low, high]): &(f64, [f64; 2])| *tilt < low - 1e-6 || *tilt > high + 1e-6;
        match tilted.filter(off) {
            Some((tilt, [low, high])) => {
                let scheduled = if low == high {
                    format!("{low:.2}°")
                } else {
                    format!("{low:.2}° to {high:.2}°")
                };
                format!("{motion}, at a tilt of {tilt:.2}° instead of the scene's {scheduled}")
            }
            None => motion.clone(),
        }
    }

    /// A bookmark of the present motion, without a name: scene, changed numbers, state, and the motion if it is classified at a
    /// tilt that holds. A tilt that a schedule moves is held.
    pub fn bookmark(&self) -> TourStep {
        let panel = self.read(None, 0);
        let is_settled = panel.confidence.is_some() && !panel.tilt_moves;
        let changed = panel.controls.iter().filter(|it| it.value != it.start);
        TourStep {
            set: changed.map(|it| (it.key.to_owned(), it.value)).collect(),
            scene: panel.scene,
            state: lock(&self.recent).state.clone(),
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
        let mut panel = self.panel();
        *panel = Panel {
            run: panel.run + 1,
            recording: panel.recording.take(),
            recordings: std::mem::take(&mut panel.recordings),
            controls: header.controls.iter().map(Slider::from).collect(),
            tilt_range: header.tilt_slider(),
            lyapunov,
            ..Panel::default()
        };
        *lock(&self.recent) = RecentSamples::default();
    }

    /// Adds a message at a simulated time (s).
    pub fn log(&self, time_s: f64, text: impl AsRef<str>) {
        let mut events = lock(&self.events);
        let number = events.back().map_or(0, |event| event.number) + 1;
        if events.len() == EVENTS {
            events.pop_front();
        }
        events.push_back(Event {
            number,
            time_s,
            text: escape::line(text.as_ref()).into_owned(),
        });
    }

    /// Sets the file of the present recording.
    pub fn set_recording(&self, file: Option<String>) {
        self.panel().recording = file.map(|file| escape::line(&file).into_owned());
    }

    /// Adds a complete recording.
    pub fn add_recording(&self, file: &Path) {
        let name = file.file_name().unwrap_or_default();
        self.panel()
            .recordings
            .push(name.to_string_lossy().into_owned());
    }

    /// Fills the text of the lesson with the last type of motion, which is newer than its measurements.
    fn update_lesson(&self) {
        let (lesson, regime) = {
            let recent = lock(&self.recent);
            (recent.lesson.clone(), recent.regime)
        };
        if let Some(lesson) = lesson {
            let mut lesson = Lesson::clone(&lesson);
            lesson.measured.regime = regime;
            self.panel().lesson = crate::text::lesson(&lesson);
        }
    }

    fn panel(&self) -> MutexGuard<'_, Panel> {
        lock(&self.panel)
    }

    fn update_from_header(&self, header: &Header) {
        let mut panel = self.panel();
        panel.scene.clone_from(&header.scene);
        panel.title = escape::line(&header.title).into_owned();
        panel.about = escape::lines(&header.about).into_owned();
        let mut recent = lock(&self.recent);
        recent.rest_speed = header.rest_speed;
        recent.silence = header.silence();
        if let Subject::Joint(joint) = &header.subject {
            panel.tilt_deg = Some(0.0);
            recent.scheduled_deg = Some([joint.min_tilt, joint.max_tilt].map(f64::to_degrees));
        }
    }

    fn update_from_frame(&self, frame: &Frame) {
        let mut panel = self.panel();
        panel.time_s = frame.end();
        let tilt = frame.tilt.to_degrees();
        panel.tilt_deg = panel.tilt_deg.map(|_| tilt);
        for slider in &mut panel.controls {
            let mut changed = frame.changed.iter();
            if slider.parameter == Parameter::tilt() {
                // Rounded: the tilt is converted from radians.
                slider.value = (1e9 * tilt).round() / 1e9;
            } else if let Some((_, value)) = changed.find(|(known, _)| *known == slider.parameter) {
                slider.value = *value;
            }
        }
        let mut recent = lock(&self.recent);
        recent.push(frame);
        panel.tilt_moves = recent.tilt_moves();
        panel.peak_velocity_mm_per_s = 1e3 * recent.peak_velocity();
        panel.nodes = recent.nodes();
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
    let mut verdict = panel.motion.clone();
    verdict[..1].make_ascii_uppercase();
    let parts = text
        .split("\n\n")
        .skip(if agrees && !panel.tilt_moves { 1 } else { 2 });
    let parts = std::iter::once(format!("## {verdict}")).chain(parts.map(str::to_owned));
    parts.collect::<Vec<_>>().join("\n\n")
}

/// Sink that updates the values of the panel.
pub struct StatusSink(pub Arc<StatusStore>);

impl Sink for StatusSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let store = &self.0;
        match record {
            Record::Header(header) => store.update_from_header(&header),
            Record::Samples(frame) => store.update_from_frame(&frame),
            Record::Spectrum { peaks, .. } => {
                let is_harmonic = |label: &str| {
                    let order = label.strip_suffix(" f1");
                    order.is_some_and(|order| order.parse::<u32>().is_ok())
                };
                let harmonics = peaks.iter().filter(|line| is_harmonic(&line.label));
                lock(&store.recent).lines = (peaks.len(), harmonics.count());
                store.panel().lines = peaks.into_iter().take(LINES).collect();
            }
            Record::Regime { verdict, .. } => {
                let before = lock(&store.recent).regime.replace(verdict.regime);
                if before != Some(verdict.regime) {
                    store.update_lesson();
                }
                let mut panel = store.panel();
                panel.confidence = verdict.decided_confidence();
                panel.regime = Some(match panel.confidence {
                    Some(_) => verdict.regime.to_string(),
                    None => verdict.summary(),
                });
            }
            Record::Narration { observation, .. } => {
                lock(&store.recent).appearance = match &observation {
                    Observation::Vibration(vibration) => Some(vibration.appearance),
                    Observation::Separated { .. } | Observation::Exponents(_) => None,
                };
                store.panel().narration = crate::text::narration(&observation);
            }
            Record::Lesson(lesson) => {
                lock(&store.recent).lesson = Some(lesson);
                store.update_lesson();
            }
            Record::Event { time, text } | Record::Warning { time, text } => {
                store.log(time, text);
            }
            _ => {}
        }
        Ok(())
    }

    fn delivery(&self) -> crate::pipeline::Delivery {
        crate::pipeline::Delivery::LatestPictures
    }
}

#[cfg(test)]
#[path = "panel_tests.rs"]
mod tests;
