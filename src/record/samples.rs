//! Scalar series: probe, modes, energies, tilt, load and rotation.

use crate::record::sdk::{Points2D, Radius, Scalars, SeriesLines};

use super::{
    error::RecordError,
    paths,
    plot::Bounds,
    stream::{self, RecordingStream},
    style,
};
use crate::pipeline::message::{Frame, JointInfo, ModeInfo, SignalInfo};

/// Rows per batch. A larger batch needs fewer entries in the index of a file.
const BATCH_ROWS: usize = 4000;

/// Pending rows of one entity, all of the same width.
#[derive(Debug)]
pub struct Rows {
    path: String,
    width: usize,
    times: Vec<i64>,
    values: Vec<f64>,
}

impl Rows {
    /// No rows yet, for an entity of `width` series.
    pub fn new(path: impl Into<String>, width: usize) -> Self {
        Self {
            path: path.into(),
            width,
            times: Vec::with_capacity(BATCH_ROWS),
            values: Vec::with_capacity(BATCH_ROWS * width),
        }
    }

    /// Adds a row at a time (s); `row` has as many values as the entity has series.
    pub fn push(&mut self, time: f64, row: impl IntoIterator<Item = f64>) {
        self.times.push(stream::nanos(time));
        self.values.extend(row);
        debug_assert_eq!(self.values.len(), self.times.len() * self.width);
    }

    /// Sends the rows if the batch is full.
    pub fn send_full(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        if self.times.len() < BATCH_ROWS {
            return Ok(());
        }
        self.send(rec)
    }

    /// Sends all rows.
    pub fn send(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        if self.times.is_empty() {
            return Ok(());
        }
        let columns = Scalars::new(self.values.drain(..))
            .columns(std::iter::repeat_n(self.width, self.times.len()));
        stream::send_rows(rec, &self.path, &self.times, columns)?;
        self.times.clear();
        Ok(())
    }
}

/// The scalar series of a joint.
#[derive(Debug)]
pub struct Samples {
    displacement: Rows,
    velocity: Rows,
    q: Rows,
    qdot: Rows,
    modal_energy: Rows,
    /// Time of the last displayed energy sample, s.
    last_energy: f64,
    energy: Rows,
    tilt: Rows,
    /// Load, if it varies.
    load: Option<Rows>,
    /// Rotation factor, if it varies.
    rotation_factor: Option<Rows>,
}

/// Sets names and colours of the series of an entity; without names the viewer shows the path.
pub fn name_series(
    rec: &RecordingStream,
    path: &str,
    names: impl IntoIterator<Item = String>,
    colors: impl IntoIterator<Item = crate::record::sdk::Color>,
) -> Result<(), RecordError> {
    let style = SeriesLines::new()
        .with_names(names)
        .with_colors(colors)
        .with_widths([1.2]);
    rec.log_static(path, &style)
}

impl Samples {
    /// Names the series and starts empty.
    pub fn new(rec: &RecordingStream, joint: &JointInfo) -> Result<Self, RecordError> {
        let one = |path, name: &str, color| name_series(rec, path, [name.to_owned()], [color]);
        one(paths::DISPLACEMENT, "displacement, µm", style::SIGNAL)?;
        one(paths::VELOCITY, "velocity, mm/s", style::LOAD)?;
        one(paths::TILT, "tilt, deg", style::LOAD)?;
        let varying = |varies: bool, path, name, color| -> Result<Option<Rows>, RecordError> {
            if !varies {
                return Ok(None);
            }
            one(path, name, color)?;
            Ok(Some(Rows::new(path, 1)))
        };
        let load = varying(joint.load_varies(), paths::LOAD_NOW, "load, N", style::LOAD)?;
        let rotation_factor = varying(
            joint.rotation_varies(),
            paths::ROTATION_FACTOR,
            "rotation factor",
            style::ROTATION,
        )?;
        for path in [paths::MODES_Q, paths::MODES_QDOT, paths::MODES_ENERGY] {
            let colors = (0..joint.modes.len()).map(|i| style::MODES[i % style::MODES.len()]);
            name_series(rec, path, joint.modes.iter().map(mode_name), colors)?;
        }
        draw_mode_legend(rec, joint)?;
        name_series(
            rec,
            paths::ENERGY,
            ["stored, µJ", "work of friction, µJ", "residual, µJ"].map(str::to_owned),
            [style::SIGNAL, style::FRICTION, style::ACCENT],
        )?;
        // The first two nearly coincide; the wide line remains visible behind the narrow one.
        let widths = SeriesLines::update_fields().with_widths([3.6, 1.2, 1.2]);
        rec.log_static(paths::ENERGY, &widths)?;
        let modes = joint.modes.len();
        Ok(Self {
            displacement: Rows::new(paths::DISPLACEMENT, 1),
            velocity: Rows::new(paths::VELOCITY, 1),
            q: Rows::new(paths::MODES_Q, modes),
            qdot: Rows::new(paths::MODES_QDOT, modes),
            modal_energy: Rows::new(paths::MODES_ENERGY, modes),
            last_energy: f64::NEG_INFINITY,
            energy: Rows::new(paths::ENERGY, 3),
            tilt: Rows::new(paths::TILT, 1),
            load,
            rotation_factor,
        })
    }

    /// Adds a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        let rows = frame.q.chunks_exact(frame.modes);
        let rates = frame.qdot.chunks_exact(frame.modes);
        let samples = rows.zip(rates).enumerate();
        for (k, (q, qdot)) in samples.step_by(frame.shown.map_or(1, |shown| shown.every)) {
            let time = frame.time(k);
            self.displacement.push(time, [1e6 * frame.displacement[k]]);
            self.velocity.push(time, [1e3 * frame.velocity[k]]);
            self.q.push(time, q.iter().map(|x| 1e6 * x));
            self.qdot.push(time, qdot.iter().map(|x| 1e3 * x));
        }
        let interval = frame.shown.map_or(0.0, |shown| 1.0 / shown.energies());
        for sample in &frame.energy {
            // Half a sample of tolerance: times are rounded.
            let late = sample.time + 0.5 * frame.dt - self.last_energy;
            if late < interval {
                continue;
            }
            self.last_energy = sample.time;
            self.modal_energy
                .push(sample.time, sample.modal.iter().map(|e| 1e6 * e));
            let sums = [sample.total, sample.friction_work, sample.residual];
            self.energy.push(sample.time, sums.map(|e| 1e6 * e));
        }
        if !frame.is_empty() {
            self.tilt.push(frame.t0, [frame.tilt.to_degrees()]);
            if let Some(load) = &mut self.load {
                load.push(frame.t0, [frame.load]);
            }
            if let Some(factor) = &mut self.rotation_factor {
                factor.push(frame.t0, [frame.rotation_factor]);
            }
        }
        for rows in self.all() {
            rows.send_full(rec)?;
        }
        Ok(())
    }

    /// Sends pending rows.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        for rows in self.all() {
            rows.send(rec)?;
        }
        Ok(())
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Rows> {
        let always = [
            &mut self.displacement,
            &mut self.velocity,
            &mut self.q,
            &mut self.qdot,
            &mut self.modal_energy,
            &mut self.energy,
            &mut self.tilt,
        ];
        let varying = [&mut self.load, &mut self.rotation_factor];
        always.into_iter().chain(varying.into_iter().flatten())
    }
}

/// The samples of a signal from a file, in their own unit.
#[derive(Debug)]
pub struct Waveform(Rows);

impl Waveform {
    /// Names the series and starts empty.
    pub fn new(rec: &RecordingStream, signal: &SignalInfo) -> Result<Self, RecordError> {
        let name = format!("{}, {}", style::signal_name(signal), signal.unit);
        let name = name.trim_end_matches(", ").to_owned();
        name_series(rec, paths::WAVEFORM, [name], [style::SIGNAL])?;
        Ok(Self(Rows::new(paths::WAVEFORM, 1)))
    }

    /// Adds a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        for (k, &value) in frame.displacement.iter().enumerate() {
            self.0.push(frame.time(k), [value]);
        }
        self.0.send_full(rec)
    }

    /// Sends pending rows.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.0.send(rec)
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
