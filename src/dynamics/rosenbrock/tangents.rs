//! Tangent vectors along a step of the implicit method.
//!
//! The derivative of the method itself would need that of the Jacobian. The vectors are taken by a
//! method of their own, along the dense output of the step: they give the derivative of the flow, to
//! the method's order, and not that of the numerical one. The method is the singly diagonally implicit
//! one of order 4 in E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer
//! 1996, Table IV.6.5, which damps what is stiff, as the flow does: how much, it does not say, so
//! that strongly negative exponents come out nearer to zero than they are.

use super::Rosenbrock;
use crate::dynamics::runge_kutta::accumulate;
use crate::dynamics::stepper::{Stepper, differentiable};
use crate::dynamics::tangents::Bundle;
use crate::dynamics::{System, Tally};

pub(super) const STAGES: usize = 5;

const GAMMA: f64 = 0.25;

const NODES: [f64; STAGES] = [0.25, 0.75, 0.55, 0.5, 1.0];

/// Weights below the diagonal. The last stage sits at the solution.
const WEIGHTS: [&[f64]; STAGES] = [
    &[],
    &[0.5],
    &[17.0 / 50.0, -1.0 / 25.0],
    &[371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0],
    &[25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];

impl Rosenbrock {
    /// Takes vectors from the start of the step to where it ends or was cut.
    pub(super) fn carry_along<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        bundle: &mut Bundle,
        tally: &mut Tally,
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
            self.resolvent.read(sys, status, &mut self.between);
            self.resolvent.factor(shift);
            bundle.stage.copy_from_slice(&bundle.start);
            if stage > 0 {
                accumulate(&mut bundle.stage, h, &bundle.slopes, WEIGHTS[stage]);
            }
            for (y, x) in bundle.end.iter_mut().zip(&bundle.stage) {
                *y = shift * x;
            }
            self.resolvent.solve(&mut bundle.end, bundle.width);
            let numbers = bundle.end.len();
            let slopes = &mut bundle.slopes[stage * numbers..][..numbers];
            for ((slope, y), x) in slopes.iter_mut().zip(&bundle.end).zip(&bundle.stage) {
                *slope = shift * (y - x);
            }
        }
        self.state = state;
        tally.calls += STAGES as u64;
        tally.jacobians += STAGES as u64;
    }
}
