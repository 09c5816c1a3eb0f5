//! Prediction by neighbouring states, and the position of the nearest ones.

use nalgebra::{SMatrix, SVector};

use super::LONG_PERIODS;
use crate::{
    AnalysisError,
    delay::{DelayVectors, LAGS_PER_PERIOD},
    neighbours::{Neighbour, NeighbourTree},
    norm::Norm,
    stats::mean,
};

/// Embedding dimension, as in the paper; sufficient for any torus of two frequencies.
const DIMENSION: usize = 5;

/// Number of reference states. A record with fewer samples has no verdict.
pub(super) const REFERENCES: usize = 500;

/// Prediction errors below this come from the spacing of the states, not from noise.
pub(super) const MIN_ERROR: f64 = 3e-3;

/// Prediction errors over the standard deviation of the signal.
#[derive(Clone, Copy, Debug)]
pub(super) struct PredictionError {
    /// Nearest-neighbour prediction one lag ahead.
    pub short: f64,
    /// Prediction by a linear map over this time.
    pub linear: f64,
    /// Nearest-neighbour prediction over forty times as long (ten periods).
    pub long: f64,
}

impl PredictionError {
    /// One lag ahead, or the half, quarter, ... of it at which neighbours are furthest ahead of a linear map: strong chaos is
    /// unpredictable over a quarter period, a map at any time but a sample ahead.
    pub(super) fn of(samples: &[f64], lag: usize, power: f64) -> Result<Self, AnalysisError> {
        let (mut ahead, mut best) = (lag, None::<Self>);
        while ahead > 0 {
            let sooner = Neighbourhood::new(samples, ahead, power)?.prediction_error();
            if best.is_none_or(|best| sooner.short * best.linear < best.short * sooner.linear) {
                best = Some(sooner);
            }
            ahead /= 2;
        }
        Ok(best.expect("a lag is at least 1"))
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

    /// Prediction errors one lag and [`LONG_PERIODS`] periods ahead.
    fn prediction_error(&self) -> PredictionError {
        let Self {
            tree,
            vectors,
            lag,
            power,
        } = self;
        let (lag, power, period) = (*lag, *power, LAGS_PER_PERIOD * lag);
        let ahead = (LONG_PERIODS * period).min(vectors.len() / 3).max(lag);
        let limit = vectors.len().saturating_sub(ahead).max(1);
        let newest = vectors.coordinate(DIMENSION - 1);
        // Averaged over the last period, which removes the effect of the phase.
        let late = (0..LAGS_PER_PERIOD).map(|quarter| ahead.saturating_sub(quarter * lag));
        let (mut short, mut long, mut pairs) = (0.0, 0.0, 0.0);
        let nearest = tree.nearest_each(references(limit), period, limit);
        for (i, other) in references(limit).zip(nearest) {
            let Some(other) = other else {
                continue;
            };
            let difference =
                |after: usize| (newest[i + after] - newest[other.index + after]).powi(2);
            short += difference(lag);
            long += late.clone().map(difference).sum::<f64>() / LAGS_PER_PERIOD as f64;
            pairs += 1.0;
        }
        // Unrelated values differ by twice the variance.
        let relative = |sum: f64| {
            if pairs > 0.0 {
                (sum / pairs / (2.0 * power)).sqrt()
            } else {
                1.0
            }
        };
        let rows = references(limit).map(|i| {
            let state = SVector::<f64, DIMENSION>::from_fn(|c, _| vectors.coordinate(c)[i]);
            (state, newest[i + lag])
        });
        PredictionError {
            short: relative(short),
            linear: (linear_residual(rows) / power).sqrt(),
            long: relative(long),
        }
    }

    /// Mean over the states of the logarithm of the distance to the nearest state in the other half of the record over
    /// that to the nearest state at any other time. 0 for a stationary motion.
    pub(super) fn drift(&self) -> f64 {
        let count = self.vectors.len();
        let floor = MIN_ERROR.powi(2) * self.power * DIMENSION as f64;
        let nearest = |separation| self.tree.nearest_each(references(count), separation, count);
        let square = |near: Option<Neighbour>| Some(near?.distance.powi(2) + floor);
        let [distant, any] = [count / 2, LAGS_PER_PERIOD * self.lag].map(nearest);
        let log_ratio = |(distant, any)| Some(0.5 * (square(distant)? / square(any)?).ln());
        let ratios: Vec<f64> = distant.into_iter().zip(any).filter_map(log_ratio).collect();
        mean(&ratios)
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
    let squares: Vec<f64> = rows
        .map(|(state, next)| (next - state.dot(&map)).powi(2))
        .collect();
    mean(&squares)
}
