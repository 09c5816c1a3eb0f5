//! Main numbers of a live run, for the control panel.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;

use crate::escape;
use crate::pipeline::message::{Frame, Header, NodeState, Record, SpectralLine, Subject};
use crate::pipeline::{RunStatus, Sink, SinkError};

/// Number of events on the panel.
const EVENTS: usize = 12;
/// Number of spectral lines on the panel.
const LINES: usize = 5;

/// Values of the control panel at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Panel {
    /// Number of the run, from 1. Another scene or a restart is a new run.
    pub run: u64,
    /// Name of the scene.
    pub scene: String,
    /// Title of the scene.
    pub title: String,
    /// Description of the scene, Markdown.
    pub about: String,
    /// Simulated time analysed so far, s.
    pub time_s: f64,
    /// Requested playback speed, simulated seconds per second of wall time.
    pub speed: f64,
    /// Measured playback speed, same unit.
    pub measured_speed: Option<f64>,
    /// Whether the run is paused.
    pub paused: bool,
    /// Present tilt, degrees; `None` for a scene without tilt.
    pub tilt_deg: Option<f64>,
    /// Range of tilts, degrees.
    pub tilt_range_deg: Option<[f64; 2]>,
    /// Whether Lyapunov exponents and perturbed trajectory are computed; `None` if the scene requests
    /// neither.
    pub lyapunov: Option<bool>,
    /// Commentary on the present motion, Markdown with a heading.
    pub narration: String,
    /// Measurements for the scene's mechanism, Markdown with a heading; empty without a mechanism.
    pub lesson: String,
    /// Type of motion by the last classification.
    pub regime: Option<String>,
    /// Confidence of the classification, 0 to 1.
    pub confidence: Option<f64>,
    /// Strongest spectral lines of the velocity (m/s), in descending order.
    pub lines: Vec<SpectralLine>,
    /// Peak speed of the probe in the last frame, mm/s.
    pub peak_velocity_mm_per_s: f64,
    /// Number of contact nodes that stick, slip or are separated; `None` for a scene without contact nodes.
    pub nodes: Option<[usize; 3]>,
    /// Commands and messages, newest last.
    pub events: Vec<Event>,
    /// File of the present recording.
    pub recording: Option<String>,
    /// Number of viewers that are watching: those connected to the page.
    pub watching: usize,
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
        panel.watching = watching;
        panel.events = lock(&self.events).iter().cloned().collect();
        panel
    }

    /// Starts another run with the given range of tilts.
    pub fn begin_run(&self, tilt_range_deg: Option<[f64; 2]>, lyapunov: Option<bool>) {
        let mut panel = self.panel();
        *panel = Panel {
            run: panel.run + 1,
            recording: panel.recording.take(),
            tilt_range_deg,
            lyapunov,
            ..Panel::default()
        };
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

    fn panel(&self) -> MutexGuard<'_, Panel> {
        lock(&self.panel)
    }

    fn update_from_header(&self, header: &Header) {
        let mut panel = self.panel();
        panel.scene.clone_from(&header.scene);
        panel.title = escape::line(&header.title).into_owned();
        panel.about = escape::lines(&header.about).into_owned();
        if let Subject::Joint(_) = header.subject {
            panel.tilt_deg = Some(0.0);
        }
    }

    fn update_from_frame(&self, frame: &Frame) {
        let mut panel = self.panel();
        panel.time_s = frame.end();
        let tilt = frame.tilt.to_degrees();
        panel.tilt_deg = panel.tilt_deg.map(|_| tilt);
        let speed = frame.velocity.iter().fold(0.0, |m: f64, v| v.abs().max(m));
        panel.peak_velocity_mm_per_s = 1e3 * speed;
        if let Some(patch) = frame.patch.last() {
            let states = [NodeState::Stick, NodeState::Slip, NodeState::Separated];
            panel.nodes = Some(states.map(|state| patch.count(state)));
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // After a panic the values may belong to two different instants, which is acceptable.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sink that updates the values of the panel.
pub struct StatusSink(pub std::sync::Arc<StatusStore>);

impl Sink for StatusSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let store = &self.0;
        match record {
            Record::Header(header) => store.update_from_header(&header),
            Record::Samples(frame) => store.update_from_frame(&frame),
            Record::Spectrum { peaks, .. } => {
                store.panel().lines = peaks.into_iter().take(LINES).collect();
            }
            Record::Regime { verdict, .. } => {
                let mut panel = store.panel();
                panel.confidence = verdict.decided_confidence();
                panel.regime = Some(match panel.confidence {
                    Some(_) => verdict.regime.to_string(),
                    None => verdict.summary(),
                });
            }
            Record::Narration { observation, .. } => {
                store.panel().narration = crate::text::narration(&observation);
            }
            Record::Lesson(lesson) => store.panel().lesson = crate::text::lesson(&lesson),
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
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn the_last_events_are_kept_and_numbered() {
        let store = Arc::new(StatusStore::default());
        let mut sink = StatusSink(Arc::clone(&store));
        for k in 0..20 {
            let text = format!("event {k}");
            sink.accept(Record::Event { time: 0.1, text }).unwrap();
        }
        let panel = store.read(None, 2);
        assert_eq!(panel.events.len(), EVENTS);
        assert_eq!(panel.events[EVENTS - 1].text, "event 19");
        assert_eq!(panel.events[EVENTS - 1].number, 20);
        assert_eq!(panel.watching, 2);
    }

    #[test]
    fn a_new_run_resets_the_numbers_but_keeps_the_events() {
        let store = StatusStore::default();
        store.begin_run(Some([0.0, 10.0]), Some(true));
        store.log(0.0, "message");
        store.set_recording(Some("a.rrd".to_owned()));
        let frame = Frame {
            velocity: vec![1e-3, -2e-3],
            ..Frame::default()
        };
        store.update_from_frame(&frame);
        assert_eq!(store.read(None, 0).peak_velocity_mm_per_s, 2.0);
        store.begin_run(None, None);
        let panel = store.read(None, 0);
        assert_eq!(
            (
                panel.run,
                panel.peak_velocity_mm_per_s,
                panel.tilt_range_deg
            ),
            (2, 0.0, None)
        );
        assert_eq!(panel.recording.as_deref(), Some("a.rrd"));
        assert_eq!(panel.events.len(), 1);
    }
}
