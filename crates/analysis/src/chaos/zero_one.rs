//! The 0-1 test for chaos: the signal drives a point in the plane, whose path is bounded for regular and
//! diffusive for chaotic motion.
//!
//! At a frequency `c` the samples `x_j`, with their mean subtracted, drive the translation variables:
//!
//! ```text
//! p_c(n) = sum_{j=1}^n x_j cos(j c),   q_c(n) = sum_{j=1}^n x_j sin(j c)
//! D_c(n) = mean over j = 1 .. N - N/10 of [p_c(j+n) - p_c(j)]^2 + [q_c(j+n) - q_c(j)]^2
//! K_c    = correlation of n and D_c(n) over n = 1 .. N/10
//! ```
//!
//! For regular motion the path is bounded, `D_c` is bounded and `K_c` is near 0. For chaotic motion the
//! path is like a random walk, `D_c` grows with `n` and `K_c` is near 1. At the few `c` in resonance
//! with a tone of the signal the path is a straight line; the result is therefore the median of `K_c`
//! over many random `c` (Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8, 129, 2009: the correlation
//! method with the regularised displacement). They keep the mean in the samples and subtract its part of
//! the displacement, `V_osc = mean^2 (1 - cos n c) / (1 - cos c)`, from `D_c`. Subtracting the mean
//! first is equivalent for long signals, and makes the result for short ones independent of an offset of
//! the signal.
//!
//! Limits:
//!
//! * The test does not distinguish noise from chaos: white noise gives 1. Use it for signals that are
//!   known to be deterministic. Noise added to a tone accumulates with the length of the signal: with a
//!   standard deviation of 3 % of the tone's the result is 0.03 after 1000 samples, 0.2 after 5000 and
//!   0.5 after 20,000; with 10 % it is 0.4, 0.9 and 0.99.
//! * An oversampled flow looks regular even if it is chaotic, because successive samples cancel in the
//!   path. Subsample it: see [`ZeroOneTest::recommended_stride`].
//! * Weak chaos, and a torus observed over few periods, give any value between 0 and 1. Without noise,
//!   more samples move the result towards 0 or 1.

use std::cell::RefCell;
use std::f64::consts::PI;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;
use schemars::JsonSchema;
use serde::Serialize;

use super::{ROUNDING, largest};
use crate::{
    AnalysisError,
    stats::{mean, range},
};

/// The displacement is computed up to this fraction (1 over the value) of the samples.
const HORIZON_DIVISOR: usize = 10;

/// A signal is oversampled while its range exceeds this many mean steps.
const OVERSAMPLED: f64 = 10.0;

thread_local! {
    /// Plans of the transforms, which successive windows share.
    static PLANNER: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
}

/// Parameters of [`zero_one`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroOneTest {
    /// Stride: every `stride`-th sample is used, at least 1. Oversampling hides chaos.
    pub stride: usize,
    /// Number of frequencies, at least 1; usually 100.
    pub frequencies: usize,
    /// Seed of the random frequencies.
    pub seed: u64,
}

impl ZeroOneTest {
    /// Minimum number of samples after subsampling. The result is reliable from about 1000.
    pub const MIN_SAMPLES: usize = 100;

    /// The test with 100 frequencies.
    pub fn with_stride(stride: usize) -> Self {
        Self {
            stride,
            frequencies: 100,
            seed: 1,
        }
    }

    /// Smallest stride at which the signal is no longer oversampled: the mean difference of successive
    /// samples is at least a tenth of the range. At least 1, and at most the stride that leaves
    /// [`ZeroOneTest::MIN_SAMPLES`].
    ///
    /// The criterion is that of Toker, Sommer and D'Esposito (Commun. Biol. 3, 11, 2020), who double the
    /// stride until it is met. It leaves about 20 samples per period of a sine. A longer stride does no
    /// harm if enough samples remain; the lag of the first minimum of the mutual information is another
    /// good choice. Use 1 for a map.
    pub fn recommended_stride(samples: &[f64]) -> usize {
        let [low, high] = range(samples.iter().copied());
        let not_oversampled = |stride: &usize| {
            let mut taken = samples.iter().step_by(*stride);
            let mut before = taken.next().copied().unwrap_or_default();
            let steps = taken.len() as f64;
            let path: f64 = taken
                .map(|x| (x - std::mem::replace(&mut before, *x)).abs())
                .sum();
            OVERSAMPLED * path >= (high - low) * steps
        };
        let longest = (samples.len() / Self::MIN_SAMPLES).max(1);
        (1..longest).find(not_oversampled).unwrap_or(longest)
    }
}

/// Result of the 0-1 test.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ZeroOne {
    /// Median of `K_c` over the frequencies, -1 to 1: near 0 regular, near 1 chaotic. Exactly 0 if all
    /// samples are equal.
    pub k: f64,
    /// By frequency: `c` (rad per used sample, between pi/5 and 4 pi/5) and `K_c`, in random order.
    pub by_frequency: Vec<[f64; 2]>,
    /// Path `(p, q)` of the translation variables at the frequency of the median (the lower of the
    /// middle two for an even number), in the signal's unit. It is as long as the signal and is not
    /// serialised.
    #[serde(skip)]
    pub path: Vec<[f64; 2]>,
    /// Stride: every `stride`-th sample was used.
    #[serde(rename = "stride_samples")]
    pub stride: usize,
    /// Number of samples used.
    pub samples: usize,
}

/// Applies the 0-1 test to every `stride`-th sample, starting with the first.
///
/// The time is `O(N log N)` for a correlation of the samples that all frequencies share, and `O(N)` for each
/// frequency.
///
/// # Errors
/// [`AnalysisError::TooShort`] if fewer than [`ZeroOneTest::MIN_SAMPLES`] remain after subsampling.
///
/// # Panics
/// If the stride or the number of frequencies is 0.
pub fn zero_one(samples: &[f64], test: &ZeroOneTest) -> Result<ZeroOne, AnalysisError> {
    let steps = test.stride.saturating_mul(ZeroOneTest::MIN_SAMPLES - 1);
    AnalysisError::check_length("0-1 test", samples.len(), steps.saturating_add(1))?;
    let taken = centred(samples, test.stride);
    let mut rng = ChaCha8Rng::seed_from_u64(test.seed);
    let frequencies: Vec<f64> = (0..test.frequencies)
        .map(|_| rng.random_range(PI / 5.0..4.0 * PI / 5.0))
        .collect();
    let solver = DisplacementSolver::new(&taken);
    let correlation = |c: f64| [c, correlation_with_time(&solver.displacement(c))];
    let by_frequency: Vec<[f64; 2]> = frequencies.into_iter().map(correlation).collect();
    let mut order: Vec<[f64; 2]> = by_frequency.clone();
    order.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let (low, high) = (order[(order.len() - 1) / 2], order[order.len() / 2]);
    Ok(ZeroOne {
        k: 0.5 * (low[1] + high[1]),
        by_frequency,
        path: translate(&taken, low[0]).map(|z| [z.re, z.im]).collect(),
        stride: test.stride,
        samples: taken.len(),
    })
}

/// Every `stride`-th sample minus the mean; zeros if they differ only by rounding errors.
fn centred(samples: &[f64], stride: usize) -> Vec<f64> {
    let mut taken: Vec<f64> = samples.iter().copied().step_by(stride).collect();
    let mean = mean(&taken);
    for x in &mut taken {
        *x -= mean;
    }
    if largest(&taken) <= ROUNDING * largest(samples) {
        taken.fill(0.0);
    }
    taken
}

/// Translation variables `p_c + i q_c` after 1, 2, ... samples.
fn translate(samples: &[f64], c: f64) -> impl Iterator<Item = Complex<f64>> {
    // The phase is accumulated by multiplication: after N steps its error is about N roundings.
    let step = Complex::from_polar(1.0, c);
    let mut phasor = Complex::new(1.0, 0.0);
    let mut position = Complex::new(0.0, 0.0);
    samples.iter().map(move |x| {
        phasor *= step;
        position += phasor * x;
        position
    })
}

/// Correlation of a curve with 1, 2, 3, ..., -1 to 1; 0 if the curve is constant.
fn correlation_with_time(curve: &[f64]) -> f64 {
    let n = curve.len() as f64;
    let mean = mean(curve);
    // Scale first: displacements are squares, and their squares would underflow or overflow early.
    let largest = curve.iter().fold(0.0, |most, d| (d - mean).abs().max(most));
    if largest == 0.0 {
        return 0.0;
    }
    let (mut both, mut curve_alone) = (0.0, 0.0);
    for (i, d) in curve.iter().enumerate() {
        let time = (i as f64 + 1.0) - 0.5 * (n + 1.0);
        let deviation = (d - mean) / largest;
        both += time * deviation;
        curve_alone += deviation * deviation;
    }
    let time_alone = n * (n * n - 1.0) / 12.0;
    both / (time_alone * curve_alone).sqrt()
}

/// Computes the displacements of one signal.
///
/// With samples `x_0, x_1, ...` and the sums over the `M` starts `j` = 0, ..., M - 1,
///
/// ```text
/// M D_c(n) = sum_(m,m'=1..n) cos((m - m') c) sum_j x_(j+m) x_(j+m')
/// ```
///
/// so that the increment of `M D_c` from `n - 1` to `n` is
///
/// ```text
/// S(n) = A_0(n) + 2 sum_(d=1..n-1) cos(d c) A_d(n),   A_d(n) = sum_j x_(j+n) x_(j+n-d)
/// ```
///
/// Since `A_d(n)` differs from `A_d(n-1)` by one product at either end, `S(n) - S(n-1)` consists of
/// `2 cos((n-1) c) A_(n-1)(n)`, a correlation of the samples that does not depend on `c`, and of products of one
/// sample with a part of the path at either end.
struct DisplacementSolver<'a> {
    samples: &'a [f64],
    /// Largest time of the displacement, samples.
    horizon: usize,
    /// `A_d(d + 1)` for `d` = 0, 1, ... up to the horizon.
    correlations: Vec<f64>,
}

impl<'a> DisplacementSolver<'a> {
    fn new(samples: &'a [f64]) -> Self {
        let horizon = samples.len() / HORIZON_DIVISOR;
        let starts = samples.len() - horizon;
        // Long enough that the correlations up to the horizon do not wrap around.
        let size = samples.len().next_power_of_two();
        let (forward, inverse) = PLANNER.with_borrow_mut(|planner| {
            (
                planner.plan_fft_forward(size),
                planner.plan_fft_inverse(size),
            )
        });
        let transform = |part: &[f64]| {
            let mut padded = part.to_vec();
            padded.resize(size, 0.0);
            let mut spectrum = forward.make_output_vec();
            let done = forward.process(&mut padded, &mut spectrum);
            done.expect("the buffers have the lengths of the plan");
            spectrum
        };
        let (first, mut all) = (transform(&samples[1..=starts]), transform(&samples[1..]));
        for (product, first) in all.iter_mut().zip(first) {
            *product *= first.conj();
        }
        // Zero also where huge samples overflow; the inverse transform checks it.
        [all[0].im, all[size / 2].im] = [0.0; 2];
        let mut correlations = inverse.make_output_vec();
        let done = inverse.process(&mut all, &mut correlations);
        done.expect("the buffers have the lengths of the plan");
        correlations.truncate(horizon);
        correlations.iter_mut().for_each(|sum| *sum /= size as f64);
        Self {
            samples,
            horizon,
            correlations,
        }
    }

    /// `D_c(1), D_c(2), ...` up to the horizon.
    fn displacement(&self, c: f64) -> Vec<f64> {
        let (samples, starts) = (self.samples, self.samples.len() - self.horizon);
        let step = Complex::from_polar(1.0, c);
        // exp(i n c), and the paths of the samples that enter and leave the sums.
        let mut phasor = step;
        let [mut entered, mut left] = [Complex::default(); 2];
        let mut increment = self.correlations[0];
        let mut sum = increment;
        let mut displacement = Vec::with_capacity(self.horizon);
        displacement.push(sum / starts as f64);
        for n in 2..=self.horizon {
            let middle = phasor.re * self.correlations[n - 1];
            phasor *= step;
            let [old, new] = [samples[n - 1], samples[starts + n - 1]];
            let [leaving, entering] = [old, new].map(|x| phasor * x);
            let ends = (entering * entered.conj()).re - (leaving * left.conj()).re;
            increment += new * new - old * old + 2.0 * (middle + ends);
            entered += entering;
            left += leaving;
            sum += increment;
            displacement.push(sum / starts as f64);
        }
        displacement
    }
}

#[cfg(test)]
mod tests;
