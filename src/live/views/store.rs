//! The present picture of a run and a short past, and what is new for a client.

use std::collections::{VecDeque, vec_deque};
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::encode::Message;
use crate::pipeline::message::{
    Frame, Header, JointInfo, PatchGeometry, PatchSnapshot, Record, Subject,
};
use crate::plot::{LessonPictures, Panel};
use crate::scene::StateCoordinate;

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

/// A picture and its number; 0 means none.
#[derive(Debug, Default)]
struct Latest<T> {
    number: u64,
    value: T,
}

impl<T> Latest<T> {
    fn set(&mut self, value: T) {
        self.number += 1;
        self.value = value;
    }

    /// The picture, if the client has not got it.
    fn news(&self, known: &mut u64) -> Option<&T> {
        let is_new = *known != self.number;
        *known = self.number;
        is_new.then_some(&self.value)
    }
}

/// A series of which the newest values are kept.
#[derive(Debug)]
struct Series<T> {
    kept: VecDeque<T>,
    /// Number of values so far.
    count: u64,
}

impl<T> Default for Series<T> {
    fn default() -> Self {
        Self {
            kept: VecDeque::new(),
            count: 0,
        }
    }
}

impl<T> Series<T> {
    fn extend(&mut self, values: impl IntoIterator<Item = T>, most: usize) {
        let before = self.kept.len();
        self.kept.extend(values);
        self.count += (self.kept.len() - before) as u64;
        self.kept.drain(..self.kept.len().saturating_sub(most));
    }

    /// The values that the client has not got, at most the newest `most`.
    fn news<'a>(&'a self, known: &mut u64, most: usize) -> vec_deque::Iter<'a, T> {
        let new = (self.count - std::mem::replace(known, self.count)) as usize;
        let new = new.min(most).min(self.kept.len());
        self.kept.range(self.kept.len() - new..)
    }
}

/// A spectrum.
#[derive(Debug, Default)]
struct Spectrum {
    /// Spacing of the bins, Hz.
    bin: f64,
    amplitude: Vec<f32>,
    lines: Value,
}

/// A recurrence plot, 8 pixels a byte.
#[derive(Debug, Default)]
struct Recurrence {
    size: usize,
    window: f64,
    rate: f64,
    bits: Vec<u8>,
}

/// A stroboscope for body and contact patch: it flashes once per frame, in step with the strongest line, so that a vibration
/// too fast for the eye is seen in slow motion.
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
    magnification: f64,
    /// Axes of the picture of the patch: azimuth of the tilt, rad.
    azimuth: f64,
    /// Upper limit of frequency axes, Hz.
    highest_frequency: f64,
    /// End of the last frame, s, and its tilt, rad.
    time: f64,
    tilt: f64,
    /// Displacement (m) and velocity (m/s) of the probe.
    samples: Series<[f32; 2]>,
    /// Modal coordinates for the picture of the body.
    pose: Vec<f32>,
    strobe: Strobe,
    geometry: Latest<Arc<PatchGeometry>>,
    snapshot: Latest<PatchSnapshot>,
    spectrum: Latest<Spectrum>,
    recurrence: Latest<Recurrence>,
    /// Spacing of the bins of the columns, Hz, and of the columns, s.
    column_bin: f64,
    column_every: f64,
    column_time: f64,
    columns: Series<Vec<u8>>,
    points: Series<[f32; 2]>,
    lesson: LessonPictures,
}

/// Cursor of a client in the data of the views: what it has got.
#[derive(Debug, Default)]
pub struct ViewCursor {
    run: u64,
    samples: u64,
    geometry: u64,
    snapshot: u64,
    spectrum: u64,
    recurrence: u64,
    columns: u64,
    points: u64,
}

impl State {
    /// Adds a record.
    pub fn update(&mut self, record: Record, magnification: f64) {
        match record {
            Record::Header(header) => {
                *self = Self {
                    run: self.run + 1,
                    highest_frequency: header.highest_frequency(),
                    azimuth: header.joint().map_or(0.0, |joint| joint.azimuth),
                    header: Some(header),
                    magnification,
                    ..Self::default()
                };
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
                let lines = serde_json::to_value(&peaks).unwrap_or_default();
                let amplitudes = amplitude.iter().map(|a| f64::from(*a)).collect();
                self.lesson.add_spectrum(bin, amplitudes, &peaks);
                self.strobe.frequency = peaks.first().map_or(0.0, |line| line.frequency);
                self.spectrum.set(Spectrum {
                    bin,
                    amplitude,
                    lines,
                });
            }
            Record::SpectrogramColumn {
                time,
                bin,
                level_db,
            } => {
                let (levels, bin) = self.pooled(&level_db, bin, COLUMN_BINS);
                let [low, high] = LEVELS;
                let byte = |db: f32| (255.0 * (db - low) / (high - low)) as u8;
                self.column_bin = bin;
                self.column_every = time - std::mem::replace(&mut self.column_time, time);
                let column = levels.into_iter().map(byte).collect();
                self.columns.extend([column], COLUMNS);
            }
            Record::Recurrence { image, .. } => self.recurrence.set(Recurrence {
                size: image.size,
                window: image.window,
                rate: image.rate,
                bits: packed(&image.recurrent),
            }),
            Record::Section { points, .. } => {
                let at = points.iter().map(|point| point.at.map(|x| x as f32));
                self.points.extend(at, POINTS);
            }
            Record::LevelSample(sample) => self.lesson.add_level(&sample),
            Record::TrajectoryDivergence(divergence) => self.lesson.add_divergence(&divergence),
            _ => {}
        }
    }

    /// The pictures of the lesson.
    pub fn lesson(&self) -> Vec<Panel> {
        let header = self.header.as_ref();
        header.map_or_else(Vec::new, |header| self.lesson.panels(header))
    }

    fn add_frame(&mut self, frame: &Frame) {
        (self.time, self.tilt) = (frame.end(), frame.tilt);
        let pairs = frame.displacement.iter().zip(&frame.velocity);
        let pairs = pairs.map(|(&u, &v)| [u as f32, v as f32]);
        self.samples.extend(pairs, SAMPLES);
        if let Some(header) = &self.header {
            self.lesson.add_frame(header, frame);
        }
        let row = self.strobe.sample(frame);
        if let Some(q) = frame.q.chunks_exact(frame.modes.max(1)).nth(row) {
            self.pose = q.iter().map(|&q| q as f32).collect();
        }
        let known = &self.geometry.value;
        if !Arc::ptr_eq(known, &frame.geometry) && **known != *frame.geometry {
            self.geometry.set(Arc::clone(&frame.geometry));
        }
        // The nodes at the same flash as the body.
        let flash = frame.time(row);
        let off = |snapshot: &&PatchSnapshot| (snapshot.time - flash).abs();
        let snapshots = frame.patch.iter();
        if let Some(snapshot) = snapshots.min_by(|a, b| off(a).total_cmp(&off(b))) {
            self.snapshot.set(snapshot.clone());
        }
    }

    /// The values up to the highest frequency in at most `most` bins of equal width, and that width, Hz.
    fn pooled(&self, values: &[f32], bin: f64, most: usize) -> (Vec<f32>, f64) {
        let used = ((self.highest_frequency / bin) as usize + 1).min(values.len());
        let merged = used.div_ceil(most).max(1);
        let maximum = |chunk: &[f32]| chunk.iter().copied().fold(f32::MIN, f32::max);
        let pooled = values[..used].chunks(merged).map(maximum).collect();
        (pooled, bin * merged as f64)
    }

    /// Writes what is new for a client.
    pub fn write(&self, cursor: &mut ViewCursor, message: &mut Message) {
        let Some(header) = &self.header else {
            return;
        };
        if cursor.run != self.run {
            *cursor = ViewCursor {
                run: self.run,
                ..ViewCursor::default()
            };
            self.write_header(header, message);
        }
        let samples = self.samples.news(&mut cursor.samples, MESSAGE_SAMPLES);
        if samples.clone().next().is_some() {
            message.fractions("displacement", samples.clone().map(|s| s[0]));
            message.fractions("velocity", samples.map(|s| s[1]));
            message.floats("pose", self.pose.iter().copied());
        }
        self.write_patch(cursor, message);
        self.write_pictures(cursor, message);
        if !message.is_empty() {
            message.value("run", self.run);
            message.value("time_s", self.time);
            message.value("sample_count", self.samples.count);
            message.value("tilt_deg", self.tilt.to_degrees());
        }
    }

    fn write_header(&self, header: &Header, message: &mut Message) {
        let mut start = Map::new();
        let mut set = |name: &str, value: Value| start.insert(name.to_owned(), value);
        set("scene", json!(header.scene));
        set("sample_rate_hz", json!(header.sample_rate));
        set("highest_frequency_hz", json!(self.highest_frequency));
        set("level_range_db", json!(LEVELS));
        set("silence_m_per_s", json!(header.silence()));
        let names = header.section.map_or_else(
            || ["y(t)", "y(t + 2τ)"].map(str::to_owned),
            |shown| shown.map(|at| section_label(header, at)),
        );
        set("section", json!(names));
        set("parameters", json!(parameters(header)));
        let lesson = header.computed.as_ref();
        set("lesson", json!(lesson.map(|it| it.mechanism.name())));
        if let Subject::Joint(joint) = &header.subject {
            let modes = joint.modes.iter().map(|mode| json!(mode.label));
            set("modes", modes.collect());
            set("body", json!(joint.body));
            set("load_n", json!(joint.largest_load()));
            set("patch_radius_m", json!(joint.patch_radius));
            set("magnification", json!(self.magnification));
            write_body(joint, message);
        }
        message.value("start", start);
    }

    fn write_patch(&self, cursor: &mut ViewCursor, message: &mut Message) {
        let geometry = self.geometry.news(&mut cursor.geometry);
        let snapshot = self.snapshot.news(&mut cursor.snapshot);
        if geometry.is_none() && snapshot.is_none() {
            return;
        }
        let axes = patch_axes(self.geometry.value.direction, self.azimuth);
        let flat = |v: &[f64; 3]| axes.map(|axis| (0..3).map(|i| axis[i] * v[i]).sum::<f64>());
        if let Some(geometry) = geometry {
            let places = geometry.positions.iter().flat_map(flat);
            message.floats("nodes", places.map(|x| x as f32));
            message.floats("areas", geometry.areas.iter().map(|&a| a as f32));
        }
        if let Some(snapshot) = snapshot {
            message.octets("states", snapshot.states.iter().map(|&state| state as u8));
            let forces = snapshot.normal_force.iter().map(|&f| f as f32);
            message.floats("normal_force", forces);
            let friction = snapshot.friction.iter().flat_map(flat);
            message.floats("friction", friction.map(|x| x as f32));
        }
    }

    fn write_pictures(&self, cursor: &mut ViewCursor, message: &mut Message) {
        if let Some(spectrum) = self.spectrum.news(&mut cursor.spectrum) {
            message.value("spectrum_bin_hz", spectrum.bin);
            message.value("lines", spectrum.lines.clone());
            message.floats("spectrum", spectrum.amplitude.iter().copied());
        }
        // The first message has the whole past.
        let most = match cursor.columns {
            0 => COLUMNS,
            _ => MESSAGE_COLUMNS,
        };
        let columns = self.columns.news(&mut cursor.columns, most);
        if let Some(first) = columns.clone().next() {
            message.value("column_bins", first.len());
            message.value("column_bin_hz", self.column_bin);
            message.value("column_every_s", self.column_every);
            message.octets("columns", columns.flatten().copied());
        }
        if let Some(recurrence) = self.recurrence.news(&mut cursor.recurrence) {
            message.value("recurrence_size", recurrence.size);
            message.value("recurrence_window_s", recurrence.window);
            message.value("recurrence_rate", recurrence.rate);
            message.octets("recurrence", recurrence.bits.iter().copied());
        }
        let points = self.points.news(&mut cursor.points, POINTS);
        if points.clone().next().is_some() {
            message.floats("points", points.flatten().copied());
        }
    }
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

/// The surface of the body and the shapes of its modes, mode by mode.
fn write_body(joint: &JointInfo, message: &mut Message) {
    let surface = &joint.outline;
    let Ok(_) = u16::try_from(surface.vertices.len()) else {
        return;
    };
    let vertices = surface.vertices.iter().flatten();
    message.floats("vertices", vertices.map(|&x| x as f32));
    let corners = surface.triangles.iter().flatten();
    message.indices("triangles", corners.map(|&corner| corner as u16));
    let shapes = (0..surface.modes)
        .flat_map(|mode| surface.shapes.iter().skip(mode).step_by(surface.modes))
        .flatten()
        .map(|&x| x as f32);
    message.fractions("shapes", shapes);
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

/// Label of a coordinate of the Poincaré section.
fn section_label(header: &Header, at: StateCoordinate) -> String {
    let mode = |index: usize| {
        let mode = header.joint().and_then(|joint| joint.modes.get(index));
        mode.map_or_else(String::new, |mode| format!(", {}", mode.label))
    };
    match at {
        StateCoordinate::Q(index) => format!("q{}", mode(index)),
        StateCoordinate::Qdot(index) => format!("dq/dt{}", mode(index)),
    }
}

/// Pixels of 0 or 255, 8 a byte, the first in the highest bit.
fn packed(pixels: &[u8]) -> Vec<u8> {
    let byte = |eight: &[u8]| {
        let bits = eight.iter().enumerate();
        bits.fold(0, |byte, (k, &pixel)| byte | (pixel & 0x80) >> k)
    };
    pixels.chunks(8).map(byte).collect()
}
