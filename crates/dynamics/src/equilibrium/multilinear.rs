//! Second and third derivatives of a law at an equilibrium, as differences of its exact tangent product.
//!
//! With the Jacobian `J`, the multilinear forms of the Taylor series are `B(u, v) = dJ(z + e u)/de . v` and
//! `C(u, u, v) = d^2 J(z + e u)/de^2 . v`, both at `e = 0`. The differences are central and extrapolated once
//! (Richardson), so that their truncation error is of fourth order in the step. The step doubles from far below the
//! optimum until truncation exceeds rounding: the change under halving of the step is the error estimate, and the
//! step with the smallest change is chosen.

use super::Linearised;
use crate::{Differentiable, System};

/// First and last power of two of the steps, in the scaled coordinates.
const POWERS: std::ops::Range<i32> = -60..40;
/// Rounding error of a tangent product relative to its size.
const ROUNDING: f64 = 2.0 * f64::EPSILON;
/// The search ends where the error exceeds the smallest by this factor.
const PAST_OPTIMUM: f64 = 1e4;

/// A form applied to each of some vectors.
pub(super) type Forms = Vec<Vec<f64>>;

/// Derivatives of the Jacobian along a direction `u`, each applied to some vectors `v` in scaled coordinates: with the best
/// step, and with half of it. Their difference is the error.
pub(super) struct AlongDirection {
    /// `B(u, v)`.
    pub second: [Forms; 2],
    /// `C(u, u, v)`.
    pub third: [Forms; 2],
}

/// The tangent product next to an equilibrium.
pub(super) struct TangentProduct<'a> {
    law: &'a dyn Differentiable,
    linearised: &'a Linearised,
    record: Vec<f64>,
    force: Vec<f64>,
}

impl<'a> TangentProduct<'a> {
    /// The product of a system that was linearised. `None` if the system has no derivative.
    pub fn new(system: &'a dyn System, linearised: &'a Linearised) -> Option<Self> {
        let law = system.differentiable()?;
        Some(Self {
            record: vec![0.0; law.record_len()],
            force: vec![0.0; law.dim() - law.modes()],
            law,
            linearised,
        })
    }

    /// `J(z + step u) v` for each `v`, without the linear part, which has no further derivatives. All vectors are in
    /// scaled coordinates.
    fn at(&mut self, direction: &[f64], step: f64, vectors: &[&[f64]]) -> Vec<Vec<f64>> {
        let Linearised {
            state,
            status,
            scale,
            ..
        } = self.linearised;
        let (dim, m, width) = (scale.len(), self.law.modes(), vectors.len());
        let mut z = vec![0.0; self.law.dim()];
        for i in 0..dim {
            z[i] = state[i] + step * direction[i] / scale[i];
        }
        let status = status.as_deref();
        self.law
            .force_recorded(status, 0.0, &z, &mut self.force, &mut self.record);
        let mut packed = vec![0.0; dim * width];
        for (k, vector) in vectors.iter().enumerate() {
            for i in 0..dim {
                packed[i * width + k] = vector[i] / scale[i];
            }
        }
        let mut out = vec![0.0; (dim - m) * width];
        self.law
            .product(status, &mut self.record, &packed, width, &mut out);
        let product = |k: usize| {
            let upper = std::iter::repeat_n(0.0, m);
            let lower = (m..dim).map(|i| out[(i - m) * width + k] * scale[i]);
            upper.chain(lower).collect()
        };
        (0..width).map(product).collect()
    }

    /// The derivatives along a direction, applied to `vectors`.
    pub fn along(&mut self, direction: &[f64], vectors: &[&[f64]]) -> AlongDirection {
        let centre = self.at(direction, 0.0, vectors);
        let size = centre.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        let mut differences = |power: i32| {
            let step = 2f64.powi(power);
            let [up, down] = [step, -step].map(|step| self.at(direction, step, vectors));
            let first = combine(&[&up, &down], |x| (x[0] - x[1]) / (2.0 * step));
            let second = combine(&[&up, &centre, &down], |x| {
                (x[0] - 2.0 * x[1] + x[2]) / (step * step)
            });
            [first, second]
        };
        let mut levels = [POWERS.start, POWERS.start + 1].map(&mut differences);
        // For each order the smallest error so far, with the derivatives at its step and at half of it.
        let mut best: [Option<(f64, [Forms; 2])>; 2] = [None, None];
        let mut finer: Option<[Forms; 2]> = None;
        for power in POWERS.start + 2..POWERS.end {
            let [fine, coarse] = &levels;
            let extrapolated: [Forms; 2] =
                [0, 1].map(|k| combine(&[&fine[k], &coarse[k]], |x| (4.0 * x[0] - x[1]) / 3.0));
            let mut is_past = finer.is_some();
            if let Some(finer) = &finer {
                for k in 0..2 {
                    // Rounding errors of the product, which differences of equal numbers do not show.
                    let step = 2f64.powi(power - 2);
                    let rounding = ROUNDING * size / step.powi(k as i32 + 1);
                    let error = distance(&extrapolated[k], &finer[k]) + rounding;
                    let smallest = best[k].as_ref().map_or(f64::INFINITY, |best| best.0);
                    if error < smallest {
                        best[k] = Some((error, [extrapolated[k].clone(), finer[k].clone()]));
                    }
                    is_past &= error.is_nan() || error >= PAST_OPTIMUM * smallest;
                }
            }
            if is_past && best.iter().all(Option::is_some) {
                break;
            }
            finer = Some(extrapolated);
            let next = differences(power);
            let [_, coarse] = levels;
            levels = [coarse, next];
        }
        let zero = || vec![vec![0.0; direction.len()]; vectors.len()];
        let [second, third] = best.map(|best| best.map_or_else(|| [zero(), zero()], |best| best.1));
        AlongDirection { second, third }
    }
}

/// Combines corresponding numbers.
fn combine(all: &[&Vec<Vec<f64>>], of: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
    let rows = (0..all[0].len()).map(|k| {
        let numbers = (0..all[0][k].len()).map(|i| {
            let mut values = [0.0; 3];
            for (value, set) in values.iter_mut().zip(all) {
                *value = set[k][i];
            }
            of(&values[..all.len()])
        });
        numbers.collect()
    });
    rows.collect()
}

/// Euclidean distance; NaN if a number is not finite.
fn distance(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
