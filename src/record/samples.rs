//! Scalar series: probe, modes, energies, tilt, load and rotation.

use super::{paths, plot::texts, stream::RecordingStream, style};
use crate::pipeline::message::{Frame, JointInfo, ModeInfo};
use crate::plot::Color;

/// Adds displacement and velocity of the probe, those that are shown.
pub fn push_probe(rec: &RecordingStream, frame: &Frame) {
    let series = [
        (paths::DISPLACEMENT, &frame.displacement, 1e6),
        (paths::VELOCITY, &frame.velocity, 1e3),
    ];
    for (path, values, factor) in series {
        let values = shown(frame).map(|k| (frame.time(k), [factor * values[k]]));
        rec.rows(path, values);
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
    pub fn new(rec: &RecordingStream, joint: &JointInfo) -> Self {
        let one = |path, name, color| rec.name(path, [(name, color)]);
        one(paths::DISPLACEMENT, "displacement, µm", Color::Run);
        one(paths::VELOCITY, "velocity, mm/s", style::LOAD);
        one(paths::TILT, "tilt, deg", style::LOAD);
        if joint.load_varies() {
            one(paths::LOAD_NOW, "load, N", style::LOAD);
        }
        if joint.rotation_varies() {
            one(paths::ROTATION_FACTOR, "rotation factor", style::ROTATION);
        }
        for path in [paths::MODES_Q, paths::MODES_QDOT, paths::MODES_ENERGY] {
            let names = joint.modes.iter().map(mode_name);
            rec.name(path, names.zip((0..).map(Color::Series)));
        }
        draw_mode_legend(rec, joint);
        let energies = vec![
            ("stored, µJ".to_owned(), Color::Run, 3.6),
            ("work of friction, µJ".to_owned(), style::FRICTION, 1.2),
            ("residual, µJ".to_owned(), Color::Compared, 1.2),
        ];
        // The first two nearly coincide; the wide line remains visible behind the narrow one.
        rec.start(paths::ENERGY, energies, true);
        Self {
            last_energy: f64::NEG_INFINITY,
        }
    }

    /// Adds a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) {
        push_probe(rec, frame);
        let modal = [
            (paths::MODES_Q, &frame.q, 1e6),
            (paths::MODES_QDOT, &frame.qdot, 1e3),
        ];
        for (path, values, factor) in modal {
            let values = shown(frame).map(|k| {
                let row = values[k * frame.modes..][..frame.modes].iter();
                (frame.time(k), row.map(move |value| factor * value))
            });
            rec.rows(path, values);
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
            rec.row(paths::MODES_ENERGY, sample.time, modal);
            let sums = [sample.total, sample.friction_work, sample.residual];
            rec.row(paths::ENERGY, sample.time, sums.map(|e| 1e6 * e));
        }
        if !frame.is_empty() {
            rec.row(paths::TILT, frame.t0, [frame.tilt.to_degrees()]);
            rec.row(paths::LOAD_NOW, frame.t0, [frame.load]);
            rec.row(paths::ROTATION_FACTOR, frame.t0, [frame.rotation_factor]);
        }
    }
}

/// Most modes in the legend; line height and width of the legend, pixels.
const KEY_MODES: usize = 11;
const KEY_LINE: f32 = 30.0;
const KEY_WIDTH: f32 = 190.0;

/// Bounds of the view of the legend, with a line for each colour and one more.
pub fn mode_legend_bounds() -> [[f32; 2]; 2] {
    let height = KEY_LINE * (KEY_MODES as f32 + 1.0);
    [[0.0, KEY_WIDTH], [0.0, height]]
}

/// Draws the labels of the modes in their colours, one below the other.
fn draw_mode_legend(rec: &RecordingStream, joint: &JointInfo) {
    let entries = joint.modes.iter().take(KEY_MODES).enumerate();
    let entries = entries.map(|(k, mode)| {
        let at = [0.5 * KEY_WIDTH, KEY_LINE * (k as f32 + 0.5)];
        (at, mode_name(mode), Color::Series(k))
    });
    rec.log_static(paths::MODES_LEGEND, &texts(entries.collect()));
}

/// Label and frequency of a mode.
fn mode_name(mode: &ModeInfo) -> String {
    format!("{} · {:.2} kHz", mode.label, 1e-3 * mode.frequency_hz)
}
