//! A perturbed trajectory on the same steps as the reference trajectory.
//!
//! Two integrations of nearby states with independent step control separate because of their different
//! local errors, long before the flow separates them. On identical steps the local errors are nearly
//! identical. A difference of even one millionth of the local error then grows at the rate of the flow.

use std::collections::VecDeque;

use super::{Integrator, PerturbedTrajectory, StepEnd};
use crate::error_control::StepSizeControl;
use crate::{DynamicsError, System};

/// Maximum number of steps by which the perturbed trajectory lags behind the reference.
const MAX_LAG: usize = 64;

impl PerturbedTrajectory {
    /// A copy of the reference trajectory that starts from the state `z`.
    pub fn new(first: &Integrator, sys: &dyn System, z: &[f64]) -> Result<Self, DynamicsError> {
        let mut integrator = first.without_nearby();
        // Steps end where those of the reference trajectory end, whatever the error.
        integrator.step_controller.control = StepSizeControl::Fixed(f64::INFINITY);
        let start_time = integrator.time();
        integrator.start(sys, start_time, z)?;
        Ok(Self {
            integrator: Box::new(integrator),
            start_time,
            ends: VecDeque::with_capacity(MAX_LAG + 1),
        })
    }

    /// Stores a step of the reference trajectory that ended at `end` (s).
    pub fn push_step(
        &mut self,
        sys: &dyn System,
        end: f64,
        is_implicit: bool,
    ) -> Result<(), DynamicsError> {
        self.ends.push_back(StepEnd { end, is_implicit });
        if self.ends.len() > MAX_LAG {
            self.take_next_step(sys)?;
        }
        Ok(())
    }

    /// Writes the perturbed state at time `t` (s), which the reference trajectory has reached, to `out`.
    pub fn sample(
        &mut self,
        sys: &dyn System,
        t: f64,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        while let Some(&StepEnd { end, is_implicit }) = self.ends.front() {
            if end >= t {
                self.integrator.stepper.prescribe(is_implicit);
                self.integrator.advance_past(sys, t, end)?;
                break;
            }
            self.take_next_step(sys)?;
        }
        self.integrator.sample(sys, t, out)
    }

    /// Integrates to time `t` (s), which the reference trajectory has reached.
    pub fn advance_to(&mut self, sys: &dyn System, t: f64) -> Result<(), DynamicsError> {
        while !self.ends.is_empty() {
            self.take_next_step(sys)?;
        }
        self.integrator.integrate_to(sys, t)
    }

    fn take_next_step(&mut self, sys: &dyn System) -> Result<(), DynamicsError> {
        match self.ends.pop_front() {
            Some(StepEnd { end, is_implicit }) => {
                self.integrator.stepper.prescribe(is_implicit);
                self.integrator.integrate_to(sys, end)
            }
            None => Ok(()),
        }
    }
}
