//! The main numbers of a live run, as whoever steers it sees them.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;

use crate::escape;
use crate::pipeline::message::{Frame, Header, NodeState, Record, SpectralLine, Subject};
use crate::pipeline::{Gait, Sink, SinkError};

/// Events that are still shown.
const EVENTS: usize = 12;
/// Lines of the spectrum that are shown.
const LINES: usize = 5;

/// What is known of a live run at an instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Panel {
    /// Number of the run, from 1: another scene, or a start from the beginning, is another run.
    pub run: u64,
    /// Name of the scene.
    pub scene: String,
    /// Its title.
    pub title: String,
    /// What it shows, Markdown.
    pub about: String,
    /// Simulated time that has been analysed, s.
    pub time_s: f64,
    /// Pace asked for, simulated seconds a second.
    pub pace: f64,
    /// Pace reached.
    pub reached: Option<f64>,
    /// Whether the time stands still.
    pub paused: bool,
    /// Tilt in the last samples, degrees; `None` of what has none.
    pub tilt_deg: Option<f64>,
    /// Tilts that may be asked for, degrees.
    pub reach_deg: Option<[f64; 2]>,
    /// Whether the neighbours are followed that the scene asks for; `None` where it asks for none.
    pub neighbours: Option<bool>,
    /// What is being seen, Markdown with a heading.
    pub words: String,
    /// What the run shows of the scene's mechanism so far, Markdown with a heading; empty where it is for none.
    pub lesson: String,
    /// The kind of motion, by the last verdict.
    pub regime: Option<String>,
    /// How sure that is, 0 to 1.
    pub confidence: Option<f64>,
    /// The strongest lines of the spectrum of the velocity (m/s), strongest first.
    pub lines: Vec<SpectralLine>,
    /// Largest speed of the probe in the last samples, mm/s.
    pub speed_mm_s: f64,
    /// Contact nodes that stick, slip, are open; `None` of what has none.
    pub nodes: Option<[usize; 3]>,
    /// What has been done and told, newest last.
    pub events: Vec<Event>,
    /// The file that is being recorded into.
    pub recording: Option<String>,
    /// How many watch through the page.
    pub watching: usize,
}

/// Something that was done, or that the user should know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Number, counted through the session.
    pub number: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// The words.
    pub text: String,
}

/// Where the numbers are kept for everybody.
#[derive(Debug, Default)]
pub struct Board {
    panel: Mutex<Panel>,
    /// Newest last.
    events: Mutex<VecDeque<Event>>,
}

impl Board {
    /// All that is known now.
    pub fn read(&self, gait: Option<Gait>, watching: usize) -> Panel {
        let mut panel = self.panel().clone();
        if let Some(gait) = gait {
            panel.pace = gait.pace;
            panel.reached = gait.reached;
            panel.paused = gait.paused;
        }
        panel.watching = watching;
        panel.events = lock(&self.events).iter().cloned().collect();
        panel
    }

    /// Another run begins, whose load may be tilted within `reach_deg`.
    pub fn begin(&self, reach_deg: Option<[f64; 2]>, neighbours: Option<bool>) {
        let mut panel = self.panel();
        *panel = Panel {
            run: panel.run + 1,
            recording: panel.recording.take(),
            reach_deg,
            neighbours,
            ..Panel::default()
        };
    }

    /// Tells something, at a simulated time (s).
    pub fn tell(&self, time_s: f64, text: impl AsRef<str>) {
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

    /// Notes the file that is being recorded into.
    pub fn set_recording(&self, file: Option<String>) {
        self.panel().recording = file.map(|file| escape::line(&file).into_owned());
    }

    fn panel(&self) -> MutexGuard<'_, Panel> {
        lock(&self.panel)
    }

    fn see_header(&self, header: &Header) {
        let mut panel = self.panel();
        panel.scene.clone_from(&header.scene);
        panel.title = escape::line(&header.title).into_owned();
        panel.about = escape::lines(&header.about).into_owned();
        if let Subject::Joint(_) = header.subject {
            panel.tilt_deg = Some(0.0);
        }
    }

    fn see_frame(&self, frame: &Frame) {
        let mut panel = self.panel();
        panel.time_s = frame.end();
        let tilt = frame.tilt.to_degrees();
        panel.tilt_deg = panel.tilt_deg.map(|_| tilt);
        let speed = frame.velocity.iter().fold(0.0, |m: f64, v| v.abs().max(m));
        panel.speed_mm_s = 1e3 * speed;
        if let Some(patch) = frame.patch.last() {
            let states = [NodeState::Stick, NodeState::Slip, NodeState::Separated];
            panel.nodes = Some(states.map(|state| patch.count(state)));
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic leaves numbers of two instants at worst.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes on a board what passes.
pub struct Scribe(pub std::sync::Arc<Board>);

impl Sink for Scribe {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let board = &self.0;
        match record {
            Record::Header(header) => board.see_header(&header),
            Record::Samples(frame) => board.see_frame(&frame),
            Record::Spectrum { peaks, .. } => {
                board.panel().lines = peaks.into_iter().take(LINES).collect();
            }
            Record::Regime { verdict, .. } => {
                let mut panel = board.panel();
                panel.regime = Some(verdict.regime.to_string());
                panel.confidence = Some(verdict.confidence);
            }
            Record::Narration { observation, .. } => {
                board.panel().words = crate::text::narration(&observation);
            }
            Record::Lesson(lesson) => board.panel().lesson = crate::text::lesson(&lesson),
            Record::Event { time, text } | Record::Warning { time, text } => {
                board.tell(time, text);
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
    fn a_board_keeps_the_last_events_and_numbers_them() {
        let board = Arc::new(Board::default());
        let mut scribe = Scribe(Arc::clone(&board));
        for k in 0..20 {
            let text = format!("event {k}");
            scribe.accept(Record::Event { time: 0.1, text }).unwrap();
        }
        let panel = board.read(None, 2);
        assert_eq!(panel.events.len(), EVENTS);
        assert_eq!(panel.events[EVENTS - 1].text, "event 19");
        assert_eq!(panel.events[EVENTS - 1].number, 20);
        assert_eq!(panel.watching, 2);
    }

    #[test]
    fn a_new_run_forgets_the_old_ones_numbers_but_not_its_events() {
        let board = Board::default();
        board.begin(Some([0.0, 10.0]), Some(true));
        board.tell(0.0, "told");
        board.set_recording(Some("a.rrd".to_owned()));
        let frame = Frame {
            velocity: vec![1e-3, -2e-3],
            ..Frame::default()
        };
        board.see_frame(&frame);
        assert_eq!(board.read(None, 0).speed_mm_s, 2.0);
        board.begin(None, None);
        let panel = board.read(None, 0);
        assert_eq!(
            (panel.run, panel.speed_mm_s, panel.reach_deg),
            (2, 0.0, None)
        );
        assert_eq!(panel.recording.as_deref(), Some("a.rrd"));
        assert_eq!(panel.events.len(), 1);
    }
}
