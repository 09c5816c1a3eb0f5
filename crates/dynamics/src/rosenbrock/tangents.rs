//! Tangent vectors along a step of the implicit method.
//!
//! The derivative of the numerical map would require the derivative of the Jacobian. Instead, a singly
//! diagonally implicit method of order 4 propagates the vectors along the dense output of the step. They
//! give the derivative of the flow to the order of the method, not that of the numerical map. The method
//! damps stiff directions, as the flow does, but at a different rate. Strongly negative exponents are
//! therefore underestimated in magnitude.

use super::Rosenbrock;
use crate::runge_kutta::accumulate;
use crate::stepper::{Stepper, differentiable};
use crate::tangents::TangentBlock;
use crate::{SolverStats, System};

// Coefficients of the method: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
// Table IV.6.5.

pub(super) const STAGES: usize = 5;

const GAMMA: f64 = 0.25;

const NODES: [f64; STAGES] = [0.25, 0.75, 0.55, 0.5, 1.0];

/// Weights below the diagonal. The last stage is the solution.
const WEIGHTS: [&[f64]; STAGES] = [
    &[],
    &[0.5],
    &[17.0 / 50.0, -1.0 / 25.0],
    &[371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0],
    &[25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];

impl Rosenbrock {
    /// Propagates vectors from the start of the step to its end, shortened or not.
    pub(super) fn propagate_along_dense_output(
        &mut self,
        sys: &dyn System,
        status: Option<&[u8]>,
        block: &mut TangentBlock,
        stats: &mut SolverStats,
    ) {
        let (start, end) = (self.step.start_time, self.step.end_time);
        let h = end - start;
        let shift = 1.0 / (GAMMA * h);
        let mut state = std::mem::take(&mut self.state);
        for stage in 0..STAGES {
            let t = if stage == STAGES - 1 {
                end
            } else {
                start + NODES[stage] * h
            };
            self.interpolate(t, &mut state);
            let out = &mut self.slope[sys.modes()..];
            differentiable(sys).force_recorded(status, t, &state, out, &mut self.between);
            self.resolvent
                .update_jacobian(sys, status, &mut self.between);
            self.resolvent.factor(shift);
            block.stage.copy_from_slice(&block.start);
            if stage > 0 {
                accumulate(&mut block.stage, h, &block.slopes, WEIGHTS[stage]);
            }
            for (y, x) in block.end.iter_mut().zip(&block.stage) {
                *y = shift * x;
            }
            self.resolvent.solve(&mut block.end, block.width);
            let numbers = block.end.len();
            let slopes = &mut block.slopes[stage * numbers..][..numbers];
            for ((slope, y), x) in slopes.iter_mut().zip(&block.end).zip(&block.stage) {
                *slope = shift * (y - x);
            }
        }
        self.state = state;
        stats.rhs_evals += STAGES as u64;
        stats.jacobians += STAGES as u64;
    }
}
