//! Second and third derivatives of a law at an equilibrium, as differences of its exact tangent product.
//!
//! With the Jacobian `J`, the multilinear forms of the Taylor series are `B(u, u) = dJ(z + e u)/de . u` and
//! `C(u, u, u) = d^2 J(z + e u)/de^2 . u`, both at `e = 0`. The differences are central and extrapolated once
//! (Richardson), so that their truncation error is of fourth order in the step. The step doubles from far below the
//! optimum until truncation exceeds rounding: the change under halving of the step is the error estimate, and the
//! step with the smallest change is chosen.

use super::Linearised;
use crate::normal_form::RealVector;
use crate::{Differentiable, System};

/// First and last power of two of the steps, in the scaled coordinates.
const POWERS: std::ops::Range<i32> = -60..40;
/// Rounding error of a tangent product relative to its size.
const ROUNDING: f64 = 2.0 * f64::EPSILON;
/// The search ends where the error exceeds the smallest by this factor.
const PAST_OPTIMUM: f64 = 1e4;

/// Derivatives by the tangent product next to an equilibrium, in scaled coordinates.
pub(super) struct TangentDerivatives<'a> {
    law: &'a dyn Differentiable,
    linearised: &'a Linearised,
    record: Vec<f64>,
    force: Vec<f64>,
    /// Whether half of the best step is used: the difference is the error.
    pub finer: bool,
}

impl<'a> TangentDerivatives<'a> {
    /// Those of a system that was linearised. `None` if the system has no derivative.
    pub fn new(system: &'a dyn System, linearised: &'a Linearised) -> Option<Self> {
        let law = system.differentiable()?;
        Some(Self {
            record: vec![0.0; law.record_len()],
            force: vec![0.0; law.dim() - law.modes()],
            law,
            linearised,
            finer: false,
        })
    }

    /// `J(z + step u) u`, without the linear part, which has no further derivatives.
    fn at(&mut self, direction: &RealVector, step: f64) -> RealVector {
        let Linearised {
            state,
            status,
            scale,
            ..
        } = self.linearised;
        let (dim, m) = (scale.len(), self.law.modes());
        let mut z = vec![0.0; self.law.dim()];
        let mut vector = vec![0.0; dim];
        for i in 0..dim {
            vector[i] = direction[i] / scale[i];
            z[i] = state[i] + step * vector[i];
        }
        let status = status.as_deref();
        self.law
            .force_recorded(status, 0.0, &z, &mut self.force, &mut self.record);
        let mut out = vec![0.0; dim - m];
        self.law
            .product(status, &mut self.record, &vector, 1, &mut out);
        RealVector::from_fn(dim, |i, _| if i < m { 0.0 } else { out[i - m] * scale[i] })
    }

    /// The second and third derivatives along a direction.
    pub fn along(&mut self, direction: &RealVector) -> [RealVector; 2] {
        let centre = self.at(direction, 0.0);
        let size = centre.norm();
        let mut differences = |power: i32| {
            let step = 2f64.powi(power);
            let [up, down] = [step, -step].map(|step| self.at(direction, step));
            let first = (&up - &down) / (2.0 * step);
            [first, (up - &centre * 2.0 + down) / (step * step)]
        };
        let mut levels = [POWERS.start, POWERS.start + 1].map(&mut differences);
        // For each order the smallest error so far, with the derivative at its step and at half of it.
        let mut best: [Option<(f64, [RealVector; 2])>; 2] = [None, None];
        let mut finer: Option<[RealVector; 2]> = None;
        for power in POWERS.start + 2..POWERS.end {
            let [fine, coarse] = &levels;
            let extrapolated = [0, 1].map(|k| (&fine[k] * 4.0 - &coarse[k]) / 3.0);
            let mut is_past = finer.is_some();
            if let Some(finer) = &finer {
                for k in 0..2 {
                    // Rounding errors of the product, which differences of equal numbers do not show.
                    let step = 2f64.powi(power - 2);
                    let rounding = ROUNDING * size / step.powi(k as i32 + 1);
                    let error = (&extrapolated[k] - &finer[k]).norm() + rounding;
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
        let zero = || RealVector::zeros(direction.len());
        let finer = usize::from(self.finer);
        best.map(|best| best.map_or_else(zero, |(_, [best, half])| [best, half][finer].clone()))
    }
}
