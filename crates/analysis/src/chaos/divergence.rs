//! Largest Lyapunov exponent of a signal from the divergence of nearest neighbours.
//!
//! Two states of a chaotic system that are close at different times diverge like `exp(lambda t)`. The
//! logarithm of their distance, averaged over many pairs, is therefore a line with the largest exponent
//! as its slope, until the distance reaches the size of the attractor.
//!
//! ```text
//! Rosenstein:  S(k) = mean over i of ln |y_(i+k) - y_(j+k)|,   y_j the nearest neighbour of y_i
//! Kantz:       S(k) = mean over i of ln (mean over j in U_i of |x_(i+k) - x_(j+k)|)
//! ```
//!
//! `y` are delay vectors, Eq. (25), `x` the newest coordinate of each. Rosenstein, Collins and De Luca
//! (Physica D 65, 117, 1993) follow the Euclidean distance to one neighbour. Kantz (Phys. Lett. A 185,
//! 77, 1994) follows the difference of one sample to all neighbours `U_i` within a radius, in the
//! maximum norm. Neighbours are separated by at least a Theiler window in time and are followed over the
//! full horizon. Distances of zero, or within rounding error, are excluded because they have no
//! meaningful logarithm.
//!
//! Accuracy. For the logistic map at 4 and the Henon map (5000 samples) the exponents are within 1 and
//! 2 %, with Kantz's method (radius 0.005) within 3 %. Flows are harder: the finite number of samples
//! flattens Rosenstein's curve, and Kantz's logarithm of a mean favours the pairs that diverge fast. The
//! table shows the exponent over the true one for three trajectories and the dimensions 3 and 5, with
//! [`DivergenceSearch::for_delay`]:
//!
//! | flow | samples | Rosenstein | Kantz, 0.02 |
//! |---|---|---|---|
//! | Lorenz, step 0.01, lag 16 | 20,000 | 0.90 to 0.95 | mostly no region |
//! | | 50,000 | 0.91 to 0.93 | 1.05 to 1.16 |
//! | Roessler, step 0.1, lag 14 | 20,000 | 0.72 to 0.96 | mostly no region |
//! | | 50,000 | 0.86 to 0.95 | 0.84 to 1.14 |
//!
//! Rosenstein's exponents are within 2.4 standard errors of the true value, except for one trajectory of
//! 20,000 samples (3.5). Kantz's are within five.
//!
//! Periodic and quasi-periodic signals have a flat curve and no scaling region. White noise has none
//! either: after one step its neighbours are as far apart as any two states.

use std::f64::consts::LN_2;
use std::ops::Range;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::scaling::{ScalingRegion, scaling_region};
use super::{ROUNDING, largest};
use crate::simd::vectorised;
use crate::{AnalysisError, DelayVectors, NeighbourTree, Norm, deviation};

/// Number of consecutive sections of the signal with separate curves. The scatter of their slopes gives
/// the standard error. They are also the units of parallel work; the fixed number makes sums independent
/// of the number of threads.
const BLOCKS: usize = 16;

/// Minimum number of neighbours in Kantz's mean: the logarithm of a mean of few values is biased low.
const MIN_NEIGHBOURS: usize = 5;

/// Maximum number of neighbours in Kantz's mean, evenly selected. More cost time and add little
/// precision.
const MAX_NEIGHBOURS: usize = 500;

/// Distance that is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DivergenceMethod {
    /// Distance to the nearest neighbour of each state (Rosenstein, Collins and De Luca 1993).
    Rosenstein,
    /// Distance to all neighbours within a radius (Kantz 1994). States with fewer than 5 neighbours are
    /// skipped; of more than 500, about 500 are selected evenly.
    Kantz {
        /// Radius over the standard deviation of the samples, above 0. Usually 0.01 to 0.1, smaller for
        /// more samples.
        radius: f64,
    },
}

/// Parameters of [`divergence`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DivergenceSearch {
    /// Lag, samples, at least 1.
    pub lag: usize,
    /// Embedding dimension, at least 1.
    pub dimension: usize,
    /// Theiler window, samples: pairs closer in time are not neighbours. Use a mean period for a flow
    /// and 1 for a map. It is also the minimum length of the scaling region.
    pub theiler: usize,
    /// Time over which neighbours are followed, samples. It should reach the flat part of the curve.
    pub horizon: usize,
    /// Distance that is followed.
    pub method: DivergenceMethod,
    /// Maximum number of states followed, evenly spread, at least 1. 2000 is ample.
    pub max_references: usize,
}

impl DivergenceSearch {
    /// Rosenstein's method on 2000 states, for a delay chosen before, such as a
    /// [`DelayChoice`](crate::DelayChoice), and a signal of `samples` samples.
    ///
    /// The horizon is 20 Theiler windows (or 20 lags, if those are longer), that is 20 periods of a flow
    /// or 20 steps of a map, but at most a quarter of the signal.
    pub fn for_delay(lag: usize, dimension: usize, theiler: usize, samples: usize) -> Self {
        Self {
            lag,
            dimension,
            theiler,
            horizon: theiler.max(lag).saturating_mul(20).min(samples / 4),
            method: DivergenceMethod::Rosenstein,
            max_references: 2000,
        }
    }

    /// Least time between neighbours, samples.
    fn min_separation(&self) -> usize {
        self.theiler.max(1)
    }

    /// Whether vectors can be followed.
    fn check(&self, vectors: &DelayVectors<'_>) -> Result<(), AnalysisError> {
        if self.max_references == 0 {
            return Err(AnalysisError::ZeroCount {
                what: "divergence: the number of states followed",
            });
        }
        let min_vectors = self
            .min_separation()
            .saturating_mul(2)
            .saturating_add(self.horizon)
            .saturating_add(1);
        if vectors.len() < min_vectors {
            return Err(AnalysisError::TooShort {
                what: "divergence",
                have: vectors.samples().len(),
                need: DelayVectors::samples_for(min_vectors, self.lag, self.dimension),
            });
        }
        Ok(())
    }
}

/// Divergence curve of nearest neighbours.
///
/// [`divergence`] counts time in samples. [`in_seconds`](Divergence::in_seconds) converts it to seconds,
/// the unit used in output.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Divergence {
    /// Step of the curve: 1 sample (its duration in s in output).
    #[serde(rename = "step_s")]
    pub step: f64,
    /// Mean natural logarithm of the distance (signal's unit) after 0, 1, ... samples, up to the
    /// horizon. The curve ends before the first step without a valid distance. It is empty for a
    /// constant signal, for one that repeats exactly, and for a radius with too few neighbours.
    pub curve: Vec<f64>,
    /// Number of pairs (Rosenstein) or states (Kantz) averaged in each value.
    pub counted: Vec<usize>,
    /// Scaling region, if there is one.
    pub region: Option<ScalingRegion>,
}

impl Divergence {
    /// Converts times from samples to seconds. `rate` is the sample rate in Hz.
    pub fn in_seconds(self, rate: f64) -> Self {
        let region = self.region.map(|region| ScalingRegion {
            from: region.from / rate,
            to: region.to / rate,
            slope: region.slope * rate,
            error: region.error * rate,
            ..region
        });
        Self {
            step: self.step / rate,
            region,
            ..self
        }
    }
}

/// Computes the divergence curve of nearest neighbours. The result does not depend on the number of
/// threads.
///
/// # Errors
/// [`AnalysisError::InvalidDelay`] for a lag or dimension of 0; [`AnalysisError::ZeroCount`] for a
/// maximum number of states of 0; [`AnalysisError::TooShort`] if the delay vectors that can be followed
/// over the horizon span at most two Theiler windows.
pub fn divergence(samples: &[f64], search: &DivergenceSearch) -> Result<Divergence, AnalysisError> {
    let vectors = DelayVectors::new(samples, search.lag, search.dimension)?;
    search.check(&vectors)?;
    let norm = match search.method {
        DivergenceMethod::Rosenstein => Norm::Euclidean,
        DivergenceMethod::Kantz { .. } => Norm::Maximum,
    };
    divergence_in(&NeighbourTree::new(vectors, norm), search)
}

/// [`divergence`] for a tree of the delay vectors, in the norm of the method.
pub(crate) fn divergence_in(
    tree: &NeighbourTree<'_>,
    search: &DivergenceSearch,
) -> Result<Divergence, AnalysisError> {
    search.check(tree.vectors())?;
    let samples = tree.vectors().samples();
    let limit = tree.vectors().len() - search.horizon;
    let references = search.max_references.min(limit);
    let unit = Some(largest(samples)).filter(|l| *l > 0.0).unwrap_or(1.0);
    let tracker = PairTracker {
        samples,
        search,
        limit,
        tree,
        deviation: deviation(samples),
        unit,
    };
    let blocks: Vec<LogSums> = (0..BLOCKS)
        .into_par_iter()
        .map(|block| {
            let range = block * references / BLOCKS..(block + 1) * references / BLOCKS;
            tracker.track(range.map(|r| r * limit / references))
        })
        .collect();
    let mut all = LogSums::new(search, unit);
    blocks.iter().for_each(|block| all.merge(block));
    let curve = all.means();
    let blocks: Vec<Vec<f64>> = blocks.iter().map(LogSums::means).collect();
    Ok(Divergence {
        step: 1.0,
        region: scaling_region(&curve, &blocks, search.theiler),
        counted: all.counts[..curve.len()].to_vec(),
        curve,
    })
}

/// Number of factors multiplied before the exponent of the product is split off. Each factor is above the
/// square of [`ROUNDING`], which keeps products above 1e-288.
const FACTORS: usize = 12;

/// Time steps whose products stay in the L1 cache.
const TILE: usize = 512;

/// Time steps whose sums are held in registers.
const BLOCK: usize = 16;

/// Bits of the mantissa of a number, and the exponent of 1.
const MANTISSA: u64 = (1 << 52) - 1;
const EXPONENT_OF_ONE: u64 = 1023;

/// Sums of logarithms of distances for each time step: the logarithms of products of the distances or of
/// their squares, because a root and a logarithm for each distance would take most of the time.
struct LogSums {
    /// Largest sample magnitude, the unit of the distances.
    unit: f64,
    /// Whether the factors are squares of the distances.
    squared: bool,
    /// Sums of the logarithms of distances over the unit.
    sums: Vec<f64>,
    counts: Vec<usize>,
    /// Products of factors, without the powers of two that are in the exponents.
    products: Vec<f64>,
    exponents: Vec<u64>,
}

impl LogSums {
    fn new(search: &DivergenceSearch, unit: f64) -> Self {
        let steps = search.horizon + 1;
        Self {
            unit,
            squared: matches!(search.method, DivergenceMethod::Rosenstein),
            sums: vec![0.0; steps],
            counts: vec![0; steps],
            products: vec![1.0; steps],
            exponents: vec![0; steps],
        }
    }

    /// Adds the factors of these steps that are above rounding error. After at most [`FACTORS`] calls for a
    /// step the exponents must be split off.
    fn accumulate(&mut self, steps: Range<usize>, factors: &[f64]) {
        let (scale, least) = if self.squared {
            ([1.0 / self.unit; 2], ROUNDING * ROUNDING)
        } else {
            ([1.0 / self.unit, 1.0], ROUNDING)
        };
        let (products, counts) = (&mut self.products[steps.clone()], &mut self.counts[steps]);
        vectorised(
            #[inline(always)]
            || {
                for ((product, count), factor) in products.iter_mut().zip(&mut *counts).zip(factors)
                {
                    let factor = factor * scale[0] * scale[1];
                    let above_rounding = factor > least;
                    *product *= if above_rounding { factor } else { 1.0 };
                    *count += usize::from(above_rounding);
                }
            },
        );
    }

    /// Splits the powers of two off the products.
    fn split_exponents(&mut self, steps: Range<usize>) {
        let products = &mut self.products[steps.clone()];
        let exponents = &mut self.exponents[steps];
        vectorised(
            #[inline(always)]
            || {
                for (product, exponent) in products.iter_mut().zip(&mut *exponents) {
                    let bits = product.to_bits();
                    // Wraps below 1; the sum is read as a signed number.
                    *exponent = exponent.wrapping_add((bits >> 52).wrapping_sub(EXPONENT_OF_ONE));
                    *product = f64::from_bits(bits & MANTISSA | EXPONENT_OF_ONE << 52);
                }
            },
        );
    }

    /// Computes the sums, after the last factor.
    fn finish(mut self) -> Self {
        let power = if self.squared { 0.5 } else { 1.0 };
        let parts = self.products.iter().zip(&self.exponents);
        for (sum, (product, &exponent)) in self.sums.iter_mut().zip(parts) {
            *sum = power * (product.ln() + exponent as i64 as f64 * LN_2);
        }
        self
    }

    fn merge(&mut self, other: &LogSums) {
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            *sum += more;
        }
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }

    /// Mean logarithms, up to the first step without a distance.
    fn means(&self) -> Vec<f64> {
        let both = self.sums.iter().zip(&self.counts);
        let counted = both.take_while(|(_, count)| **count > 0);
        let unit = self.unit.ln();
        let mean = |(sum, count): (&f64, &usize)| unit + sum / *count as f64;
        counted.map(mean).collect()
    }
}

/// Follows states and their neighbours.
struct PairTracker<'a> {
    samples: &'a [f64],
    search: &'a DivergenceSearch,
    /// Vectors before this one can be followed over the full horizon.
    limit: usize,
    tree: &'a NeighbourTree<'a>,
    /// Standard deviation of the samples.
    deviation: f64,
    /// Largest sample magnitude; 1 if all samples are 0.
    unit: f64,
}

impl PairTracker<'_> {
    fn track(&self, references: impl Iterator<Item = usize> + Clone) -> LogSums {
        let mut log_sums = LogSums::new(self.search, self.unit);
        let steps = 0..self.search.horizon + 1;
        let (limit, separation) = (self.limit, self.search.min_separation());
        match self.search.method {
            DivergenceMethod::Rosenstein => {
                let near = self
                    .tree
                    .nearest_each(references.clone(), separation, limit);
                let both = references.zip(near);
                let pairs: Vec<_> = both
                    .filter_map(|(i, near)| Some((i, near?.index)))
                    .collect();
                let (mut squares, mut sums) = (Vec::new(), Vec::new());
                for from in steps.clone().step_by(TILE) {
                    let steps = from..steps.end.min(from + TILE);
                    for pairs in pairs.chunks(FACTORS) {
                        for &(i, j) in pairs {
                            sums.resize(steps.len().next_multiple_of(BLOCK), 0.0);
                            let start = [i + from, j + from];
                            self.squared_distances(start, steps.len(), &mut squares, &mut sums);
                            log_sums.accumulate(steps.clone(), &sums);
                        }
                        log_sums.split_exponents(steps.clone());
                    }
                }
            }
            DivergenceMethod::Kantz { radius } => {
                let radius = radius * self.deviation;
                let mut near = Vec::new();
                let mut means = vec![0.0; steps.len()];
                for i in references {
                    near.clear();
                    self.tree
                        .within(i, radius, separation, limit, |n| near.push(n.index));
                    if near.len() >= MIN_NEIGHBOURS {
                        self.mean_sample_distances(i, &near, &mut means);
                        log_sums.accumulate(steps.clone(), &means);
                        log_sums.split_exponents(steps.clone());
                    }
                }
            }
        }
        log_sums.finish()
    }

    /// `|y_(i+k) - y_(j+k)|^2` for `k` = 0, 1, ... up to `count`. The sums fill whole blocks; those beyond `count` are
    /// arbitrary.
    fn squared_distances(
        &self,
        [i, j]: [usize; 2],
        count: usize,
        squares: &mut Vec<f64>,
        sums: &mut [f64],
    ) {
        let DivergenceSearch { dimension, lag, .. } = *self.search;
        let span = count + (dimension - 1) * lag;
        squares.resize(span + BLOCK, 0.0);
        let (here, there) = (&self.samples[i..][..span], &self.samples[j..][..span]);
        vectorised(
            #[inline(always)]
            || {
                for ((square, a), b) in squares.iter_mut().zip(here).zip(there) {
                    *square = (a - b) * (a - b);
                }
                for (block, sums) in sums.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
                    let mut block_sums = [0.0; BLOCK];
                    // Each coordinate uses the same squares, shifted by a lag.
                    for coordinate in 0..dimension {
                        let from = block * BLOCK + coordinate * lag;
                        let squares: &[f64; BLOCK] = squares[from..].first_chunk().expect("padded");
                        for (sum, square) in block_sums.iter_mut().zip(squares) {
                            *sum += square;
                        }
                    }
                    *sums = block_sums;
                }
            },
        );
    }

    /// Mean over the neighbours `j` of `|x_(i+k) - x_(j+k)|`, `x` the newest coordinate, for `k` = 0, 1,
    /// ...
    fn mean_sample_distances(&self, i: usize, neighbours: &[usize], means: &mut [f64]) {
        let newest = &self.samples[(self.search.dimension - 1) * self.search.lag..];
        let selected = neighbours
            .iter()
            .step_by(neighbours.len().div_ceil(MAX_NEIGHBOURS));
        let share = 1.0 / selected.len() as f64;
        vectorised(
            #[inline(always)]
            || {
                means.fill(0.0);
                let here = &newest[i..][..means.len()];
                for &j in selected.clone() {
                    let there = &newest[j..][..means.len()];
                    for ((sum, a), b) in means.iter_mut().zip(here).zip(there) {
                        *sum += (a - b).abs();
                    }
                }
                means.iter_mut().for_each(|d| *d *= share);
            },
        );
    }
}

#[cfg(test)]
mod tests;
