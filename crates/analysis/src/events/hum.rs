//! Mains hum: steady lines at multiples of 50 or 60 Hz.

use super::Hum;
use super::baseband::LOUDEST_S;
use super::floor::Floor;
use super::modulation::least_ratio;
use super::partial::Partial;
use super::spectrogram::{LOBE, powers, vertex, window_length};
use crate::stats::median;

/// Frequencies of the mains, Hz, and their largest relative deviation.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
const MAINS_DEVIATION: f64 = 0.004;

/// Least power of a line relative to the recording's: below are lines of quantisation.
const LEAST_POWER: f64 = 1e-7;

/// A line of hum.
struct Line {
    multiple: f64,
    frequency_hz: f64,
    power: f64,
}

/// Lines of hum.
pub(super) struct Lines {
    fundamental_hz: f64,
    lines: Vec<Line>,
    /// Spacing of the bins, Hz.
    bin_hz: f64,
}

impl Lines {
    /// The hum of a recording of at least 3 s in windows of 1.5 s, over which hum is steady and a squeak is not: the lines of
    /// the spectrum that has the median over time in each bin, so that what sounds for less than half of the time does not
    /// count. Hum has its fundamental or the line of a rectifier at twice its frequency, or three multiples up to the eighth.
    pub fn find(samples: &[f64], rate_hz: f64) -> Option<Self> {
        let length = window_length(15.0 * LOUDEST_S, rate_hz);
        let bin_hz = rate_hz / length as f64;
        let columns = powers(samples, length);
        // Columns that are wholly inside the recording.
        let inside = columns.get(1..columns.len() - 1)?;
        if inside.len() < 3 {
            return None;
        }
        let median_of = |k: usize| median(inside.iter().map(|column| column[k]));
        let steady: Vec<f64> = (0..columns[0].len()).map(median_of).collect();
        let floor = Floor::new(std::slice::from_ref(&steady), 1.0);
        let power = samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64;
        // Multiples whose ranges do not meet.
        let count = (0.5 / MAINS_DEVIATION) as usize;
        let line = |multiple: f64, mains: f64| {
            let centre = multiple * mains / bin_hz;
            let reach = MAINS_DEVIATION * centre + 0.5;
            let end = ((centre + reach) as usize + 1).min(steady.len() - 1);
            let near = (centre - reach).ceil() as usize..end;
            let best = near.max_by(|a, b| steady[*a].total_cmp(&steady[*b]))?;
            let (shift, height) = vertex([steady[best - 1], steady[best], steady[best + 1]]);
            let stands_out = height > least_ratio(count) * floor.at(0, best)
                && 2.0 * steady[best] > LEAST_POWER * power;
            (stands_out && shift.abs() <= 1.0).then_some(Line {
                multiple,
                frequency_hz: (best as f64 + shift) * bin_hz,
                power: 2.0 * height,
            })
        };
        let hum = |mains: f64| {
            let mut lines: Vec<Line> = (1..count).filter_map(|k| line(k as f64, mains)).collect();
            let fundamental_hz = median(lines.iter().map(|l| l.frequency_hz / l.multiple));
            lines.retain(|l| (l.frequency_hz - l.multiple * fundamental_hz).abs() < bin_hz);
            let low = lines.iter().filter(|l| l.multiple <= 8.0).count();
            let is_hum = lines.first().is_some_and(|l| l.multiple <= 2.0) || low >= 3;
            is_hum.then_some(Self {
                fundamental_hz,
                lines,
                bin_hz,
            })
        };
        // Multiples of 300 Hz belong to both.
        let weight = |hum: &Self| hum.lines.len() as f64 * hum.power();
        let found = MAINS_HZ.into_iter().filter_map(hum);
        found.max_by(|a, b| weight(a).total_cmp(&weight(b)))
    }

    /// Power of all lines.
    fn power(&self) -> f64 {
        self.lines.iter().map(|line| line.power).sum()
    }

    /// Whether a partial is a line of hum: within its main lobe and not much stronger.
    pub fn has(&self, partial: &Partial) -> bool {
        self.lines.iter().any(|line| {
            (partial.frequency_hz - line.frequency_hz).abs() < LOBE as f64 * self.bin_hz
                && partial.power < 4.0 * line.power
        })
    }

    /// The result.
    pub fn hum(&self, full_scale: f64) -> Hum {
        Hum {
            fundamental_hz: self.fundamental_hz,
            harmonics: self.lines.len(),
            level_db: 10.0 * (self.power() / (0.5 * full_scale * full_scale)).log10(),
        }
    }
}
