//! Divergence of neighbouring states, and the position of the nearest ones.

use nalgebra::{SMatrix, SVector};

use crate::{
    delay::DelayVectors,
    neighbours::{Neighbour, NeighbourTree},
    norm::Norm,
};

/// Embedding dimension, as in the paper; sufficient for any torus of two frequencies.
pub(super) const DIMENSION: usize = 5;

/// Lags per period: the lag is about a quarter period.
pub(super) const PERIOD: usize = 4;

/// Long prediction horizon, periods. A shorter record has no verdict.
pub(super) const LONG_PERIODS: usize = 10;

/// Parts of the record after which the distances of neighbours are compared: early, when they have
/// aligned with the direction of growth, and as late as enough of them remain.
const EARLY: [f64; 2] = [0.02, 0.05];
const LATE: [f64; 2] = [0.15, 0.3];

/// States are distant in time if they are at least the record length over this value apart.
const DISTANT_DIVISOR: usize = 3;

/// Number of reference states.
const REFERENCES: usize = 800;

/// Number of rows of the linear fit, and samples of the 0-1 test.
pub(super) const ROWS: usize = 2000;

/// Prediction errors below this come from the spacing of the states, not from noise.
pub(super) const MIN_ERROR: f64 = 3e-3;

/// Prediction errors over the standard deviation of the signal.
#[derive(Clone, Copy, Debug)]
pub(super) struct PredictionError {
    /// Nearest-neighbour prediction over a quarter period, or less if the signal is unpredictable over it.
    pub short: f64,
    /// Prediction by a linear map over this time.
    pub linear: f64,
    /// Nearest-neighbour prediction over forty times as long (ten periods).
    pub long: f64,
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
    pub(super) fn new(vectors: DelayVectors<'a>, lag: usize, power: f64) -> Self {
        Self {
            tree: NeighbourTree::new(vectors, Norm::Euclidean),
            vectors,
            lag,
            power,
        }
    }

    /// Prediction errors one lag and [`LONG_PERIODS`] periods ahead.
    pub(super) fn prediction_error(&self) -> PredictionError {
        let Self {
            tree,
            vectors,
            lag,
            power,
        } = self;
        let (lag, power, period) = (*lag, *power, PERIOD * lag);
        let ahead = (LONG_PERIODS * period).min(vectors.len() / 3).max(lag);
        let limit = vectors.len().saturating_sub(ahead).max(1);
        let newest = vectors.coordinate(DIMENSION - 1);
        // Averaged over the last period, which removes the effect of the phase.
        let late = (0..PERIOD).map(|quarter| ahead.saturating_sub(quarter * lag));
        let (mut short, mut long, mut pairs) = (0.0, 0.0, 0.0);
        let nearest = tree.nearest_each(references(limit), period, limit);
        for (i, other) in references(limit).zip(nearest) {
            let Some(other) = other else {
                continue;
            };
            let difference =
                |after: usize| (newest[i + after] - newest[other.index + after]).powi(2);
            short += difference(lag);
            long += late.clone().map(difference).sum::<f64>() / PERIOD as f64;
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

        let rows = ROWS.min(limit);
        let row = |r: usize| {
            let i = r * limit / rows;
            let state = SVector::<f64, DIMENSION>::from_fn(|c, _| vectors.coordinate(c)[i]);
            (state, newest[i + lag])
        };
        let mut products = SMatrix::<f64, DIMENSION, DIMENSION>::zeros();
        let mut target = SVector::<f64, DIMENSION>::zeros();
        for (state, next) in (0..rows).map(row) {
            products += state * state.transpose();
            target += state * next;
        }
        // A sine spans only two directions: the ridge regularises the others.
        let ridge = 1e-10 * products.trace();
        products += SMatrix::identity() * ridge;
        let linear_map = products.cholesky().map(|factors| factors.solve(&target));
        let linear_map = linear_map.unwrap_or_default();
        let residuals = (0..rows)
            .map(row)
            .map(|(state, next)| (next - state.dot(&linear_map)).powi(2));
        let linear = (residuals.sum::<f64>() / rows as f64 / power).sqrt();
        PredictionError {
            short: relative(short),
            linear,
            long: relative(long),
        }
    }

    /// [`Features::divergence`](super::features::Features): mean over the pairs of half the logarithm of
    /// the mean square difference late over that early; 0 without a pair.
    pub(super) fn divergence(&self) -> f64 {
        let (count, period) = (self.vectors.len(), PERIOD * self.lag);
        let steps = |[from, to]: [f64; 2]| -> Vec<usize> {
            let [from, to] = [from, to].map(|share| (share * count as f64) as usize);
            (from..=to.max(from + period)).step_by(self.lag).collect()
        };
        let (early, late) = (steps(EARLY), steps(LATE));
        let limit = count.saturating_sub(late[late.len() - 1]);
        let newest = self.vectors.coordinate(DIMENSION - 1);
        let floor = MIN_ERROR.powi(2) * self.power;
        let growth = |(i, near): (usize, Option<Neighbour>)| {
            let j = near?.index;
            let difference = |steps: &[usize]| {
                let square = |k: &usize| (newest[i + k] - newest[j + k]).powi(2);
                floor + steps.iter().map(square).sum::<f64>() / steps.len() as f64
            };
            Some(0.5 * (difference(&late) / difference(&early)).ln())
        };
        let nearest = self.tree.nearest_each(references(limit), period, limit);
        mean(references(limit).zip(nearest).filter_map(growth))
    }

    /// [`Features::drift`](super::features::Features): mean over the states of the logarithm of the
    /// ratio of the two distances; 0 without a pair.
    pub(super) fn drift(&self) -> f64 {
        let count = self.vectors.len();
        let floor = MIN_ERROR.powi(2) * self.power * DIMENSION as f64;
        let nearest = |separation| self.tree.nearest_each(references(count), separation, count);
        let square = |near: Option<Neighbour>| Some(near?.distance.powi(2) + floor);
        let [distant, any] = [count / DISTANT_DIVISOR, PERIOD * self.lag].map(nearest);
        let log_ratio = |(distant, any)| Some(0.5 * (square(distant)? / square(any)?).ln());
        mean(distant.into_iter().zip(any).filter_map(log_ratio))
    }
}

/// Indices of the reference states, evenly spread over `limit`.
fn references(limit: usize) -> impl Iterator<Item = usize> {
    let count = REFERENCES.min(limit);
    (0..count).map(move |r| r * limit / count)
}

/// Mean; 0 without values.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
