//! What becomes of neighbouring states, and where the nearest are.

use nalgebra::{SMatrix, SVector};

use crate::analysis::{DelayVectors, NeighbourTree, Norm};

/// Embedding dimension: that of the paper; enough for a torus of two tones, whatever its shape.
pub(super) const DIMENSION: usize = 5;

/// Lags in a turn: the lag is about a quarter of it.
pub(super) const TURN: usize = 4;

/// Turns over which states and their neighbours are followed.
const FAR: usize = 10;

/// Parts of the record after which the distance of neighbours is compared: once they have found
/// the direction in which they part, and as late as leaves enough of them.
const EARLY: [f64; 2] = [0.02, 0.05];
const LATE: [f64; 2] = [0.15, 0.3];

/// The part of the record, one over this, that is far in time.
const FAR_IN_TIME: usize = 3;

/// States whose neighbours are followed.
const REFERENCES: usize = 800;

/// Rows of the linear fit.
const ROWS: usize = 2000;

/// Errors of prediction below this come from how the states happen to lie, not from noise.
pub(super) const LEAST_ERROR: f64 = 3e-3;

/// Errors of prediction over the deviation of the signal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foretold {
    /// Whether the signal is foretold from sample to sample, as a map, rather than by quarter
    /// turns.
    pub map: bool,
    /// A quarter turn (a sample of a map) ahead, by the neighbour.
    pub near: f64,
    /// As far ahead, by a linear map.
    pub linear: f64,
    /// Ten turns (forty samples of a map) ahead, by the neighbour.
    pub far: f64,
}

/// The states of a record and their neighbours.
pub(super) struct Neighbourhood<'a> {
    tree: NeighbourTree<'a>,
    vectors: DelayVectors<'a>,
    lag: usize,
    /// Mean square of the samples about their mean.
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

    /// The errors of prediction a lag and [`FAR`] turns ahead.
    pub(super) fn foretold(&self) -> Foretold {
        let Self {
            tree,
            vectors,
            lag,
            power,
        } = self;
        let (lag, power, turn) = (*lag, *power, TURN * lag);
        let ahead = (FAR * turn).min(vectors.len() / 3).max(lag);
        let limit = vectors.len().saturating_sub(ahead).max(1);
        let newest = vectors.coordinate(DIMENSION - 1);
        // Over the last turn, so that the phase does not matter.
        let late = (0..TURN).map(|quarter| ahead.saturating_sub(quarter * lag));
        let (mut near, mut far, mut pairs) = (0.0, 0.0, 0.0);
        for i in references(limit) {
            let Some(other) = tree.nearest(i, turn, limit) else {
                continue;
            };
            let apart = |after: usize| (newest[i + after] - newest[other.index + after]).powi(2);
            near += apart(lag);
            far += late.clone().map(apart).sum::<f64>() / TURN as f64;
            pairs += 1.0;
        }
        // Two values without relation differ by twice the power.
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
        // A sine has only two directions: the ridge keeps the others quiet.
        let ridge = 1e-10 * products.trace();
        products += SMatrix::identity() * ridge;
        let map = products.cholesky().map(|factors| factors.solve(&target));
        let map = map.unwrap_or_default();
        let missed = (0..rows)
            .map(row)
            .map(|(state, next)| (next - state.dot(&map)).powi(2));
        let linear = (missed.sum::<f64>() / rows as f64 / power).sqrt();
        Foretold {
            map: false,
            near: relative(near),
            linear,
            far: relative(far),
        }
    }

    /// [`super::signs::Signs::parting`]: over the pairs, the mean of half the logarithm of the mean
    /// square difference late over that early; 0 without a pair.
    pub(super) fn parting(&self) -> f64 {
        let (count, turn) = (self.vectors.len(), TURN * self.lag);
        let steps = |[from, to]: [f64; 2]| -> Vec<usize> {
            let [from, to] = [from, to].map(|share| (share * count as f64) as usize);
            (from..=to.max(from + turn)).step_by(self.lag).collect()
        };
        let (early, late) = (steps(EARLY), steps(LATE));
        let limit = count.saturating_sub(late[late.len() - 1]);
        let newest = self.vectors.coordinate(DIMENSION - 1);
        let least = LEAST_ERROR.powi(2) * self.power;
        let growth = |i: usize| {
            let j = self.tree.nearest(i, turn, limit)?.index;
            let apart = |steps: &[usize]| {
                let square = |k: &usize| (newest[i + k] - newest[j + k]).powi(2);
                least + steps.iter().map(square).sum::<f64>() / steps.len() as f64
            };
            Some(0.5 * (apart(&late) / apart(&early)).ln())
        };
        mean(references(limit).filter_map(growth))
    }

    /// [`super::signs::Signs::wandering`]: over the states, the mean of the logarithm of the one
    /// distance over the other; 0 without a pair.
    pub(super) fn wandering(&self) -> f64 {
        let count = self.vectors.len();
        let least = LEAST_ERROR.powi(2) * self.power * DIMENSION as f64;
        let farther = |i: usize| {
            let square = |apart: usize| {
                let nearest = self.tree.nearest(i, apart, count)?;
                Some(nearest.distance.powi(2) + least)
            };
            Some(0.5 * (square(count / FAR_IN_TIME)? / square(TURN * self.lag)?).ln())
        };
        mean(references(count).filter_map(farther))
    }
}

/// The states looked at, of so many.
fn references(limit: usize) -> impl Iterator<Item = usize> {
    let count = REFERENCES.min(limit);
    (0..count).map(move |r| r * limit / count)
}

/// 0 of none.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
