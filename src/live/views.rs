//! Data of the page's views: a small part of a run, from which the browser draws at once and on any machine.
//!
//! The store keeps the present picture and a short past. A client takes what is new since its last message, as
//! often as it can draw ([`ViewCursor`]). A slow client therefore gets fewer messages, each with the newest data:
//! nothing waits for it, and its pictures are never late. Everything is derived from the records of the pipeline.

mod encode;

use std::collections::{BTreeMap, VecDeque, vec_deque};
use std::sync::Arc;

use serde_json::{Map, Value, json};
use tokio::sync::watch;

use self::encode::Message;
use crate::pipeline::message::{Frame, Header, JointInfo, PatchGeometry, PatchSnapshot, Record};
use crate::pipeline::{Sink, SinkError};
use crate::plot::{LessonPictures, Panel, SectionAxes};

/// Store of the page's views: the present picture of a run, shared by all clients.
#[derive(Default)]
pub struct ViewStore(watch::Sender<State>);

impl ViewStore {
    /// Notifies of new data.
    pub fn subscribe(&self) -> watch::Receiver<State> {
        self.0.subscribe()
    }

    /// Number of clients.
    pub fn watching(&self) -> usize {
        self.0.receiver_count()
    }

    /// The message with everything that is new since the last one of a client; `None` without news.
    pub fn next(&self, cursor: &mut ViewCursor) -> Option<Vec<u8>> {
        let message = self.0.borrow().news(cursor)?;
        Some(message.finish())
    }

    /// The pictures of the lesson; empty for a scene without one.
    pub fn lesson(&self) -> Vec<Panel> {
        let state = self.0.borrow();
        let header = state.header.as_ref();
        header.map_or_else(Vec::new, |header| state.lesson.panels(header))
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
        // Notifies once per frame: the results of an analysis follow with the next one.
        let is_frame = matches!(record, Record::Samples(_) | Record::Header(_));
        self.store.0.send_if_modified(|state| {
            state.update(record, self.magnification);
            is_frame
        });
        Ok(())
    }

    /// Notifies the clients, which find out what is new.
    fn idle(&mut self) -> Result<(), SinkError> {
        self.store.0.send_modify(|_| {});
        Ok(())
    }

    fn may_skip_pictures(&self) -> bool {
        true
    }
}

/// Samples kept: 41 ms at 200 kHz, twice the trail of the phase portrait.
const SAMPLES: usize = 1 << 13;
/// Maximum number of samples in a message: a client that draws 60 times per second gets all of a run in real
/// time at 200 kHz, 0.8 MB/s.
const MESSAGE_SAMPLES: usize = 1 << 12;
/// Intersections kept.
const POINTS: usize = 600;
/// Columns of the spectrogram kept, and the maximum number in a message to a client that has some.
const COLUMNS: usize = 480;
const MESSAGE_COLUMNS: usize = 24;
/// Maximum number of bins of a spectrum and of a column. Several bins are replaced by their maximum.
const SPECTRUM_BINS: usize = 1024;
const COLUMN_BINS: usize = 192;
/// Levels of a spectrogram's bytes 0 and 255, dB.
const LEVELS: [f32; 2] = [-90.0, 30.0];

/// A series of which the newest values are kept.
#[derive(Debug, Default)]
struct Series<T> {
    kept: VecDeque<T>,
    /// Number of values so far.
    count: u64,
}

impl<T> Series<T> {
    fn extend(&mut self, values: impl IntoIterator<Item = T>, most: usize) {
        let before = self.kept.len();
        self.kept.extend(values);
        self.count += (self.kept.len() - before) as u64;
        self.kept.drain(..self.kept.len().saturating_sub(most));
    }

    /// The values that the client has not got, at most the newest `most`; `None` if there are none.
    fn news<'a>(&'a self, known: &mut u64, most: usize) -> Option<vec_deque::Iter<'a, T>> {
        let new = (self.count - std::mem::replace(known, self.count)) as usize;
        let new = new.min(most).min(self.kept.len());
        (new > 0).then(|| self.kept.range(self.kept.len() - new..))
    }
}

/// A stroboscope for body and contact patch: it flashes once per frame, in step with the strongest line, so that a
/// vibration too fast for the eye is seen in slow motion.
#[derive(Debug, Default)]
struct Strobe {
    /// Frequency of the strongest line, Hz; 0 without a line.
    frequency: f64,
    /// Phase of the line at the start of the next frame, and phase of the next flash, periods.
    phase: f64,
    flash: f64,
}

impl Strobe {
    /// Periods per flash: a period in 0.8 s at 60 frames per second.
    const STEP: f64 = 1.0 / 48.0;

    /// The sample of a frame at the phase of the flash; the last one if the frame is shorter than a period.
    fn sample(&mut self, frame: &Frame) -> usize {
        let per_sample = self.frequency * frame.dt;
        let periods = per_sample * frame.len() as f64;
        let start = self.phase;
        self.phase = (start + periods).fract();
        self.flash = (self.flash + Self::STEP).fract();
        if periods < 1.0 {
            return frame.len().saturating_sub(1);
        }
        ((self.flash - start).rem_euclid(1.0) / per_sample) as usize
    }
}

/// The state of the views.
#[derive(Debug, Default)]
pub struct State {
    run: u64,
    header: Option<Arc<Header>>,
    /// End of the last frame, s, and its tilt, rad.
    time: f64,
    tilt: f64,
    strobe: Strobe,
    geometry: Arc<PatchGeometry>,
    /// The latest pictures by their names, as parts of a message, each with its number.
    pictures: BTreeMap<&'static str, (u64, Message)>,
    /// Number of pictures so far.
    count: u64,
    /// Displacement (m) and velocity (m/s) of the probe.
    samples: Series<[f32; 2]>,
    columns: Series<Vec<u8>>,
    /// Time of the last column, s.
    column_time: f64,
    points: Series<[f32; 2]>,
    lesson: LessonPictures,
}

/// Cursor of a client in the data of the views: what it has got.
#[derive(Debug, Default)]
pub struct ViewCursor {
    run: u64,
    pictures: u64,
    samples: u64,
    columns: u64,
    points: u64,
}

impl State {
    /// Adds a record.
    fn update(&mut self, record: Record, magnification: f64) {
        if let Some(header) = &self.header {
            self.lesson.accept(header, &record);
        }
        match record {
            Record::Header(header) => {
                *self = Self {
                    run: self.run + 1,
                    ..Self::default()
                };
                self.set("start", start(&header, magnification));
                self.header = Some(header);
            }
            Record::Samples(frame) => self.add_frame(&frame),
            Record::Spectrum {
                bin,
                amplitude,
                peaks,
                ..
            } => {
                let amplitude: Vec<f32> = amplitude.iter().map(|&a| a as f32).collect();
                let (amplitude, bin) = self.pooled(&amplitude, bin, SPECTRUM_BINS);
                self.strobe.frequency = peaks.first().map_or(0.0, |line| line.frequency);
                let spectrum = Message::default()
                    .value("spectrum_bin_hz", bin)
                    .value("lines", json!(peaks))
                    .floats("spectrum", amplitude);
                self.set("spectrum", spectrum);
            }
            Record::SpectrogramColumn {
                time,
                bin,
                level_db,
            } => {
                let (levels, bin) = self.pooled(&level_db, bin, COLUMN_BINS);
                let [low, high] = LEVELS;
                let byte = |db: f32| (255.0 * (db - low) / (high - low)) as u8;
                let every = time - std::mem::replace(&mut self.column_time, time);
                let column = Message::default()
                    .value("column_bins", levels.len())
                    .value("column_bin_hz", bin)
                    .value("column_every_s", every);
                self.set("column", column);
                let column = levels.into_iter().map(byte).collect();
                self.columns.extend([column], COLUMNS);
            }
            Record::Recurrence { image, .. } => {
                let recurrence = Message::default()
                    .value("recurrence_size", image.size)
                    .value("recurrence_window_s", image.window)
                    .value("recurrence_rate", image.rate)
                    .octets("recurrence", packed(&image.recurrent));
                self.set("recurrence", recurrence);
            }
            Record::Section { points, .. } => {
                let at = points.iter().map(|point| point.at.map(|x| x as f32));
                self.points.extend(at, POINTS);
            }
            _ => {}
        }
    }

    /// Replaces a picture.
    fn set(&mut self, name: &'static str, picture: Message) {
        self.count += 1;
        self.pictures.insert(name, (self.count, picture));
    }

    fn add_frame(&mut self, frame: &Frame) {
        let Some(header) = self.header.clone() else {
            return;
        };
        (self.time, self.tilt) = (frame.end(), frame.tilt);
        let pairs = frame.displacement.iter().zip(&frame.velocity);
        let pairs = pairs.map(|(&u, &v)| [u as f32, v as f32]);
        self.samples.extend(pairs, SAMPLES);
        let row = self.strobe.sample(frame);
        if let Some(q) = frame.q.chunks_exact(frame.modes.max(1)).nth(row) {
            let pose = q.iter().map(|&q| q as f32);
            self.set("pose", Message::default().floats("pose", pose));
        }
        let geometry = &frame.geometry;
        let azimuth = header.joint().map_or(0.0, |joint| joint.azimuth);
        let axes = patch_axes(geometry.direction, azimuth);
        let flat = |v: &[f64; 3]| {
            axes.map(|axis| (0..3).map(|i| axis[i] * v[i]).sum::<f64>())
                .map(|x| x as f32)
        };
        if !Arc::ptr_eq(&self.geometry, geometry) && self.geometry != *geometry {
            self.geometry = Arc::clone(geometry);
            let nodes = Message::default()
                .floats("nodes", geometry.positions.iter().flat_map(flat))
                .floats("areas", geometry.areas.iter().map(|&a| a as f32));
            self.set("nodes", nodes);
        }
        // The nodes at the same flash as the body.
        let flash = frame.time(row);
        let off = |snapshot: &&PatchSnapshot| (snapshot.time - flash).abs();
        let snapshots = frame.patch.iter();
        if let Some(snapshot) = snapshots.min_by(|a, b| off(a).total_cmp(&off(b))) {
            let forces = snapshot.normal_force.iter().map(|&f| f as f32);
            let snapshot = Message::default()
                .octets("states", snapshot.states.iter().map(|&state| state as u8))
                .floats("normal_force", forces)
                .floats("friction", snapshot.friction.iter().flat_map(flat));
            self.set("snapshot", snapshot);
        }
    }

    /// The values up to the highest frequency in at most `most` bins of equal width, and that width, Hz.
    fn pooled(&self, values: &[f32], bin: f64, most: usize) -> (Vec<f32>, f64) {
        let header = self.header.as_ref();
        let highest = header.map_or(0.0, |header| header.highest_frequency());
        let used = ((highest / bin) as usize + 1).min(values.len());
        let merged = used.div_ceil(most).max(1);
        let maximum = |chunk: &[f32]| chunk.iter().copied().fold(f32::MIN, f32::max);
        let pooled = values[..used].chunks(merged).map(maximum).collect();
        (pooled, bin * merged as f64)
    }

    /// What is new for a client; `None` if nothing is.
    fn news(&self, cursor: &mut ViewCursor) -> Option<Message> {
        if cursor.run != self.run {
            *cursor = ViewCursor {
                run: self.run,
                ..ViewCursor::default()
            };
        }
        let known = std::mem::replace(&mut cursor.pictures, self.count);
        let pictures = self.pictures.values();
        let new = pictures.filter(|(number, _)| *number > known);
        let mut message = new.fold(Message::default(), |all, (_, picture)| all.with(picture));
        if let Some(samples) = self.samples.news(&mut cursor.samples, MESSAGE_SAMPLES) {
            message = message
                .fractions("displacement", samples.clone().map(|s| s[0]))
                .fractions("velocity", samples.map(|s| s[1]));
        }
        // The first message has the whole past.
        let most = match cursor.columns {
            0 => COLUMNS,
            _ => MESSAGE_COLUMNS,
        };
        if let Some(columns) = self.columns.news(&mut cursor.columns, most) {
            message = message.octets("columns", columns.flatten().copied());
        }
        if let Some(points) = self.points.news(&mut cursor.points, POINTS) {
            message = message.floats("points", points.flatten().copied());
        }
        let message = Some(message).filter(|message| !message.is_empty())?;
        Some(
            message
                .value("run", self.run)
                .value("time_s", self.time)
                .value("sample_count", self.samples.count)
                .value("tilt_deg", self.tilt.to_degrees()),
        )
    }
}

/// What a client needs before the data of a run.
fn start(header: &Header, magnification: f64) -> Message {
    let lesson = header.computed.as_ref().map(|it| it.mechanism.name());
    let mut start = json!({
        "scene": header.scene,
        "sample_rate_hz": header.sample_rate,
        "highest_frequency_hz": header.highest_frequency(),
        "silence_m_per_s": header.silence(),
        "section": SectionAxes::of_run(header).names(),
        "parameters": parameters(header),
        "lesson": lesson,
    });
    let Some(joint) = header.joint() else {
        return Message::default().value("start", start);
    };
    start["load_n"] = json!(joint.largest_load());
    start["patch_radius_m"] = json!(joint.patch_radius);
    start["magnification"] = json!(magnification);
    with_body(Message::default().value("start", start), joint)
}

/// The parameters of the friction law or of the small system, as in the scene.
fn parameters(header: &Header) -> String {
    let scene: Map<String, Value> = toml_edit::de::from_str(&header.scene_text).unwrap_or_default();
    let tables = [
        "friction",
        "mass_on_belt",
        "impact_oscillator",
        "two_modes_on_belt",
        "damped_contact",
    ];
    let table = tables.iter().find_map(|name| scene.get(*name)?.as_object());
    let values = table.into_iter().flatten();
    let scalars = values.filter(|(_, value)| !value.is_array() && !value.is_object());
    let all: Vec<String> = scalars
        .map(|(key, value)| format!("{key} {value}"))
        .collect();
    all.join(", ")
}

/// A message with the surface of the body and the shapes of its modes, mode by mode.
fn with_body(message: Message, joint: &JointInfo) -> Message {
    let surface = &joint.outline;
    let Ok(_) = u16::try_from(surface.vertices.len()) else {
        return message;
    };
    let vertices = surface.vertices.iter().flatten();
    let corners = surface.triangles.iter().flatten();
    message
        .floats("vertices", vertices.map(|&x| x as f32))
        .indices("triangles", corners.map(|&corner| corner as u16))
        .fractions("shapes", surface.shapes_by_mode())
}

/// Horizontal and vertical unit vector of the picture of the patch, seen from outside: the direction in which the
/// load tilts, and the one perpendicular to it.
fn patch_axes(direction: [f64; 3], azimuth: f64) -> [[f64; 3]; 2] {
    let [dx, dy, dz] = direction;
    let (sin, cos) = azimuth.sin_cos();
    let along = cos * dx + sin * dy;
    let right = [cos - along * dx, sin - along * dy, -along * dz];
    let length = right.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-9);
    let [rx, ry, rz] = right.map(|c| c / length);
    let up = [dy * rz - dz * ry, dz * rx - dx * rz, dx * ry - dy * rx];
    [[rx, ry, rz], up]
}

/// Pixels of 0 or 255, 8 a byte, the first in the highest bit.
fn packed(pixels: &[u8]) -> Vec<u8> {
    let byte = |eight: &[u8]| {
        let bits = eight.iter().enumerate();
        bits.fold(0, |byte, (k, &pixel)| byte | (pixel & 0x80) >> k)
    };
    pixels.chunks(8).map(byte).collect()
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
