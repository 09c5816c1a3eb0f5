//! The largest Lyapunov exponent of a signal, from how neighbours part.
//!
//! Two states of a chaotic system that come near each other at different times part again like
//! `exp(lambda t)`: the logarithm of their distance, averaged over many pairs, is a line whose
//! slope is the largest exponent, until the distance is that of the attractor.
//!
//! ```text
//! Rosenstein:  S(k) = mean over i of ln |y_(i+k) - y_(j+k)|,   y_j the nearest neighbour of y_i
//! Kantz:       S(k) = mean over i of ln (mean over j in U_i of |x_(i+k) - x_(j+k)|)
//! ```
//!
//! `y` are delay vectors, Eq. (25), `x` the newest coordinate of each. Rosenstein, Collins and De
//! Luca (Physica D 65, 117, 1993) follow the Euclidean distance to one neighbour; Kantz (Phys.
//! Lett. A 185, 77, 1994) the difference of one sample to all neighbours `U_i` within a radius, in
//! the maximum norm. Neighbours must be a Theiler window apart in time, and have the whole
//! horizon ahead of them. Distances of zero, or as small as rounding, have no logarithm and are
//! left out.
//!
//! How far to trust it. The logistic map at 4 and the Henon map (5000 samples) come out within 1
//! and 2 %, with Kantz's method (radius 0.005) within 3 %. Flows are harder: the finite number of
//! samples flattens the curve of Rosenstein, and Kantz's logarithm of a mean favours the pairs
//! that part fast. The exponent over the true one, for three trajectories and the dimensions 3 and
//! 5, after [`DivergenceSearch::for_delay`]:
//!
//! | flow | samples | Rosenstein | Kantz, 0.02 |
//! |---|---|---|---|
//! | Lorenz, step 0.01, lag 16 | 20,000 | 0.90 to 0.95 | mostly no region |
//! | | 50,000 | 0.91 to 0.93 | 1.05 to 1.16 |
//! | Roessler, step 0.1, lag 14 | 20,000 | 0.72 to 0.96 | mostly no region |
//! | | 50,000 | 0.86 to 0.95 | 0.84 to 1.14 |
//!
//! Rosenstein's are within 2.4 errors of the truth, but for one trajectory of 20,000 samples
//! (3.5), Kantz's within five.
//!
//! Periodic and quasi-periodic signals have a flat curve and no region, and so has white noise,
//! whose neighbours are as far apart as any after one step.

use pulp::Arch;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::scaling::{ScalingRegion, scaling_region};
use super::{ROUNDING, largest};
use crate::analysis::{AnalysisError, DelayVectors, NeighbourTree, Norm, deviation};

/// Consecutive stretches of the signal whose curves are kept apart, to tell by their scatter how
/// sure the slope is. Also the pieces of parallel work; a fixed number, so that sums do not
/// depend on the number of threads.
const BLOCKS: usize = 16;

/// A mean of Kantz's is taken over so many neighbours at least: the logarithm of a mean of few is
/// low on average.
const FEWEST_NEIGHBOURS: usize = 5;

/// And over about so many at most, evenly picked: more make it slow and hardly surer.
const MOST_NEIGHBOURS: usize = 500;

/// Whose distance is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DivergenceMethod {
    /// The nearest neighbour of each state (Rosenstein, Collins and De Luca 1993).
    Rosenstein,
    /// All neighbours within a radius, given as a share of the signal's deviation (Kantz 1994).
    /// States with fewer than five are passed over; of more than 500 about so many are picked
    /// evenly.
    Kantz {
        /// Radius over the standard deviation of the samples, above 0; 0.01 to 0.1 is usual, the
        /// smaller the more samples there are.
        radius: f64,
    },
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DivergenceSearch {
    /// Delay, samples, at least 1.
    pub lag: usize,
    /// Embedding dimension, at least 1.
    pub dimension: usize,
    /// Pairs closer in time than this many samples are no neighbours; a mean period of a flow, 1
    /// for a map. No scaling region is shorter.
    pub theiler: usize,
    /// How long neighbours are followed, samples. Should reach where the curve is flat.
    pub horizon: usize,
    /// Whose distance is followed.
    pub method: DivergenceMethod,
    /// At most this many states are followed, evenly spread, at least 1; 2000 is plenty.
    pub most_references: usize,
}

impl DivergenceSearch {
    /// Rosenstein's method on 2000 states for a delay chosen before, such as a
    /// [`DelayChoice`](crate::analysis::DelayChoice), and so many samples.
    ///
    /// Neighbours are followed for 20 Theiler windows (or lags, if those are longer), which is 20
    /// turns of a flow and 20 steps of a map, but for no more than a quarter of the signal.
    pub fn for_delay(lag: usize, dimension: usize, theiler: usize, samples: usize) -> Self {
        Self {
            lag,
            dimension,
            theiler,
            horizon: theiler.max(lag).saturating_mul(20).min(samples / 4),
            method: DivergenceMethod::Rosenstein,
            most_references: 2000,
        }
    }
}

/// How neighbours part.
///
/// Times are counted in samples, as [`divergence`] finds them; [`in_seconds`](Divergence::in_seconds)
/// makes them seconds, which is how they are written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Divergence {
    /// Spacing of the curve: 1 sample.
    #[serde(rename = "step_s")]
    pub step: f64,
    /// Mean natural logarithm of the distance (signal's unit) after 0, 1, ... samples, up to the
    /// horizon. Ends before the first step without a distance to count: empty for a constant
    /// signal, one that repeats exactly, or a radius with too few neighbours.
    pub curve: Vec<f64>,
    /// How many pairs (Rosenstein) or states (Kantz) each value is the mean of.
    pub counted: Vec<usize>,
    /// The straight part, if there is one.
    pub region: Option<ScalingRegion>,
}

impl Divergence {
    /// The same with seconds in place of samples, of which there are `rate` a second.
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

/// Follows neighbours. The result does not depend on the number of threads.
///
/// # Errors
/// [`AnalysisError::NoDelay`] for a lag or dimension of 0, [`AnalysisError::Zero`] if no state is
/// to be followed, [`AnalysisError::TooShort`] if the delay vectors with the horizon ahead are
/// not more than two Theiler windows.
pub fn divergence(samples: &[f64], search: &DivergenceSearch) -> Result<Divergence, AnalysisError> {
    let vectors = DelayVectors::new(samples, search.lag, search.dimension)?;
    if search.most_references == 0 {
        return Err(AnalysisError::Zero {
            what: "divergence: the number of states followed",
        });
    }
    let apart = search.theiler.max(1);
    let fewest = apart
        .saturating_mul(2)
        .saturating_add(search.horizon)
        .saturating_add(1);
    if vectors.len() < fewest {
        return Err(AnalysisError::TooShort {
            what: "divergence",
            have: samples.len(),
            need: DelayVectors::samples_for(fewest, search.lag, search.dimension),
        });
    }
    let limit = vectors.len() - search.horizon;
    let references = search.most_references.min(limit);
    let norm = match search.method {
        DivergenceMethod::Rosenstein => Norm::Euclidean,
        DivergenceMethod::Kantz { .. } => Norm::Maximum,
    };
    let unit = Some(largest(samples)).filter(|l| *l > 0.0).unwrap_or(1.0);
    let follower = Follower {
        samples,
        search,
        apart,
        limit,
        tree: NeighbourTree::new(vectors, norm),
        deviation: deviation(samples),
        unit,
        arch: Arch::new(),
    };
    let blocks: Vec<Tally> = (0..BLOCKS)
        .into_par_iter()
        .map(|block| {
            let mine = block * references / BLOCKS..(block + 1) * references / BLOCKS;
            follower.follow(mine.map(|r| r * limit / references))
        })
        .collect();
    let mut all = Tally::new(search.horizon, unit);
    blocks.iter().for_each(|block| all.add(block));
    let curve = all.means();
    let blocks: Vec<Vec<f64>> = blocks.iter().map(Tally::means).collect();
    Ok(Divergence {
        step: 1.0,
        region: scaling_region(&curve, &blocks, search.theiler),
        counted: all.counts[..curve.len()].to_vec(),
        curve,
    })
}

/// So many distances are multiplied before the logarithm of the product is taken: one for each
/// would take most of the time. Each is above [`ROUNDING`] in the unit, so that no product is
/// below 1e-192.
const FACTORS: usize = 16;

/// Sums of logarithms, by step.
struct Tally {
    arch: Arch,
    /// The largest sample; distances are counted over it.
    unit: f64,
    /// Logarithms of distances over the unit.
    sums: Vec<f64>,
    counts: Vec<usize>,
    /// Distances over the unit that are in no sum yet, multiplied.
    products: Vec<f64>,
    /// How many factors they have at most.
    factors: usize,
}

impl Tally {
    fn new(horizon: usize, unit: f64) -> Self {
        Self {
            arch: Arch::new(),
            unit,
            sums: vec![0.0; horizon + 1],
            counts: vec![0; horizon + 1],
            products: vec![1.0; horizon + 1],
            factors: 0,
        }
    }

    /// Counts the distances above rounding.
    fn count(&mut self, distances: &[f64]) {
        let over_unit = 1.0 / self.unit;
        self.arch.dispatch(|| {
            let places = self.products.iter_mut().zip(&mut self.counts);
            for ((product, count), &distance) in places.zip(distances) {
                let distance = distance * over_unit;
                let counts = distance > ROUNDING;
                *product *= if counts { distance } else { 1.0 };
                *count += usize::from(counts);
            }
        });
        self.factors += 1;
        if self.factors == FACTORS {
            self.close();
        }
    }

    /// Takes the products into the sums.
    fn close(&mut self) {
        for (sum, product) in self.sums.iter_mut().zip(&mut self.products) {
            *sum += std::mem::replace(product, 1.0).ln();
        }
        self.factors = 0;
    }

    fn add(&mut self, other: &Tally) {
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            *sum += more;
        }
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }

    /// Means, up to the first step without a count.
    fn means(&self) -> Vec<f64> {
        let both = self.sums.iter().zip(&self.counts);
        let counted = both.take_while(|(_, count)| **count > 0);
        let unit = self.unit.ln();
        let mean = |(sum, count): (&f64, &usize)| unit + sum / *count as f64;
        counted.map(mean).collect()
    }
}

/// Follows states and their neighbours.
struct Follower<'a> {
    samples: &'a [f64],
    search: &'a DivergenceSearch,
    apart: usize,
    /// Vectors before this one have the horizon ahead of them.
    limit: usize,
    tree: NeighbourTree<'a>,
    /// Standard deviation of the samples.
    deviation: f64,
    /// The largest sample; 1 if all are 0.
    unit: f64,
    arch: Arch,
}

impl Follower<'_> {
    fn follow(&self, references: impl Iterator<Item = usize>) -> Tally {
        let mut tally = Tally::new(self.search.horizon, self.unit);
        let mut distances = vec![0.0; self.search.horizon + 1];
        match self.search.method {
            DivergenceMethod::Rosenstein => {
                let mut squares = Vec::new();
                for i in references {
                    if let Some(near) = self.tree.nearest(i, self.apart, self.limit) {
                        self.vector_distances(i, near.index, &mut squares, &mut distances);
                        tally.count(&distances);
                    }
                }
            }
            DivergenceMethod::Kantz { radius } => {
                let radius = radius * self.deviation;
                let mut near = Vec::new();
                for i in references {
                    near.clear();
                    self.tree
                        .within(i, radius, self.apart, self.limit, |n| near.push(n.index));
                    if near.len() >= FEWEST_NEIGHBOURS {
                        self.mean_sample_distances(i, &near, &mut distances);
                        tally.count(&distances);
                    }
                }
            }
        }
        tally.close();
        tally
    }

    /// `|y_(i+k) - y_(j+k)|` for `k` = 0, 1, ...
    fn vector_distances(&self, i: usize, j: usize, squares: &mut Vec<f64>, distances: &mut [f64]) {
        let span = distances.len() + (self.search.dimension - 1) * self.search.lag;
        let (here, there) = (&self.samples[i..][..span], &self.samples[j..][..span]);
        self.arch.dispatch(|| {
            squares.clear();
            squares.extend(here.iter().zip(there).map(|(a, b)| (a - b) * (a - b)));
            distances.fill(0.0);
            // Each coordinate is the same row of squares, a lag on.
            for coordinate in squares.windows(distances.len()).step_by(self.search.lag) {
                for (sum, square) in distances.iter_mut().zip(coordinate) {
                    *sum += square;
                }
            }
            distances.iter_mut().for_each(|d| *d = d.sqrt());
        });
    }

    /// Mean over the neighbours `j` of `|x_(i+k) - x_(j+k)|`, `x` the newest coordinate, for `k` =
    /// 0, 1, ...
    fn mean_sample_distances(&self, i: usize, neighbours: &[usize], means: &mut [f64]) {
        let newest = &self.samples[(self.search.dimension - 1) * self.search.lag..];
        let picked = neighbours
            .iter()
            .step_by(neighbours.len().div_ceil(MOST_NEIGHBOURS));
        let share = 1.0 / picked.len() as f64;
        self.arch.dispatch(|| {
            means.fill(0.0);
            let here = &newest[i..][..means.len()];
            for &j in picked {
                let there = &newest[j..][..means.len()];
                for ((sum, a), b) in means.iter_mut().zip(here).zip(there) {
                    *sum += (a - b).abs();
                }
            }
            means.iter_mut().for_each(|d| *d *= share);
        });
    }
}

#[cfg(test)]
mod tests;
