//! Mains hum: steady lines at multiples of 50 or 60 Hz.

use super::Hum;
use super::ridge::Ridge;
use super::spectrogram::{Peak, peaks};

/// Duration of the windows, s: hum is steady over seconds, a squeak is not.
const WINDOW_S: f64 = 1.5;

/// Highest frequency of a line of hum, Hz.
const HIGHEST_HZ: f64 = 2000.0;

/// Largest relative deviation of the mains from its frequency, and of lines from multiples.
const MAINS_DEVIATION: f64 = 0.004;
const LINE_DEVIATION_HZ: f64 = 0.35;

/// Least ratio of a line to its noise floor, and least share of the columns with the line.
const LEAST_RATIO: f64 = 6.0;
const LEAST_SHARE: f64 = 0.75;

/// Highest multiple of a line that is hum alone (that of a rectifier), and of several that are.
const ALONE: f64 = 2.5;
const LOW: f64 = 8.5;
const SEVERAL: usize = 3;

/// Largest deviation of the power of a line from its median in a column, logarithm.
const LEVEL_DEVIATION: f64 = 1.4;

/// Distance of a frequency that may be a line's, Hz.
const NEAR_HZ: f64 = 10.0;

/// Least number of columns in which steadiness can be seen.
const LEAST_COLUMNS: usize = 5;

/// Least power of a line relative to the recording's: below are lines of quantisation.
const LEAST_POWER: f64 = 1e-7;

/// The median of values, if there are any.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// Lines of hum.
pub(super) struct Lines {
    pub fundamental_hz: f64,
    /// Frequency (Hz) and median power of each line.
    pub lines: Vec<(f64, f64)>,
}

impl Lines {
    /// The hum of a recording.
    pub fn find(samples: &[f64], rate_hz: f64) -> Option<Self> {
        let peaks = peaks(samples, rate_hz, WINDOW_S, [40.0, HIGHEST_HZ]);
        if peaks.columns.len() < LEAST_COLUMNS {
            return None;
        }
        let power = samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64;
        // Columns that are wholly inside the recording.
        let columns = &peaks.columns[1..peaks.columns.len() - 1];
        // Median frequency and power of the steady line near a multiple of the mains, and the multiple.
        let line = |multiple: f64, mains: f64| {
            let reach = MAINS_DEVIATION * multiple + 0.5 * peaks.bin_hz;
            let strongest = |column: &Vec<Peak>| {
                let near = column.iter().filter(|peak| {
                    (peak.bin * peaks.bin_hz - multiple).abs() < reach
                        && peak.ratio > LEAST_RATIO
                        && peak.power > LEAST_POWER * power
                });
                let best = near.max_by(|a, b| a.power.total_cmp(&b.power))?;
                Some((best.bin * peaks.bin_hz, best.power))
            };
            let found: Vec<(f64, f64)> = columns.iter().filter_map(strongest).collect();
            let frequency = median(found.iter().map(|line| line.0))?;
            let power = median(found.iter().map(|line| line.1))?;
            let is_steady = |(f, p): &&(f64, f64)| {
                (f - frequency).abs() < LINE_DEVIATION_HZ
                    && (p / power).ln().abs() < LEVEL_DEVIATION
            };
            let steady = found.iter().filter(is_steady).count() as f64;
            (steady >= LEAST_SHARE * columns.len() as f64).then_some((
                frequency,
                power,
                (multiple / mains).round(),
            ))
        };
        let of = |mains: f64| {
            let count = (HIGHEST_HZ / mains) as usize;
            let lines: Vec<_> = (1..=count)
                .filter_map(|k| line(k as f64 * mains, mains))
                .collect();
            let weight: f64 = lines.iter().map(|l| l.1).sum();
            let fundamental = lines.iter().map(|l| l.1 * l.0 / l.2).sum::<f64>() / weight;
            let is_multiple = |l: &&(f64, f64, f64)| {
                (l.0 - l.2 * fundamental).abs() < LINE_DEVIATION_HZ + 0.0005 * l.0
            };
            let lines: Vec<(f64, f64)> = lines
                .iter()
                .filter(is_multiple)
                .map(|l| (l.0, l.1))
                .collect();
            (fundamental, lines, weight)
        };
        // Multiples of 300 Hz belong to both.
        let (fundamental_hz, lines, _): (f64, Vec<(f64, f64)>, f64) = [50.0, 60.0]
            .map(of)
            .into_iter()
            .max_by(|a, b| (a.1.len() as f64 * a.2).total_cmp(&(b.1.len() as f64 * b.2)))?;
        let multiples: Vec<f64> = lines.iter().map(|l| l.0 / fundamental_hz).collect();
        let low = multiples.iter().filter(|k| **k < LOW).count();
        let is_hum = *multiples.first()? < ALONE || low >= SEVERAL;
        is_hum.then_some(Self {
            fundamental_hz,
            lines,
        })
    }

    /// Whether a frequency is near that of a line.
    pub fn is_near(&self, frequency_hz: f64) -> bool {
        let near = |line: &(f64, f64)| (line.0 - frequency_hz).abs() < NEAR_HZ;
        self.lines.iter().any(near)
    }

    /// Whether a ridge is a line of hum: at its frequency and not much stronger.
    pub fn has(&self, ridge: &Ridge) -> bool {
        self.lines.iter().any(|(frequency, power)| {
            let reach = (0.35 * ridge.bin_hz).clamp(1.5, 3.0);
            let near = ridge
                .points
                .iter()
                .filter(|p| (p.frequency_hz - frequency).abs() < reach);
            near.count() as f64 > 0.6 * ridge.points.len() as f64 && ridge.power() < 4.0 * power
        })
    }

    /// The result.
    pub fn hum(&self, full_scale: f64) -> Hum {
        let power: f64 = self.lines.iter().map(|line| line.1).sum();
        Hum {
            fundamental_hz: self.fundamental_hz,
            harmonics: self.lines.len(),
            level_db: 10.0 * (power / (0.5 * full_scale * full_scale)).log10(),
        }
    }
}
