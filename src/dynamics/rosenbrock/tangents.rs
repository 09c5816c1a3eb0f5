//! Tangent vectors along a step of the implicit method.
//!
//! The derivative of the method itself would need that of the Jacobian. The vectors are taken by a
//! method of their own, along the dense output of the step: they give the derivative of the flow, to
//! the method's order, and not that of the numerical one. The method, singly diagonally implicit of
//! order 4, damps what is stiff, as the flow does: how much, it does not say, so that strongly
//! negative exponents come out nearer to zero than they are.

use super::Rosenbrock;
use super::sdirk::{GAMMA, NODES, STAGES, WEIGHTS};
use crate::dynamics::runge_kutta::accumulate;
use crate::dynamics::stepper::{Stepper, differentiable};
use crate::dynamics::tangents::Bundle;
use crate::dynamics::{System, Tally};

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
