//! Prediction by neighbouring states, and the position of the nearest ones.

use std::iter::StepBy;

use nalgebra::{SMatrix, SVector};

use super::features::SECTIONS;
use crate::{
    AnalysisError,
    delay::{DelayVectors, LAGS_PER_PERIOD},
    neighbours::{Neighbour, NeighbourTree},
    norm::Norm,
    stats::{mean, median},
};

/// Embedding dimension, as in the paper; sufficient for any torus of two frequencies.
const DIMENSION: usize = 5;

/// Part of the record after which neighbours have aligned with the direction of growth.
const EARLY: [f64; 2] = [0.02, 0.05];

/// Number of reference states. A record with fewer samples has no verdict.
pub(super) const REFERENCES: usize = 500;

/// Least distance of states, and error of a prediction, over the standard deviation. Smaller ones come from the spacing of
/// the states or from a second tone too weak to count, not from noise.
pub(super) const MIN_ERROR: f64 = 0.015;

/// Prediction errors over the standard deviation of the signal.
#[derive(Clone, Copy, Debug)]
pub(super) struct PredictionError {
    /// Nearest-neighbour prediction one lag ahead.
    pub short: f64,
    /// Prediction by a linear map over this time.
    pub linear: f64,
}

impl PredictionError {
    /// Ratio of the nearest-neighbour prediction error to that of a linear map.
    pub(super) fn over_linear(&self) -> f64 {
        self.short / self.linear.max(f64::MIN_POSITIVE)
    }
}

/// States of a record and their neighbours.
pub(super) struct Neighbourhood<'a> {
    tree: NeighbourTree<'a>,
    vectors: DelayVectors<'a>,
    lag: usize,
    /// Variance of the samples.
    power: f64,
}

impl<'a> Neighbourhood<'a> {
    pub(super) fn new(samples: &'a [f64], lag: usize, power: f64) -> Result<Self, AnalysisError> {
        let vectors = DelayVectors::new(samples, lag, DIMENSION)?;
        Ok(Self {
            tree: NeighbourTree::new(vectors, Norm::Euclidean),
            vectors,
            lag,
            power,
        })
    }

    /// Prediction errors one lag ahead.
    pub(super) fn prediction_error(&self) -> PredictionError {
        let Self { vectors, lag, .. } = *self;
        let limit = vectors.len().saturating_sub(lag).max(1);
        let newest = vectors.coordinate(DIMENSION - 1);
        let square = |(i, near): (usize, Option<Neighbour>)| {
            Some((newest[i + lag] - newest[near?.index + lag]).powi(2))
        };
        let squares = references(limit).zip(self.neighbours(limit));
        // Unrelated values differ by twice the variance.
        let unrelated = 2.0 * self.power;
        let short = mean_or(unrelated, squares.filter_map(square)) / unrelated;
        let rows = references(limit).map(|i| {
            let state = SVector::<f64, DIMENSION>::from_fn(|c, _| vectors.coordinate(c)[i]);
            (state, newest[i + lag])
        });
        PredictionError {
            short: short.sqrt(),
            linear: (linear_residual(rows) / self.power).sqrt(),
        }
    }

    /// Growth of the distance of neighbours from [`EARLY`] to the second eighth of the record, natural logarithm: mean over
    /// the pairs of half the logarithm of the ratio of the mean squares; 0 without a pair.
    pub(super) fn divergence(&self) -> f64 {
        let (count, period) = (self.vectors.len(), LAGS_PER_PERIOD * self.lag);
        let steps = |[from, to]: [f64; 2]| {
            let [from, to] = [from, to].map(|share| (share * count as f64) as usize);
            (from..=to.max(from + period)).step_by(self.lag)
        };
        let eighth = 1.0 / SECTIONS as f64;
        let parts = [EARLY, [eighth, 2.0 * eighth]].map(steps);
        let end = parts[1].clone().last().unwrap_or(count);
        let newest = self.vectors.coordinate(DIMENSION - 1);
        let floor = MIN_ERROR.powi(2) * self.power;
        let growth = |(i, near): (usize, Option<Neighbour>)| {
            let j = near?.index;
            let square = |k: usize| (newest[i + k] - newest[j + k]).powi(2);
            let mean_square = |steps: StepBy<_>| floor + mean_or(0.0, steps.map(square));
            let [early, late] = parts.clone().map(mean_square);
            Some(0.5 * (late / early).ln())
        };
        let limit = count.saturating_sub(end);
        let pairs = references(limit).zip(self.neighbours(limit));
        mean_or(0.0, pairs.filter_map(growth))
    }

    /// Median over the states of the logarithm of the distance to the nearest state at least half a record apart over
    /// that to the nearest state at any other time. 0 for a stationary motion, and for one that is so after its onset.
    pub(super) fn drift(&self) -> f64 {
        let count = self.vectors.len();
        let floor = MIN_ERROR.powi(2) * self.power * DIMENSION as f64;
        let square = |near: Option<Neighbour>| Some(near?.distance.powi(2) + floor);
        let log_ratio = |(distant, any)| Some(0.5 * (square(distant)? / square(any)?).ln());
        let distant = self.tree.nearest_each(references(count), count / 2, count);
        let pairs = distant.into_iter().zip(self.neighbours(count));
        median(pairs.filter_map(log_ratio))
    }

    /// The nearest state at any other time of each of the reference states among the first `limit` ones.
    fn neighbours(&self, limit: usize) -> Vec<Option<Neighbour>> {
        let period = LAGS_PER_PERIOD * self.lag;
        self.tree.nearest_each(references(limit), period, limit)
    }
}

/// Mean, or `none` without values.
fn mean_or(none: f64, values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    if values.is_empty() {
        none
    } else {
        mean(&values)
    }
}

/// Indices of the reference states, evenly spread over `limit`.
fn references(limit: usize) -> impl Iterator<Item = usize> + Clone {
    let count = REFERENCES.min(limit);
    (0..count).map(move |r| r * limit / count)
}

/// Mean square error of the best linear map from states to values.
fn linear_residual(rows: impl Iterator<Item = (SVector<f64, DIMENSION>, f64)> + Clone) -> f64 {
    let mut products = SMatrix::<f64, DIMENSION, DIMENSION>::zeros();
    let mut target = SVector::<f64, DIMENSION>::zeros();
    for (state, next) in rows.clone() {
        products += state * state.transpose();
        target += state * next;
    }
    // A sine spans only two directions: the ridge regularises the others.
    let ridge = 1e-10 * products.trace();
    products += SMatrix::identity() * ridge;
    let map = products.cholesky().map(|factors| factors.solve(&target));
    let map = map.unwrap_or_default();
    mean_or(
        0.0,
        rows.map(|(state, next)| (next - state.dot(&map)).powi(2)),
    )
}
