//! Mains hum: steady lines at multiples of 50 or 60 Hz.

use super::Hum;
use super::baseband::median;
use super::ridge::Ridge;
use super::spectrogram::{LOBE, powers, vertex, window_length};

/// Duration of the windows, s: hum is steady over seconds, a squeak is not.
const WINDOW_S: f64 = 1.5;

/// Frequencies of the mains, Hz, and their largest relative deviation.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
const MAINS_DEVIATION: f64 = 0.004;

/// Highest frequency of a line, Hz.
const HIGHEST_HZ: f64 = 2000.0;

/// Least ratio of a line to its noise floor, the median of the bins beyond its main lobe up to [`SIDE`].
const LEAST_RATIO: f64 = 6.0;
const SIDE: usize = 16;

/// Least power of a line relative to the recording's: below are lines of quantisation.
const LEAST_POWER: f64 = 1e-7;

/// A line of hum.
#[derive(Clone, Copy)]
struct Line {
    multiple: usize,
    frequency_hz: f64,
    power: f64,
}

/// Lines of hum.
pub(super) struct Lines {
    fundamental_hz: f64,
    lines: Vec<Line>,
}

impl Lines {
    /// The hum of a recording of at least three windows: the lines of the spectrum that has the median over time in each bin,
    /// so that what sounds for less than half of the time does not count. Hum has its fundamental or the line of a rectifier at
    /// twice its frequency, or three multiples up to the eighth.
    pub fn find(samples: &[f64], rate_hz: f64) -> Option<Self> {
        let length = window_length(WINDOW_S, rate_hz);
        let bin_hz = rate_hz / length as f64;
        let bins = (HIGHEST_HZ.min(0.45 * rate_hz) / bin_hz) as usize;
        let columns = powers(samples, length, bins);
        // Columns that are wholly inside the recording.
        let inside = columns.get(1..columns.len() - 1)?;
        if inside.len() < 3 {
            return None;
        }
        let median_of = |k: usize| median(inside.iter().map(|column| column[k]));
        let steady: Vec<f64> = (0..bins).map(median_of).collect();
        let power = samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64;
        let line = |mains: f64, multiple: usize| {
            let centre = multiple as f64 * mains / bin_hz;
            let reach = MAINS_DEVIATION * centre + 0.5;
            let [first, last] = [(centre - reach).ceil(), (centre + reach).floor()];
            let near = first as usize..=(last as usize).min(bins - SIDE - 1);
            let best = near.max_by(|a, b| steady[*a].total_cmp(&steady[*b]))?;
            let [below, above] = [best.saturating_sub(SIDE), best + SIDE + 1];
            let sides = [&steady[below..best - LOBE], &steady[best + LOBE + 1..above]];
            let floor = median(sides.into_iter().flatten().copied());
            let (shift, height) = vertex([steady[best - 1], steady[best], steady[best + 1]]);
            let stands_out = height > LEAST_RATIO * floor && 2.0 * height > LEAST_POWER * power;
            (stands_out && shift.abs() <= 1.0).then_some(Line {
                multiple,
                frequency_hz: (best as f64 + shift) * bin_hz,
                power: 2.0 * height,
            })
        };
        let hum = |mains: f64| {
            let count = (bins - SIDE - 1) as f64 * bin_hz / mains / (1.0 + MAINS_DEVIATION);
            let mut lines: Vec<Line> = (1..=count as usize)
                .filter_map(|k| line(mains, k))
                .collect();
            if lines.is_empty() {
                return None;
            }
            let fundamentals = lines.iter().map(|l| l.frequency_hz / l.multiple as f64);
            let fundamental_hz = median(fundamentals);
            lines.retain(|l| (l.frequency_hz - l.multiple as f64 * fundamental_hz).abs() < bin_hz);
            let low = lines.iter().filter(|l| l.multiple <= 8).count();
            let is_hum = lines.first().is_some_and(|l| l.multiple <= 2) || low >= 3;
            let weight = lines.len() as f64 * lines.iter().map(|l| l.power).sum::<f64>();
            is_hum.then_some((
                weight,
                Self {
                    fundamental_hz,
                    lines,
                },
            ))
        };
        // Multiples of 300 Hz belong to both.
        let found = MAINS_HZ.into_iter().filter_map(hum);
        Some(found.max_by(|a, b| a.0.total_cmp(&b.0))?.1)
    }

    /// Whether a ridge is a line of hum: at its frequency and not much stronger.
    pub fn has(&self, ridge: &Ridge) -> bool {
        self.lines.iter().any(|line| {
            let reach = (0.35 * ridge.bin_hz).clamp(1.5, 3.0);
            let distances = ridge
                .points
                .iter()
                .map(|p| (p.frequency_hz - line.frequency_hz).abs());
            let near = distances.filter(|distance| *distance < reach).count();
            near as f64 > 0.6 * ridge.points.len() as f64 && ridge.power() < 4.0 * line.power
        })
    }

    /// The result.
    pub fn hum(&self, full_scale: f64) -> Hum {
        let power: f64 = self.lines.iter().map(|line| line.power).sum();
        Hum {
            fundamental_hz: self.fundamental_hz,
            harmonics: self.lines.len(),
            level_db: 10.0 * (power / (0.5 * full_scale * full_scale)).log10(),
        }
    }
}
