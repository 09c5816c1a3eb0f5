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

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::scaling::{ScalingRegion, scaling_region};
use super::{ROUNDING, largest};
use crate::simd::vectorised;
use crate::{
    AnalysisError, delay::DelayVectors, neighbours::NeighbourTree, norm::Norm, stats::deviation,
};

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
    /// [`DelayChoice`](crate::delay::DelayChoice), and a signal of `samples` samples.
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
/// [`AnalysisError::InvalidDelay`] for a lag or dimension of 0; [`AnalysisError::TooShort`] if the delay vectors that
/// can be followed over the horizon span at most two Theiler windows.
pub fn divergence(samples: &[f64], search: &DivergenceSearch) -> Result<Divergence, AnalysisError> {
    let vectors = DelayVectors::new(samples, search.lag, search.dimension)?;
    let separation = search.theiler.max(1);
    let min_vectors = separation
        .saturating_mul(2)
        .saturating_add(search.horizon)
        .saturating_add(1);
    let need = DelayVectors::samples_for(min_vectors, search.lag, search.dimension);
    AnalysisError::check_length("divergence", samples.len(), need)?;
    let norm = match search.method {
        DivergenceMethod::Rosenstein => Norm::Euclidean,
        DivergenceMethod::Kantz { .. } => Norm::Maximum,
    };
    let largest = largest(samples);
    // A power of two changes the unit without rounding.
    let unit = if largest > 0.0 {
        largest.log2().floor().exp2()
    } else {
        1.0
    };
    let scaled: Vec<f64> = samples.iter().map(|x| x / unit).collect();
    let limit = vectors.len() - search.horizon;
    let tracker = PairTracker {
        tree: NeighbourTree::new(vectors, norm),
        scaled: DelayVectors::new(&scaled, search.lag, search.dimension)?,
        search,
        separation,
        limit,
        deviation: deviation(samples),
        rounding: ROUNDING * largest / unit,
    };
    let references = search.max_references.min(limit);
    let blocks: Vec<Vec<(f64, usize)>> = (0..BLOCKS)
        .into_par_iter()
        .map(|block| {
            let range = block * references / BLOCKS..(block + 1) * references / BLOCKS;
            tracker.track(range.map(|r| r * limit / references))
        })
        .collect();
    let at_step = |k: usize| {
        let of_blocks = blocks.iter().map(|block| block[k]);
        of_blocks.fold((0.0, 0), |all, more| (all.0 + more.0, all.1 + more.1))
    };
    let all: Vec<(f64, usize)> = (0..=search.horizon).map(at_step).collect();
    // Mean logarithms, up to the first step without a distance.
    let means = |sums: &Vec<(f64, usize)>| -> Vec<f64> {
        let counted = sums.iter().take_while(|(_, count)| *count > 0);
        counted
            .map(|(sum, count)| unit.ln() + sum / *count as f64)
            .collect()
    };
    let curve = means(&all);
    let blocks: Vec<Vec<f64>> = blocks.iter().map(means).collect();
    Ok(Divergence {
        step: 1.0,
        region: scaling_region(&curve, &blocks, search.theiler),
        counted: all[..curve.len()].iter().map(|(_, count)| *count).collect(),
        curve,
    })
}

/// Number of distances of which one logarithm is taken, that of their product. The squares of distances are above
/// the square of [`ROUNDING`], which keeps products above 1e-288.
const FACTORS: usize = 12;

/// Follows states and their neighbours.
struct PairTracker<'a> {
    tree: NeighbourTree<'a>,
    /// The vectors in the unit of the sums.
    scaled: DelayVectors<'a>,
    search: &'a DivergenceSearch,
    /// Least time between neighbours, samples.
    separation: usize,
    /// Vectors before this one can be followed over the full horizon.
    limit: usize,
    /// Standard deviation of the samples.
    deviation: f64,
    /// Smaller distances are rounding errors.
    rounding: f64,
}

impl PairTracker<'_> {
    /// Sums of logarithms of distances, and their numbers, at each time step.
    fn track(&self, references: impl Iterator<Item = usize> + Clone) -> Vec<(f64, usize)> {
        let separation = self.separation;
        // Newest coordinate only, or all of them.
        let (norm, first, states): (_, _, Vec<(usize, Vec<usize>)>) = match self.search.method {
            DivergenceMethod::Rosenstein => {
                let near = self
                    .tree
                    .nearest_each(references.clone(), separation, self.limit);
                let pairs = references.zip(near);
                let pairs = pairs.filter_map(|(i, near)| Some((i, vec![near?.index])));
                (Norm::Euclidean, 0, pairs.collect())
            }
            DivergenceMethod::Kantz { radius } => {
                let near = |i| {
                    let mut near = Vec::new();
                    let radius = radius * self.deviation;
                    self.tree
                        .within(i, radius, separation, self.limit, |j| near.push(j));
                    let step = near.len().div_ceil(MAX_NEIGHBOURS);
                    (near.len() >= MIN_NEIGHBOURS)
                        .then(|| (i, near.into_iter().step_by(step).collect()))
                };
                (
                    Norm::Manhattan,
                    self.search.dimension - 1,
                    references.filter_map(near).collect(),
                )
            }
        };
        let steps = self.search.horizon + 1;
        let mut sums = vec![(0.0, 0); steps];
        let least = norm.unrooted_limit(self.rounding);
        let power = if norm == Norm::Euclidean { 0.5 } else { 1.0 };
        let (mut distances, mut products) = (vec![0.0; steps], vec![1.0; steps]);
        for states in states.chunks(FACTORS) {
            products.fill(1.0);
            for (i, near) in states {
                vectorised(
                    #[inline(always)]
                    || {
                        distances.fill(0.0);
                        for (j, c) in near
                            .iter()
                            .flat_map(|j| (first..self.search.dimension).map(move |c| (j, c)))
                        {
                            let [reference, neighbour] =
                                [i, j].map(|k| &self.scaled.coordinate(c)[*k..]);
                            let differences = reference.iter().zip(neighbour).map(|(a, b)| a - b);
                            norm.add(&mut distances, differences);
                        }
                        let share = 1.0 / near.len() as f64;
                        let of_step = products.iter_mut().zip(&mut sums).zip(&distances);
                        for ((product, (_, count)), distance) in of_step {
                            let is_counted = distance * share > least;
                            *product *= if is_counted { distance * share } else { 1.0 };
                            *count += usize::from(is_counted);
                        }
                    },
                );
            }
            for ((sum, _), product) in sums.iter_mut().zip(&products) {
                *sum += power * product.ln();
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests;
