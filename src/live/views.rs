//! Data of the page's views: a small part of a run, from which the browser draws at once and on any machine.
//!
//! The store keeps the present picture and a short past. A client takes what is new since its last message, as
//! often as it can draw ([`ViewCursor`]). A slow client therefore gets fewer messages, each with the newest data:
//! nothing waits for it, and its pictures are never late. Everything is derived from the records of the pipeline.

mod encode;
mod store;

use std::sync::{Arc, Mutex};

use tokio::sync::watch;

use self::store::State;
use super::lock;
use crate::pipeline::message::Record;
use crate::pipeline::{Sink, SinkError};
use crate::plot::Panel;

pub use self::store::ViewCursor;

/// Store of the page's views: the present picture of a run, shared by all clients.
#[derive(Default)]
pub struct ViewStore {
    state: Mutex<State>,
    /// Changes when a client may draw something new.
    version: watch::Sender<u64>,
}

impl ViewStore {
    /// Notifies of new data.
    pub fn subscribe(&self) -> watch::Receiver<u64> {
        self.version.subscribe()
    }

    /// Number of clients.
    pub fn watching(&self) -> usize {
        self.version.receiver_count()
    }

    /// The message with everything that is new since the last one of a client; `None` without news.
    pub fn next(&self, cursor: &mut ViewCursor) -> Option<Vec<u8>> {
        let message = lock(&self.state).news(cursor)?;
        Some(message.finish())
    }

    /// The pictures of the lesson; empty for a scene without one.
    pub fn lesson(&self) -> Vec<Panel> {
        lock(&self.state).lesson()
    }

    /// Creates the sink of a run. `magnification` is that of the displacements of the body.
    pub(super) fn sink(self: &Arc<Self>, magnification: f64) -> ViewSink {
        ViewSink {
            store: Arc::clone(self),
            magnification,
        }
    }
}

/// Sink that updates the store.
pub struct ViewSink {
    store: Arc<ViewStore>,
    magnification: f64,
}

impl Sink for ViewSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let is_frame = matches!(record, Record::Samples(_) | Record::Header(_));
        lock(&self.store.state).update(record, self.magnification);
        // Once per frame: the results of an analysis follow with the next one.
        if is_frame {
            self.idle()?;
        }
        Ok(())
    }

    /// Notifies the clients, which find out what is new.
    fn idle(&mut self) -> Result<(), SinkError> {
        self.store.version.send_modify(|version| *version += 1);
        Ok(())
    }

    fn may_skip_pictures(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::live::frames_tests::run_frames;
    use crate::scene::{Mechanism, Scene};

    /// Header of a message.
    fn header(message: &[u8]) -> Value {
        let length = u32::from_le_bytes(message[..4].try_into().unwrap()) as usize;
        serde_json::from_slice(&message[4..4 + length]).unwrap()
    }

    /// Number of values of an array of a message.
    fn count(header: &Value, name: &str) -> Option<u64> {
        let arrays = header["arrays"].as_array()?;
        arrays.iter().find(|array| array[0] == name)?[2].as_u64()
    }

    fn stick_slip() -> Scene {
        Scene::load("stick-slip").unwrap()
    }

    /// Runs a scene in frames of a playback speed, and calls a function after each frame.
    fn run(scene: Scene, speed: f64, duration_ms: f64, mut after: impl FnMut(&ViewStore)) {
        let store = Arc::new(ViewStore::default());
        let mut sink = store.sink(1.0);
        run_frames(scene, speed, duration_ms, &mut sink, || after(&store));
    }

    #[test]
    fn a_client_gets_the_start_once_and_then_every_sample() {
        let (mut cursor, mut messages) = (ViewCursor::default(), Vec::new());
        run(stick_slip(), 0.02, 20.0, |store| {
            messages.extend(store.next(&mut cursor).map(|message| header(&message)));
            assert!(store.next(&mut cursor).is_none(), "nothing is new");
        });
        let (first, later) = messages.split_first().unwrap();
        let nodes = count(first, "states").unwrap();
        assert_eq!(count(first, "nodes"), Some(2 * nodes));
        assert_eq!(count(first, "friction"), Some(2 * nodes));
        assert_eq!(first["start"]["scene"], "stick-slip");
        assert!(
            later
                .iter()
                .all(|m| m.get("start").is_none() && m["run"] == 1)
        );
        // The nodes change with each picture, 60 times per second.
        let moved = later.iter().filter(|m| count(m, "states").is_some());
        assert_eq!(moved.count(), later.len());
        let samples: u64 = messages.iter().filter_map(|m| count(m, "velocity")).sum();
        let last = messages.last().unwrap();
        assert_eq!(last["sample_count"], samples);
        for picture in ["spectrum", "columns"] {
            assert!(
                messages.iter().any(|m| count(m, picture) > Some(0)),
                "{picture}"
            );
        }
    }

    /// The pictures that the text of each lesson names have data.
    #[test]
    fn every_lesson_has_its_pictures() {
        for preset in crate::scene::PRESETS {
            let scene = preset.scene().unwrap();
            let Some(mechanism) = scene.mechanism else {
                continue;
            };
            // Lessons do not use them.
            let unused = ["analysis.recurrence", "analysis.quantification"];
            let scene = scene.with_overrides(&unused.map(|table| (table, "absent")));
            let mut pictures = Vec::new();
            // A perturbed trajectory starts after the settling time.
            let is_chaos = mechanism == Mechanism::Chaos;
            let duration_ms = if is_chaos { 200.0 } else { 60.0 };
            run(scene.unwrap(), 0.05, duration_ms, |store| {
                pictures = store.lesson();
            });
            assert!(!pictures.is_empty(), "{mechanism:?}");
            for panel in &pictures {
                let points = panel.layers.iter().flat_map(|layer| layer.points_of());
                let drawn = points.filter(|p| p.iter().all(|x| x.is_finite())).count();
                let varies = ["Strongest line over tilt"].contains(&panel.title.as_str());
                assert!(drawn > 1 || varies, "{}: {}", preset.name, panel.title);
                assert!(panel.x.range[0] < panel.x.range[1] && panel.y.range[0] < panel.y.range[1]);
            }
            let text = serde_json::to_string(&pictures).unwrap();
            assert!(
                text.len() < 400_000,
                "{}: {} bytes",
                preset.name,
                text.len()
            );
        }
    }

    /// A client that comes late or draws seldom gets the newest samples only, in a message of bounded size.
    #[test]
    fn a_late_client_gets_the_present() {
        let mut kept = None;
        run(stick_slip(), 1.0, 150.0, |store| {
            kept = store.next(&mut ViewCursor::default());
        });
        let message = kept.unwrap();
        let header = header(&message);
        assert!(header["sample_count"].as_u64() > Some(10_000));
        assert!(count(&header, "velocity") <= Some(4096));
        assert!(message.len() < 400_000, "{}", message.len());
    }

    /// In real time too, 60 messages a second are less than 2 MB.
    #[test]
    fn a_second_of_real_time_is_below_the_limit() {
        let (mut cursor, mut sizes) = (ViewCursor::default(), Vec::new());
        run(stick_slip(), 1.0, 300.0, |store| {
            sizes.extend(store.next(&mut cursor).map(|message| message.len()));
        });
        // The first message has the surface of the body.
        let later = &sizes[1..];
        let mean = later.iter().sum::<usize>() / later.len();
        assert!(mean * 60 < 2_000_000, "{mean} bytes per message");
    }
}
