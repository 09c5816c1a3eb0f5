//! Step acceptance: attempt a step, compare its error with the tolerance, accept or shorten it.

use super::auto::Steppers;
use super::error_control::{StateNorm, StepControl};
use super::stepper::{Law, Step, Stepper};
use super::{DynamicsError, System};

/// A step may be stretched by this factor to end at a required time. This avoids a very short remaining
/// step.
const MAX_STRETCH: f64 = 1.0 + 1e-6;

/// Interval of steps between checks for a stall, a few seconds of computation. If the mean step over the
/// interval is below [`StepControl::stall_step`], the integration ends. The
/// mean is used because single longer steps, such as implicit ones among explicit ones, do not make a
/// stalled integration progress.
const PROGRESS_INTERVAL: u64 = 500_000;

/// Step-size control, work counters and the norm of the present state.
#[derive(Clone, Debug)]
pub(super) struct StepController {
    /// Step-size control.
    pub control: StepControl,
    /// Norm of the present state. For the quadratures, and for the first-order components of a system without modes,
    /// it is the maximum since the start.
    pub size: StateNorm,
    /// Whether the method takes implicit steps.
    pub implicit: bool,
    /// Progress since the last check for a stall.
    pub progress: Progress,
    /// Largest error ratio of the accepted steps since it was last read; `None` without steps.
    pub largest_ratio: Option<f64>,
}

/// Steps and time since the last check for a stall.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress {
    steps: u64,
    /// Time covered by these steps, s.
    covered: f64,
}

impl StepController {
    /// Evaluates the right-hand side at the present state, from which the next step starts.
    pub fn reinitialise(
        &mut self,
        stepper: &mut dyn Stepper,
        law: Law<'_>,
    ) -> Result<(), DynamicsError> {
        stepper.reinitialise(law);
        let sys = law.sys;
        let size = StateNorm::of(&stepper.step().end, sys);
        if !(size.is_finite() && rate(stepper, sys).is_finite()) {
            return Err(non_finite(stepper, sys, stepper.step().end_time));
        }
        self.set_norm(size, sys);
        Ok(())
    }

    /// Takes one step from the present state, which ends at `limit` (s) at the latest. The status, if
    /// any, is frozen.
    pub fn step(
        &mut self,
        stepper: &mut Steppers,
        law: Law<'_>,
        limit: f64,
    ) -> Result<(), DynamicsError> {
        stepper.choose(law);
        let sys = law.sys;
        stepper.begin_step();
        let (start, gain) = (stepper.step().start_time, stepper.traits().gain);
        let start_size = self.size;
        loop {
            let wanted = self.control.step;
            let ends_at_limit = limit - start <= wanted * MAX_STRETCH;
            let end = if ends_at_limit { limit } else { start + wanted };
            if end <= start {
                // Only a fixed step can be this short: the controller enforces a minimum step.
                let allowed = "long enough to change the floating-point time";
                return Err(DynamicsError::Parameter {
                    name: "the step",
                    value: wanted,
                    allowed,
                });
            }
            if !ends_at_limit {
                self.control.set_actual_step(end - start);
            }
            stepper.attempt(law, end);

            let size = StateNorm::of(&stepper.step().end, sys);
            let error = stepper.error(sys);
            let norms = [size, error, rate(&**stepper, sys)];
            let finite = norms.into_iter().all(StateNorm::is_finite);
            let ratio = if finite {
                self.control.ratio(error, start_size.max(size))
            } else {
                f64::INFINITY
            };
            if ratio <= 1.0 {
                if !ends_at_limit {
                    self.control.accept(ratio, gain);
                }
                let before = self.largest_ratio.unwrap_or(0.0);
                self.largest_ratio = Some(before.max(ratio));
                stepper.step_mut().stats.steps += 1;
                self.set_norm(size, sys);
                return self.check_stall(end, end - start);
            }

            stepper.step_mut().stats.rejections += 1;
            if !self.control.reject(start, end - start, ratio, gain) {
                let failure = if finite {
                    DynamicsError::StepUnderflow {
                        time: start,
                        step: end - start,
                        error_ratio: ratio,
                        implicit: self.implicit,
                    }
                } else {
                    non_finite(&**stepper, sys, start)
                };
                stepper.reject_step();
                return Err(failure);
            }
        }
    }

    /// Checks at intervals whether the integration has stalled. The last step had length `h` (s) and
    /// ended at time `t` (s).
    fn check_stall(&mut self, t: f64, h: f64) -> Result<(), DynamicsError> {
        self.progress.steps += 1;
        self.progress.covered += h;
        if self.progress.steps < PROGRESS_INTERVAL {
            return Ok(());
        }
        let Progress { steps, covered } = std::mem::take(&mut self.progress);
        let mean = covered / steps as f64;
        if mean >= self.control.stall_step() {
            return Ok(());
        }
        Err(DynamicsError::Stalled {
            time: t,
            step: mean,
            steps,
            implicit: self.implicit,
        })
    }

    /// Reverts the last step.
    pub fn reject_step(&mut self, stepper: &mut Steppers, sys: &dyn System) {
        stepper.reject_step();
        self.update_norm(&**stepper, sys);
    }

    /// Updates the norm after the state has changed without a step.
    pub fn update_norm(&mut self, stepper: &dyn Stepper, sys: &dyn System) {
        self.set_norm(StateNorm::of(&stepper.step().end, sys), sys);
    }

    /// Stores the norm of an accepted state.
    fn set_norm(&mut self, size: StateNorm, sys: &dyn System) {
        let [vibration, mut first_order, _] = size.0;
        let [_, largest, quadratures] = self.size.max(size).0;
        if sys.modes() == 0 {
            first_order = largest;
        }
        self.size = StateNorm([vibration, first_order, quadratures]);
    }
}

/// Norm of the slope at the present state.
pub(super) fn rate(stepper: &dyn Stepper, sys: &dyn System) -> StateNorm {
    StateNorm::of(&stepper.step().end_slope, sys)
}

/// The error for a step with a non-finite number.
fn non_finite(stepper: &dyn Stepper, sys: &dyn System, last_good_time: f64) -> DynamicsError {
    let step = stepper.step();
    let worst = |values: &[f64]| values.iter().position(|x| !x.is_finite());
    let component = worst(&step.end)
        .or_else(|| worst(&step.end_slope))
        .or_else(|| worst(&step.error))
        // All finite, but their sum overflows.
        .or_else(|| step.end.iter().position(|x| x.abs() > 1e-4 * f64::MAX))
        .unwrap_or(0);
    let is_start_finite = worst(&step.start).is_none();
    DynamicsError::NonFinite {
        time: step.end_time,
        last_good_time,
        component,
        modes: sys.modes(),
        part: is_start_finite
            .then(|| non_finite_part(step, sys))
            .flatten(),
        last_good_state: if is_start_finite {
            step.start.clone()
        } else {
            Vec::new()
        },
    }
}

/// Finds the part of the system that causes a non-finite step from a finite state. The stages of that
/// step are already non-finite, so the search samples states along the slope of the finite state.
fn non_finite_part(step: &Step, sys: &dyn System) -> Option<String> {
    let (t, h) = (step.start_time, step.length());
    let mut slope = vec![0.0; sys.dim()];
    sys.rhs(t, &step.start, &mut slope);
    // If the force at the finite state itself is not finite, the slope is unusable.
    let here = sys.non_finite_part(t, &step.start);
    here.or_else(|| {
        // A fixed step may fail before or beyond its end, so several fractions are tried.
        [0.5, 1.0, 2.0].into_iter().find_map(|share| {
            let ahead = step.start.iter().zip(&slope);
            let ahead: Vec<f64> = ahead.map(|(z, slope)| z + share * h * slope).collect();
            let is_finite = ahead.iter().all(|z| z.is_finite());
            is_finite.then(|| sys.non_finite_part(t + share * h, &ahead))?
        })
    })
}
