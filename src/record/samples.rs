//! Scalar series: probe, modes, energies, tilt, load and rotation.

use crate::record::sdk::{Color, Points2D, Radius, Scalars, SeriesLines};

use super::{
    error::RecordError,
    paths,
    plot::Bounds,
    stream::{self, RecordingStream},
    style,
};
use crate::pipeline::message::{Frame, JointInfo, ModeInfo};

/// Rows per batch. A larger batch needs fewer entries in the index of a file.
const BATCH_ROWS: usize = 4000;

/// Pending rows of the entities with time series, sent in the order in which the entities were added.
#[derive(Debug, Default)]
pub struct Rows(Vec<(String, Pending)>);

/// Pending rows of one entity, all of the same width.
#[derive(Debug)]
struct Pending {
    width: usize,
    times: Vec<i64>,
    values: Vec<f64>,
}

impl Rows {
    /// Adds an entity with series of these names and colours; without names the viewer shows the path.
    pub fn name<N: Into<String>>(
        &mut self,
        rec: &RecordingStream,
        path: &str,
        series: impl IntoIterator<Item = (N, Color)>,
    ) -> Result<(), RecordError> {
        let series = series.into_iter();
        let (names, colors): (Vec<String>, Vec<Color>) =
            series.map(|(name, color)| (name.into(), color)).unzip();
        self.add(path, names.len());
        name_series(rec, path, names, colors)
    }

    /// Adds an entity of `width` series.
    pub fn add(&mut self, path: &str, width: usize) {
        let none = Pending {
            width,
            times: Vec::new(),
            values: Vec::new(),
        };
        self.0.push((path.to_owned(), none));
    }

    /// Adds a row at a time (s), as [`Rows::extend`].
    pub fn push(&mut self, path: &str, time: f64, row: impl IntoIterator<Item = f64>) {
        self.extend(path, [(time, row)]);
    }

    /// Adds rows of an entity, each with its time (s) and a value for each series. Rows of an entity that was not added are
    /// ignored: the run has no such series.
    pub fn extend<R: IntoIterator<Item = f64>>(
        &mut self,
        path: &str,
        rows: impl IntoIterator<Item = (f64, R)>,
    ) {
        let mut all = self.0.iter_mut();
        let Some((_, pending)) = all.find(|(known, _)| known == path) else {
            return;
        };
        for (time, row) in rows {
            pending.times.push(stream::nanos(time));
            pending.values.extend(row);
        }
        debug_assert_eq!(pending.values.len(), pending.times.len() * pending.width);
    }

    /// Sends full batches.
    pub fn send_full(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.send_from(rec, BATCH_ROWS)
    }

    /// Sends all rows.
    pub fn send(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.send_from(rec, 1)
    }

    fn send_from(&mut self, rec: &RecordingStream, least: usize) -> Result<(), RecordError> {
        for (path, pending) in &mut self.0 {
            if pending.times.len() >= least {
                let lengths = std::iter::repeat_n(pending.width, pending.times.len());
                let columns = Scalars::new(pending.values.drain(..)).columns(lengths);
                stream::send_rows(rec, path, &pending.times, columns)?;
                pending.times.clear();
            }
        }
        Ok(())
    }
}

/// Sets names and colours of the series of an entity.
pub fn name_series(
    rec: &RecordingStream,
    path: &str,
    names: impl IntoIterator<Item = String>,
    colors: impl IntoIterator<Item = Color>,
) -> Result<(), RecordError> {
    let style = SeriesLines::new()
        .with_names(names)
        .with_colors(colors)
        .with_widths([1.2]);
    rec.log_static(path, &style)
}

/// Adds displacement and velocity of the probe, those that are shown.
pub fn push_probe(rows: &mut Rows, frame: &Frame) {
    let series = [
        (paths::DISPLACEMENT, &frame.displacement, 1e6),
        (paths::VELOCITY, &frame.velocity, 1e3),
    ];
    for (path, values, factor) in series {
        let values = shown(frame).map(|k| (frame.time(k), [factor * values[k]]));
        rows.extend(path, values);
    }
}

/// The samples of a frame that are shown.
fn shown(frame: &Frame) -> impl Iterator<Item = usize> {
    (0..frame.len()).step_by(frame.shown.map_or(1, |shown| shown.every))
}

/// The scalar series of a joint.
#[derive(Debug)]
pub struct Samples {
    /// Time of the last displayed energy sample, s.
    last_energy: f64,
}

impl Samples {
    /// Names the series.
    pub fn new(
        rec: &RecordingStream,
        rows: &mut Rows,
        joint: &JointInfo,
    ) -> Result<Self, RecordError> {
        let mut one = |path, name, color| rows.name(rec, path, [(name, color)]);
        one(paths::DISPLACEMENT, "displacement, µm", style::SIGNAL)?;
        one(paths::VELOCITY, "velocity, mm/s", style::LOAD)?;
        one(paths::TILT, "tilt, deg", style::LOAD)?;
        if joint.load_varies() {
            one(paths::LOAD_NOW, "load, N", style::LOAD)?;
        }
        if joint.rotation_varies() {
            one(paths::ROTATION_FACTOR, "rotation factor", style::ROTATION)?;
        }
        for path in [paths::MODES_Q, paths::MODES_QDOT, paths::MODES_ENERGY] {
            let names = joint.modes.iter().map(mode_name);
            rows.name(rec, path, names.zip(style::MODES.into_iter().cycle()))?;
        }
        draw_mode_legend(rec, joint)?;
        let energies = [
            ("stored, µJ", style::SIGNAL),
            ("work of friction, µJ", style::FRICTION),
            ("residual, µJ", style::ACCENT),
        ];
        rows.name(rec, paths::ENERGY, energies)?;
        // The first two nearly coincide; the wide line remains visible behind the narrow one.
        let widths = SeriesLines::update_fields().with_widths([3.6, 1.2, 1.2]);
        rec.log_static(paths::ENERGY, &widths)?;
        Ok(Self {
            last_energy: f64::NEG_INFINITY,
        })
    }

    /// Adds a frame.
    pub fn push(&mut self, rows: &mut Rows, frame: &Frame) {
        push_probe(rows, frame);
        let modal = [
            (paths::MODES_Q, &frame.q, 1e6),
            (paths::MODES_QDOT, &frame.qdot, 1e3),
        ];
        for (path, values, factor) in modal {
            let values = shown(frame).map(|k| {
                let row = values[k * frame.modes..][..frame.modes].iter();
                (frame.time(k), row.map(move |value| factor * value))
            });
            rows.extend(path, values);
        }
        let interval = frame.shown.map_or(0.0, |shown| 1.0 / shown.energies());
        for sample in &frame.energy {
            // Half a sample of tolerance: times are rounded.
            let late = sample.time + 0.5 * frame.dt - self.last_energy;
            if late < interval {
                continue;
            }
            self.last_energy = sample.time;
            let modal = sample.modal.iter().map(|e| 1e6 * e);
            rows.push(paths::MODES_ENERGY, sample.time, modal);
            let sums = [sample.total, sample.friction_work, sample.residual];
            rows.push(paths::ENERGY, sample.time, sums.map(|e| 1e6 * e));
        }
        if !frame.is_empty() {
            rows.push(paths::TILT, frame.t0, [frame.tilt.to_degrees()]);
            rows.push(paths::LOAD_NOW, frame.t0, [frame.load]);
            rows.push(paths::ROTATION_FACTOR, frame.t0, [frame.rotation_factor]);
        }
    }
}

/// Line height and width of the legend of the modes, pixels.
const KEY_LINE: f32 = 30.0;
const KEY_WIDTH: f32 = 190.0;
/// Number of lines of the legend: the number of colours.
const KEY_LINES: usize = style::MODES.len();

/// Bounds of the view of the legend.
pub fn mode_legend_bounds() -> Bounds {
    Bounds {
        x: [0.0, KEY_WIDTH],
        y: [0.0, KEY_LINE * (KEY_LINES as f32 + 1.0)],
    }
}

/// Draws the labels of the modes in their colours, one below the other.
fn draw_mode_legend(rec: &RecordingStream, joint: &JointInfo) -> Result<(), RecordError> {
    let modes = || joint.modes.iter().take(KEY_LINES);
    let places = (0..modes().len()).map(|k| [0.5 * KEY_WIDTH, KEY_LINE * (k as f32 + 0.5)]);
    let key = Points2D::new(places)
        .with_labels(modes().map(mode_name))
        .with_show_labels(true)
        .with_colors(style::MODES)
        .with_radii([Radius::new_ui_points(0.0)]);
    rec.log_static(paths::MODES_LEGEND, &key)
}

/// Label and frequency of a mode.
fn mode_name(mode: &ModeInfo) -> String {
    format!("{} · {:.2} kHz", mode.label, 1e-3 * mode.frequency_hz)
}
