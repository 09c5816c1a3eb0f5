//! A partial brought to zero frequency along its ridge: ends, frequency and level in fine steps of time.

use std::f64::consts::{PI, TAU};

use rustfft::num_complex::Complex64;

use super::partial::{Partial, STEP_S};
use super::ridge::Ridge;
use crate::stats::{deviation, mean, order_statistic};

/// Time before and after the ridge in which its ends are sought, s.
const MARGIN_S: f64 = 0.4;

/// Half of the time over which power is averaged, steps: 20 ms.
const HALF_SMOOTH: usize = 4;

/// A partial ends where its power falls below a tenth of the mean in its loudest 0.1 s; a little less, for the last
/// peak above a tenth is averaged with what follows.
const END_SHARE: f64 = 0.075;
const LOUDEST_S: f64 = 0.1;

/// Least signal-to-noise ratio of a tone whose loudest 0.1 s are seen; otherwise, the loudest 0.3 s count.
const STRONG: f64 = 20.0;
const STEADY_S: f64 = 0.3;

/// Time for which a strong tone is below a tenth between two events, s.
const PAUSE_S: f64 = 0.12;

/// Longest and shortest low-pass, s.
const LOW_PASS_S: [f64; 2] = [0.05, 0.012];

/// Incoherence of a tone without noise: its frequency varies.
const RESIDUAL: f64 = 0.03;

/// Innovation of a tone: its amplitude and its frequency vary.
const LEAST_INNOVATION: f64 = 1e-3;

/// Largest gain of a step of a faint tone for the ends.
const LARGEST_GAIN: f64 = 2.0;

/// A partial at zero frequency.
pub(super) struct Baseband {
    /// Time of the first value, s.
    first_s: f64,
    /// Steps of the ridge.
    ridge: (usize, usize),
    /// Values of the analytic signal in steps of [`STEP_S`], low-passed; a sine of amplitude `A` gives `A`.
    values: Vec<Complex64>,
    /// The same through the shortest low-pass, which shows fast changes.
    wide: Vec<Complex64>,
    /// Frequency that was brought to zero, at each value, Hz.
    carriers: Vec<f64>,
    /// Noise power in the low-pass.
    noise: f64,
}

impl Baseband {
    pub fn new(samples: &[f64], rate_hz: f64, ridge: &Ridge) -> Self {
        let first_s = (ridge.start() - MARGIN_S).max(0.0);
        let end_s = (ridge.end() + MARGIN_S).min(samples.len() as f64 / rate_hz);
        let [longest, shortest] = LOW_PASS_S;
        let window_s = (1.0 / ridge.bin_hz).clamp(shortest, longest);
        // Sums over blocks of the steps' fifth part, at a carrier constant over each.
        let block_s = 0.2 * STEP_S;
        let blocks = ((end_s - first_s) / block_s) as usize;
        let mut phase = 0.0;
        let mut sums = Vec::with_capacity(blocks);
        let mut carriers = Vec::new();
        for b in 0..blocks {
            let time_s = first_s + (b as f64 + 0.5) * block_s;
            let carrier = ridge.at(time_s).0;
            if b % 5 == 0 {
                carriers.push(ridge.at(time_s - 0.5 * block_s).0);
            }
            let [from, to] = [0.0, 1.0].map(|k| (first_s + (b as f64 + k) * block_s) * rate_hz);
            let (from, to) = (
                from.ceil() as usize,
                (to.ceil() as usize).min(samples.len()),
            );
            let turn = Complex64::from_polar(1.0, -TAU * carrier / rate_hz);
            let mut phasor = Complex64::from_polar(1.0, phase);
            let mut sum = Complex64::ZERO;
            for x in &samples[from.min(to)..to] {
                sum += phasor * x;
                phasor *= turn;
            }
            phase = (phase - TAU * carrier * (to - from.min(to)) as f64 / rate_hz) % TAU;
            sums.push(sum);
        }
        let low_pass = |length_s: f64| -> Vec<Complex64> {
            let half = (0.5 * length_s / block_s).round();
            let weight = |k: f64| 1.0 + (PI * k / (half + 1.0)).cos();
            let weights: Vec<f64> = (-half as i64..=half as i64)
                .map(|k| weight(k as f64))
                .collect();
            let scale = 2.0 / (weights.iter().sum::<f64>() * block_s * rate_hz);
            let value = |i: usize| {
                let from = 5 * i as isize - half as isize;
                let terms = weights.iter().enumerate().filter_map(|(k, w)| {
                    let at = usize::try_from(from + k as isize).ok()?;
                    Some(*sums.get(at)? * *w)
                });
                terms.sum::<Complex64>() * scale
            };
            (0..carriers.len()).map(value).collect()
        };
        let noise = median(ridge.points.iter().map(|p| p.noise));
        let [start, end] =
            [ridge.start(), ridge.end()].map(|time_s| ((time_s - first_s) / STEP_S) as usize);
        Self {
            first_s,
            ridge: (start, end),
            values: low_pass(window_s),
            wide: low_pass(shortest),
            carriers,
            // The one-sided density acts on both quadratures: a sine of amplitude A has the power A^2 / 2.
            noise: noise * 1.5 / window_s,
        }
    }

    /// The partials between pauses.
    pub fn partials(&self, window_noise: f64) -> Vec<Partial> {
        let power: Vec<f64> = self.values.iter().map(|v| 0.5 * v.norm_sqr()).collect();
        self.sounding(&power)
            .into_iter()
            .filter_map(|ends| self.partial(&power, ends, window_noise))
            .collect()
    }

    /// The partial between two ends.
    fn partial(
        &self,
        power: &[f64],
        (first, end): (usize, usize),
        window_noise: f64,
    ) -> Option<Partial> {
        let own = |i: usize| (power[i] - self.noise).max(0.0);
        let count = (end - first) as f64;
        let power_mean = (first..end).map(|i| power[i] - self.noise).sum::<f64>() / count;
        let track: Vec<(f64, f64)> = (first..end)
            .map(|i| {
                (
                    self.carriers[i]
                        + self.offset(i.saturating_sub(3).max(first), (i + 4).min(end)),
                    own(i),
                )
            })
            .collect();
        let weight: f64 = track.iter().map(|p| p.1).sum();
        (weight > 0.0).then(|| Partial {
            start_s: self.first_s + STEP_S * first as f64,
            end_s: self.first_s + STEP_S * end as f64,
            frequency_hz: track.iter().map(|p| p.0 * p.1).sum::<f64>() / weight,
            power: power_mean.max(0.0),
            noise: window_noise,
            unevenness: unevenness(&track),
            incoherence: self.incoherence(first, end, power_mean.max(0.0)),
            innovation: innovation(&self.wide[first..end]),
            track,
        })
    }

    /// How much less coherent the phase is over the longest low-pass than that of a tone of `power` in this noise: logarithm of
    /// the ratio of the incoherences. The coherence is the weighted mean of the phasors of second differences of the phase, of
    /// values that share no samples: 1 for a steady tone; in noise they are random.
    fn incoherence(&self, first: usize, end: usize, power: f64) -> f64 {
        let lag = (LOW_PASS_S[0] / STEP_S) as usize;
        let triples = (first + lag..end.saturating_sub(lag)).map(|i| {
            let [a, b, c] = [i - lag, i, i + lag].map(|i| self.values[i]);
            c * (b * b).conj() * a
        });
        let (sum, weight) = triples.fold((Complex64::ZERO, 0.0), |(sum, weight), z| {
            (sum + z, weight + z.norm())
        });
        let coherence = if weight > 0.0 {
            sum.norm() / weight
        } else {
            0.0
        };
        let expected = (power / (power + self.noise)).powi(2);
        ((1.0 + RESIDUAL - coherence) / (1.0 + RESIDUAL - expected)).ln()
    }

    /// Ends of the tone. The threshold of power is a tenth of the loudest 0.1 s, or the power at which tone and noise are
    /// equally likely if that is greater. A strong tone sounds above it, and ends where it is below for
    /// [`PAUSE_S`]. A tone in noise sounds in the steps that maximise the excess of power, which is the logarithm
    /// of the likelihood ratio up to a factor.
    fn sounding(&self, power: &[f64]) -> Vec<(usize, usize)> {
        let smooth = averages(power, HALF_SMOOTH);
        let ratio = |length_s: f64| (loudest(power, length_s) / self.noise - 1.0).max(0.5);
        let ratio = match ratio(LOUDEST_S) {
            strong if strong > STRONG => strong,
            _ => ratio(STEADY_S),
        };
        let equal = ratio.ln_1p() * (1.0 + ratio) / ratio;
        let relative = equal.max(END_SHARE * ratio + 1.0);
        let shares = smooth.iter().map(|p| p / (self.noise * relative));
        if ratio <= STRONG {
            let gains = shares.map(|share| (share - 1.0).min(LARGEST_GAIN));
            return largest_sum(gains).into_iter().collect();
        }
        let mut out: Vec<(usize, usize)> = Vec::new();
        for (i, _) in shares.enumerate().filter(|(_, share)| *share > 1.0) {
            match out.last_mut() {
                Some((_, end)) if i - *end < (PAUSE_S / STEP_S) as usize => *end = i + 1,
                _ => out.push((i, i + 1)),
            }
        }
        // What lies mostly beside the ridge is another sound.
        let (start, end) = self.ridge;
        out.retain(|&(first, last)| {
            2 * last.min(end).saturating_sub(first.max(start)) > last - first
        });
        out
    }

    /// Frequency relative to the carrier, mean over steps from `first` to before `end` weighted by power, Hz.
    fn offset(&self, first: usize, end: usize) -> f64 {
        let pairs = self.values[first..end].windows(2);
        let sum: Complex64 = pairs.map(|pair| pair[1] * pair[0].conj()).sum();
        sum.arg() / (TAU * STEP_S)
    }
}

/// Logarithm of the share of the power that a value does not have in common with the one before that shares no samples: small for a tone,
/// however it is modulated; 1 where a new burst or noise takes the place of the old within this time.
fn innovation(values: &[Complex64]) -> f64 {
    let lag = (LOW_PASS_S[1] / STEP_S).ceil() as usize;
    let pairs = values.iter().zip(values.iter().skip(lag));
    let (product, before, after) = pairs.fold(
        (Complex64::ZERO, 0.0, 0.0),
        |(product, before, after), (a, b)| {
            (
                product + b * a.conj(),
                before + a.norm_sqr(),
                after + b.norm_sqr(),
            )
        },
    );
    let common = product.norm_sqr() / (before * after).max(f64::MIN_POSITIVE);
    (1.0 - common + LEAST_INNOVATION).ln()
}

/// Standard deviation of the power of a track over its mean.
fn unevenness(track: &[(f64, f64)]) -> f64 {
    let power: Vec<f64> = track.iter().map(|p| p.1).collect();
    let power = averages(&power, HALF_SMOOTH);
    deviation(&power) / mean(&power).max(f64::MIN_POSITIVE)
}

/// Largest mean power over a time.
fn loudest(power: &[f64], length_s: f64) -> f64 {
    let length = ((length_s / STEP_S) as usize).min(power.len());
    power.windows(length).map(mean).fold(0.0, f64::max)
}

/// The median of values; 0 without any.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let middle = values.len() / 2 + 1;
    order_statistic(values, middle)
}

/// Averages over `half` values on each side.
fn averages(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    let average = |i: usize| {
        let (first, end) = (i.saturating_sub(half), (i + half + 1).min(values.len()));
        (sums[end] - sums[first]) / (end - first) as f64
    };
    (0..values.len()).map(average).collect()
}

/// The range with the largest sum, if it is positive (Kadane's algorithm).
fn largest_sum(values: impl Iterator<Item = f64>) -> Option<(usize, usize)> {
    let (mut sum, mut first, mut best) = (0.0, 0, (0.0, None));
    for (i, value) in values.enumerate() {
        if sum <= 0.0 {
            (sum, first) = (0.0, i);
        }
        sum += value;
        if sum > best.0 {
            best = (sum, Some((first, i + 1)));
        }
    }
    best.1
}
