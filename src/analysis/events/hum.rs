//! Mains hum: steady lines at multiples of 50 or 60 Hz.

use super::Hum;
use super::ridge::Ridge;
use super::spectrogram::peaks;

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

/// Highest multiple of a line that makes hum alone, and of the lowest of several.
const ALONE: f64 = 2.5;
const LOWEST: f64 = 6.5;

/// Least number of columns in which steadiness can be seen.
const LEAST_COLUMNS: usize = 4;

/// Least power of a line relative to the recording's: below are lines of quantisation.
const LEAST_POWER: f64 = 1e-7;

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
        // Frequencies and powers of the lines near each multiple, column by column.
        let line = |multiple: f64, mains: f64| {
            let reach = MAINS_DEVIATION * multiple + 0.5 * peaks.bin_hz;
            let mut found: Vec<(f64, f64)> = peaks
                .columns
                .iter()
                .filter_map(|column| {
                    let near = column.iter().filter(|peak| {
                        (peak.bin * peaks.bin_hz - multiple).abs() < reach
                            && peak.ratio > LEAST_RATIO
                            && peak.power > LEAST_POWER * power
                    });
                    let best = near.max_by(|a, b| a.power.total_cmp(&b.power))?;
                    Some((best.bin * peaks.bin_hz, best.power))
                })
                .collect();
            if (found.len() as f64) < LEAST_SHARE * peaks.columns.len() as f64 {
                return None;
            }
            let middle = found.len() / 2;
            let power = found
                .select_nth_unstable_by(middle, |a, b| a.1.total_cmp(&b.1))
                .1
                .1;
            let frequency = found
                .select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0))
                .1
                .0;
            Some((frequency, power, (multiple / mains).round()))
        };
        let of = |mains: f64| {
            let count = (HIGHEST_HZ / mains) as usize;
            let lines: Vec<_> = (1..=count)
                .filter_map(|k| line(k as f64 * mains, mains))
                .collect();
            let weight: f64 = lines.iter().map(|l| l.1).sum();
            let fundamental = lines.iter().map(|l| l.1 * l.0 / l.2).sum::<f64>() / weight;
            let is_multiple = |l: &&(f64, f64, f64)| {
                (l.0 - l.2 * fundamental).abs() < LINE_DEVIATION_HZ + 0.002 * l.0
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
        let lowest = lines.first()?.0 / fundamental_hz;
        let is_hum = lowest < ALONE || lines.len() > 1 && lowest < LOWEST;
        is_hum.then_some(Self {
            fundamental_hz,
            lines,
        })
    }

    /// Whether a ridge is a line of hum: at its frequency and not much stronger.
    pub fn has(&self, ridge: &Ridge) -> bool {
        self.lines.iter().any(|(frequency, power)| {
            let reach = (0.35 * ridge.bin_hz).max(1.5);
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
            level_db_fs: 10.0 * (power / (0.5 * full_scale * full_scale)).log10(),
        }
    }
}
