//! A partial brought to zero frequency along its ridge: ends, frequency and level in fine steps of time.

use std::f64::consts::TAU;
use std::ops::Range;

use rustfft::num_complex::Complex64;

use super::partial::{Partial, STEP_S};
use super::ridge::Ridge;
use crate::simd::vectorised;
use crate::stats::{deviation, mean, median, trend};
use crate::tones::Window;

/// A partial ends where its power stays below a tenth of the mean in its loudest 0.1 s for 0.12 s.
pub(super) const END_SHARE: f64 = 0.1;
pub(super) const LOUDEST_S: f64 = 0.1;
const PAUSE_S: f64 = 0.12;

/// Values per step that show the peaks of bursts.
const FINE: usize = 5;

/// Longest and shortest low-pass, s: for a tone in noise, and for fast changes. Power and frequency are averaged over the
/// longest.
pub(super) const LOW_PASS_S: [f64; 2] = [LOUDEST_S / 2.0, LOUDEST_S / 8.0];

/// Least unevenness, incoherence, innovation and departure from a straight fall: no real sound is perfect.
const RESIDUAL: f64 = 0.01;

/// A partial at zero frequency.
pub(super) struct Baseband {
    /// Time of the first value, s.
    first_s: f64,
    /// Steps of the ridge.
    ridge: [usize; 2],
    /// Values of the analytic signal in steps of [`STEP_S`], low-passed; a sine of amplitude `A` gives `A`.
    values: Vec<Complex64>,
    /// The same through the shortest low-pass.
    wide: Vec<Complex64>,
    /// The same through a low-pass of 2.5 periods of the partial, 3 to 12.5 ms, with [`FINE`] values in each step.
    fine: Vec<Complex64>,
    /// Frequency that was brought to zero, at each value, Hz.
    carriers: Vec<f64>,
    /// Noise power per hertz.
    noise: f64,
}

impl Baseband {
    /// Brings the partial of a ridge to zero frequency, and up to 0.4 s before and after it, where its ends may be.
    pub fn new(samples: &[f64], rate_hz: f64, ridge: &Ridge) -> Self {
        let margin_s = 4.0 * LOUDEST_S;
        let [start_s, end_s] = ridge.span();
        let first = ((start_s - margin_s).max(0.0) * rate_hz) as usize;
        let first_s = first as f64 / rate_hz;
        let end_s = (end_s + margin_s).min(samples.len() as f64 / rate_hz);
        let carriers: Vec<f64> = (0..((end_s - first_s) / STEP_S) as usize)
            .map(|i| ridge.frequency_at(first_s + STEP_S * i as f64))
            .collect();
        let step = STEP_S * rate_hz;
        let mut phasor = Complex64::ONE;
        let samples = &samples[first..];
        let mut mixed = Vec::new();
        for (i, f) in carriers.iter().enumerate() {
            let turn = Complex64::from_polar(1.0, -TAU * f / rate_hz);
            let end = ((i as f64 + 0.5) * step).ceil() as usize;
            let near = &samples[mixed.len()..end.min(samples.len())];
            mixed.extend(near.iter().map(|x| {
                phasor *= turn;
                phasor * x
            }));
        }
        let low_pass = |length_s: f64, parts: usize| -> Vec<Complex64> {
            let step = step / parts as f64;
            let weights = Window::Hann.samples((length_s * rate_hz) as usize);
            let scale = 2.0 / weights.iter().sum::<f64>();
            let value = |i: usize| {
                let from = (i as f64 * step) as isize - (weights.len() / 2) as isize;
                let weights = &weights[(-from).max(0) as usize..];
                weighted_sum(&mixed[mixed.len().min(from.max(0) as usize)..], weights) * scale
            };
            (0..parts * carriers.len()).map(value).collect()
        };
        // A low-pass of 2.5 periods keeps the other harmonics of a tone out.
        let fine_s = 2.5 / median(carriers.iter().copied());
        Self {
            first_s,
            ridge: [start_s, ridge.span()[1]].map(|t| ((t - first_s) / STEP_S) as usize),
            values: low_pass(LOW_PASS_S[0], 1),
            wide: low_pass(LOW_PASS_S[1], 1),
            fine: low_pass(fine_s.clamp(LOUDEST_S / 32.0, LOW_PASS_S[1]), FINE),
            carriers,
            noise: median(ridge.points.iter().map(|p| p[2])),
        }
    }

    /// Noise power in the low-pass. The one-sided density acts on both quadratures: a sine of amplitude A has the power
    /// A^2 / 2.
    fn noise_power(&self) -> f64 {
        self.noise * 1.5 / LOW_PASS_S[0]
    }

    /// The partials between pauses.
    pub fn partials(&self) -> Vec<Partial> {
        let power: Vec<f64> = self.values.iter().map(|v| 0.5 * v.norm_sqr()).collect();
        let sounding = self.sounding(&power).into_iter();
        sounding
            .filter_map(|ends| self.partial(&power, ends))
            .collect()
    }

    /// The partial between two ends.
    fn partial(&self, power: &[f64], [first, end]: [usize; 2]) -> Option<Partial> {
        let excess = |i: usize| power[i] - self.noise_power();
        let point = |i: usize| {
            let near = around(i, [first, end]);
            (self.carriers[i] + self.offset(near), excess(i).max(0.0))
        };
        let track: Vec<(f64, f64)> = (first..end).map(point).collect();
        let weight: f64 = track.iter().map(|p| p.1).sum();
        let mean_excess = (first..end).map(excess).sum::<f64>() / (end - first) as f64;
        let power = mean_excess.max(0.0);
        let smooth = averages(&track.iter().map(|p| p.1).collect::<Vec<f64>>());
        (weight > 0.0).then(|| Partial {
            start_s: self.first_s + STEP_S * first as f64,
            end_s: self.first_s + STEP_S * end as f64,
            frequency_hz: track.iter().map(|p| p.0 * p.1).sum::<f64>() / weight,
            power,
            noise: self.noise,
            unevenness: (deviation(&smooth) / mean(&smooth) + RESIDUAL).ln(),
            decay: decay(&smooth),
            incoherence: self.incoherence(first, end, power),
            innovation: innovation(&self.wide[first..end]),
            kurtosis: self.kurtosis(first, end),
            amplitudes: self.wide[first..end].iter().map(|v| v.norm()).collect(),
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
        let weight: f64 = triples.clone().map(Complex64::norm).sum();
        let sum: Complex64 = triples.sum();
        let coherence = sum.norm() / weight.max(f64::MIN_POSITIVE);
        let expected = (power / (power + self.noise_power())).powi(2);
        ((1.0 + RESIDUAL - coherence) / (1.0 + RESIDUAL - expected)).ln()
    }

    /// Logarithm of the kurtosis of the amplitude: of the mean square of the power over the square of its mean.
    fn kurtosis(&self, first: usize, end: usize) -> f64 {
        let values = self.fine[FINE * first..FINE * end].iter();
        let powers: Vec<f64> = values.map(Complex64::norm_sqr).collect();
        (1.0 + (deviation(&powers) / mean(&powers)).powi(2)).ln()
    }

    /// Ends of the tone: it sounds where its power is above a tenth of that of its loudest 0.1 s, and above the power at which
    /// tone and noise are equally likely, until it is below for [`PAUSE_S`].
    fn sounding(&self, power: &[f64]) -> Vec<[usize; 2]> {
        let loudest = power.windows(((LOUDEST_S / STEP_S) as usize).min(power.len()));
        let loudest = loudest.map(mean).fold(0.0, f64::max);
        let ratio = (loudest / self.noise_power() - 1.0).max(0.5);
        let equal = ratio.ln_1p() * (1.0 + ratio) / ratio;
        let least = self.noise_power() * equal.max(END_SHARE * ratio + 1.0);
        let smooth = averages(power);
        let mut out: Vec<[usize; 2]> = Vec::new();
        for (i, _) in smooth.iter().enumerate().filter(|(_, p)| **p > least) {
            match out.last_mut() {
                Some([_, end]) if i - *end < (PAUSE_S / STEP_S) as usize => *end = i + 1,
                _ => out.push([i, i + 1]),
            }
        }
        // What lies mostly beside the ridge is another sound.
        let [start, end] = self.ridge;
        out.retain(|&[first, last]| {
            2 * last.min(end).saturating_sub(first.max(start)) > last - first
        });
        out
    }

    /// Frequency relative to the carrier, mean over steps weighted by power, Hz.
    fn offset(&self, steps: Range<usize>) -> f64 {
        let pairs = self.values[steps].windows(2);
        let sum: Complex64 = pairs.map(|pair| pair[1] * pair[0].conj()).sum();
        sum.arg() / (TAU * STEP_S)
    }
}

/// The sum of values with their weights.
fn weighted_sum(values: &[Complex64], weights: &[f64]) -> Complex64 {
    let len = values.len().min(weights.len());
    let (values, last) = values[..len].as_chunks::<8>();
    let (weights, of_last) = weights[..len].as_chunks::<8>();
    // Partial sums do not wait for each other.
    let mut sums = [Complex64::ZERO; 8];
    for ((sum, x), w) in sums.iter_mut().zip(last).zip(of_last) {
        *sum = x * w;
    }
    vectorised(
        #[inline(always)]
        || {
            for (values, weights) in values.iter().zip(weights) {
                for k in 0..8 {
                    sums[k] += values[k] * weights[k];
                }
            }
        },
    );
    sums.iter().sum()
}

/// Logarithm of the share of the power that a value does not have in common with the one before that shares no samples:
/// small for a tone, however it is modulated; 0 where a new burst or noise takes the place of the old within this time.
fn innovation(values: &[Complex64]) -> f64 {
    let lag = (LOW_PASS_S[1] / STEP_S).ceil() as usize;
    let pairs = values.iter().zip(values.iter().skip(lag));
    let product: Complex64 = pairs.clone().map(|(a, b)| b * a.conj()).sum();
    let before: f64 = pairs.clone().map(|(a, _)| a.norm_sqr()).sum();
    let after: f64 = pairs.map(|(_, b)| b.norm_sqr()).sum();
    let common = product.norm_sqr() / (before * after).max(f64::MIN_POSITIVE);
    (1.0 - common + RESIDUAL).ln()
}

/// Logarithm of the share of the variance of the level that a straight fall in decibels does not explain: 0 without a fall.
fn decay(power: &[f64]) -> f64 {
    let mean = mean(power);
    // A pause within the tone counts no more than what ends it.
    let level: Vec<f64> = power.iter().map(|p| (p / mean + END_SHARE).ln()).collect();
    let [slope, rest] = trend(&level);
    let all = level.len() as f64 * deviation(&level).powi(2);
    let share = if slope < 0.0 { rest / all } else { 1.0 };
    (share.min(1.0) + RESIDUAL).ln()
}

/// The steps within the longest low-pass around one, of those between two.
fn around(i: usize, [first, end]: [usize; 2]) -> Range<usize> {
    let half = ((LOW_PASS_S[0] / STEP_S) as usize - 1) / 2;
    i.saturating_sub(half).max(first)..(i + half + 1).min(end)
}

/// Moving average.
fn averages(values: &[f64]) -> Vec<f64> {
    let all = [0, values.len()];
    (0..values.len())
        .map(|i| mean(&values[around(i, all)]))
        .collect()
}
