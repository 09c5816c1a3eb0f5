//! The 0-1 test for chaos: does the signal, played as steering, drive a point in circles or
//! adrift?
//!
//! At a frequency `c` the samples `x_j`, their mean taken off, push a point about a plane:
//!
//! ```text
//! p_c(n) = sum_{j=1}^n x_j cos(j c),   q_c(n) = sum_{j=1}^n x_j sin(j c)
//! D_c(n) = mean over j = 1 .. N - N/10 of [p_c(j+n) - p_c(j)]^2 + [q_c(j+n) - q_c(j)]^2
//! K_c    = correlation of n and D_c(n) over n = 1 .. N/10
//! ```
//!
//! Steered by a regular motion the point stays near where it was: `D_c` is bounded and `K_c` near
//! 0. Steered by chaos it wanders like a drunkard: `D_c` grows with `n` and `K_c` nears 1. At the
//! few `c` in step with a tone of the signal the point runs straight away, which is why the
//! median of `K_c` over many random `c` is the answer (Gottwald and Melbourne, SIAM J. Appl. Dyn.
//! Syst. 8, 129, 2009: the correlation method with the regularised displacement). They keep the
//! mean in the samples and take `V_osc = mean^2 (1 - cos n c) / (1 - cos c)`, its part in the
//! displacement, off `D_c`; taking the mean off first is the same for long signals, and for short
//! ones an offset of the signal then changes nothing.
//!
//! What it does not do:
//!
//! * It does not tell noise from chaos: white noise gives 1. It is for signals known, or shown
//!   otherwise, to obey a law. Noise on a tone adds up the more the longer one looks: with a
//!   deviation of 3 % of the tone's the answer is 0.03 after 1000 samples, 0.2 after 5000 and 0.5
//!   after 20,000, with 10 % it is 0.4, 0.9 and 0.99.
//! * A finely sampled flow looks regular, chaotic or not, because what one sample does to the
//!   point the next ones undo. Take every so many samples only: see [`ZeroOneTest::stride_for`].
//! * Weak chaos, and a torus seen for less than many turns, give anything between 0 and 1. For
//!   signals without noise more samples move the answer to one end.

use std::f64::consts::PI;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use serde::{Deserialize, Serialize};

use super::{ROUNDING, largest};
use crate::analysis::{AnalysisError, range};

/// One part in so many of the samples is how long the displacement is followed.
const HORIZON_PART: usize = 10;

/// Samples are too fine while the signal's extent is more than this many mean steps.
const COARSE: f64 = 10.0;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroOneTest {
    /// Every so many samples one is taken, at least 1: samples that follow too closely hide chaos.
    pub stride: usize,
    /// How many frequencies are tried, at least 1; 100 is usual.
    pub frequencies: usize,
    /// Seed of the random frequencies.
    pub seed: u64,
}

impl ZeroOneTest {
    /// The fewest samples, taken a stride apart, that the test is applied to. The answer is sure
    /// from about 1000 on.
    pub const FEWEST_SAMPLES: usize = 100;

    /// The test with 100 frequencies.
    pub fn with_stride(stride: usize) -> Self {
        Self {
            stride,
            frequencies: 100,
            seed: 1,
        }
    }

    /// The smallest stride at which the samples taken are no longer too fine: their mean
    /// difference from one to the next is at least a tenth of the signal's extent. At most the
    /// stride that leaves [`ZeroOneTest::FEWEST_SAMPLES`]; at least 1.
    ///
    /// This is the criterion of Toker, Sommer and D'Esposito (Commun. Biol. 3, 11, 2020), who
    /// double the stride until it is met; about 20 samples a turn remain of a sine. A longer
    /// stride does no harm while the samples last: the lag of the first minimum of the mutual
    /// information is another good choice. 1 is right for a map.
    pub fn stride_for(samples: &[f64]) -> usize {
        let [low, high] = range(samples.iter().copied());
        let coarse = |stride: &usize| {
            let mut taken = samples.iter().step_by(*stride);
            let mut before = taken.next().copied().unwrap_or_default();
            let steps = taken.len() as f64;
            let way: f64 = taken
                .map(|x| (x - std::mem::replace(&mut before, *x)).abs())
                .sum();
            COARSE * way >= (high - low) * steps
        };
        let longest = (samples.len() / Self::FEWEST_SAMPLES).max(1);
        (1..longest).find(coarse).unwrap_or(longest)
    }
}

/// Its result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ZeroOne {
    /// Median over the frequencies, -1 to 1: near 0 regular, near 1 chaotic. Exactly 0 if the
    /// samples are all the same.
    pub k: f64,
    /// Frequency `c` (rad a sample taken, between pi/5 and 4 pi/5) and `K_c` of each, in the
    /// order drawn.
    pub by_frequency: Vec<[f64; 2]>,
    /// Path `(p, q)` of the translation variables at the frequency of the median (of an even
    /// number the lower of the middle two), in the signal's unit. A picture, as long as the signal: not written.
    #[serde(skip)]
    pub path: Vec<[f64; 2]>,
    /// Every so many samples one was taken.
    #[serde(rename = "stride_samples")]
    pub stride: usize,
    /// How many samples were taken.
    pub samples: usize,
}

/// Applies the test to every `stride`-th of the samples, first included.
///
/// The displacements come from a Fourier transform, so that the work is `N log N` a frequency.
/// The result does not depend on the number of threads.
///
/// # Errors
/// [`AnalysisError::Zero`] for a stride or a number of frequencies of 0,
/// [`AnalysisError::TooShort`] if fewer than [`ZeroOneTest::FEWEST_SAMPLES`] are taken.
pub fn zero_one(samples: &[f64], test: &ZeroOneTest) -> Result<ZeroOne, AnalysisError> {
    let zero = |what| Err(AnalysisError::Zero { what });
    if test.stride == 0 {
        return zero("0-1 test: the stride");
    }
    if test.frequencies == 0 {
        return zero("0-1 test: the number of frequencies");
    }
    let taken = centred(samples, test.stride);
    if taken.len() < ZeroOneTest::FEWEST_SAMPLES {
        return Err(AnalysisError::TooShort {
            what: "0-1 test",
            have: samples.len(),
            need: test
                .stride
                .saturating_mul(ZeroOneTest::FEWEST_SAMPLES - 1)
                .saturating_add(1),
        });
    }
    let mut rng = ChaCha8Rng::seed_from_u64(test.seed);
    let frequencies: Vec<f64> = (0..test.frequencies)
        .map(|_| rng.random_range(PI / 5.0..4.0 * PI / 5.0))
        .collect();
    let walker = Walker::new(taken.len());
    let by_frequency: Vec<[f64; 2]> = frequencies
        .into_par_iter()
        .map_init(Scratch::default, |scratch, c| {
            let displacement = walker.displacement(&taken, c, scratch);
            [c, correlation_with_time(displacement)]
        })
        .collect();
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

/// Every `stride`-th sample less their mean; zeros if they differ by rounding only.
fn centred(samples: &[f64], stride: usize) -> Vec<f64> {
    let mut taken: Vec<f64> = samples.iter().copied().step_by(stride).collect();
    let mean = taken.iter().sum::<f64>() / taken.len().max(1) as f64;
    for x in &mut taken {
        *x -= mean;
    }
    if largest(&taken) <= ROUNDING * largest(samples) {
        taken.fill(0.0);
    }
    taken
}

/// The translation variables `p_c + i q_c` after 1, 2, ... samples.
fn translate(samples: &[f64], c: f64) -> impl Iterator<Item = Complex<f64>> {
    // The turn is multiplied up: after N steps it is wrong by about N roundings.
    let step = Complex::from_polar(1.0, c);
    let mut turn = Complex::new(1.0, 0.0);
    let mut place = Complex::new(0.0, 0.0);
    samples.iter().map(move |x| {
        turn *= step;
        place += turn * x;
        place
    })
}

/// Correlation of a curve with 1, 2, 3, ..., -1 to 1; 0 if the curve is constant.
fn correlation_with_time(curve: &[f64]) -> f64 {
    let n = curve.len() as f64;
    let mean = curve.iter().sum::<f64>() / n;
    // Displacements are squares: squared once more they would soon underflow or overflow.
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

/// Measures displacements of paths of one length.
struct Walker {
    /// How far displacements are followed, samples.
    horizon: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

/// Buffers of a [`Walker`], one set a thread.
#[derive(Default)]
struct Scratch {
    path: Vec<Complex<f64>>,
    head: Vec<Complex<f64>>,
    work: Vec<Complex<f64>>,
    /// Sums of the squares of the path, from 0 to before each place.
    squares: Vec<f64>,
    displacement: Vec<f64>,
}

impl Walker {
    fn new(samples: usize) -> Self {
        let mut planner = FftPlanner::new();
        let size = samples.next_power_of_two();
        Self {
            horizon: samples / HORIZON_PART,
            forward: planner.plan_fft_forward(size),
            inverse: planner.plan_fft_inverse(size),
        }
    }

    /// `D_c(1), D_c(2), ...` up to the horizon.
    ///
    /// `|z_(j+n) - z_j|^2 = |z_(j+n)|^2 + |z_j|^2 - 2 Re(conj z_j z_(j+n))`: the sums of squares
    /// are differences of running sums, the products a correlation of the path with its head.
    fn displacement<'s>(&self, samples: &[f64], c: f64, scratch: &'s mut Scratch) -> &'s [f64] {
        let Scratch {
            path,
            head,
            work,
            squares,
            displacement,
        } = scratch;
        path.clear();
        path.extend(translate(samples, c));
        // Near its centre the path's squares are smallest, and so is what cancels.
        let centre = path.iter().sum::<Complex<f64>>() / path.len() as f64;
        path.iter_mut().for_each(|z| *z -= centre);
        squares.clear();
        squares.push(0.0);
        let mut sum = 0.0;
        squares.extend(path.iter().map(|z| {
            sum += z.norm_sqr();
            sum
        }));

        let starts = samples.len() - self.horizon;
        let size = self.forward.len();
        head.clear();
        head.extend_from_slice(&path[..starts]);
        head.resize(size, Complex::default());
        path.resize(size, Complex::default());
        work.resize(self.forward.get_inplace_scratch_len(), Complex::default());
        self.forward.process_with_scratch(path, work);
        self.forward.process_with_scratch(head, work);
        for (z, h) in path.iter_mut().zip(head.iter()) {
            *z *= h.conj();
        }
        work.resize(self.inverse.get_inplace_scratch_len(), Complex::default());
        self.inverse.process_with_scratch(path, work);

        displacement.clear();
        displacement.extend((1..=self.horizon).map(|n| {
            let ends = squares[starts + n] - squares[n];
            let products = path[n].re / size as f64;
            (ends + squares[starts] - 2.0 * products) / starts as f64
        }));
        displacement
    }
}

#[cfg(test)]
mod tests;
