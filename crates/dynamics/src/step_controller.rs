//! Step control: attempt a step, compare its error with the tolerance, accept or shorten it.
//!
//! A proportional-integral (PI) controller (K. Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533–554;
//! constants of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., Section
//! II.4 and their code DOPRI5). If a step has the error ratio `e` and its predecessor had `e'`, the step
//! is multiplied by `0.9 e^-a e'^b`, limited to 0.2 to 5, with `a = 0.17` and `b = 0.04` for pairs of
//! order 5(4) ([`MethodTraits`](super::error_control::MethodTraits)). A small change of the step is not applied, because
//! an unchanged step lets the exponential methods reuse their tables.

use super::auto::Steppers;
use super::error_control::{Accuracy, StateNorm};
use super::stepper::{Law, Step, Stepper};
use super::{DynamicsError, System};

/// A step may be stretched by this factor to end at a required time. This avoids a very short remaining
/// step.
const MAX_STRETCH: f64 = 1.0 + 1e-6;

/// Interval of steps between checks for a stall, a few seconds of computation. The mean step over the interval is used
/// because single longer steps, such as implicit ones among explicit ones, do not make a stalled integration progress.
const PROGRESS_INTERVAL: u64 = 500_000;

/// Mean step relative to the maximum step below which an integration counts as stalled: a million such steps cover at most
/// ten maximum steps.
const STALL_STEP: f64 = 1e-5;

/// Control of the step, constant or by a proportional-integral controller, with the norm of the present state.
#[derive(Clone, Debug)]
pub(super) struct StepController {
    /// Tolerance; `None` for constant steps.
    pub accuracy: Option<Accuracy>,
    max_step: f64,
    /// Length of the next step, s.
    pub step: f64,
    /// Error ratio of the last accepted step.
    previous: f64,
    /// Whether the current attempt follows a rejected step.
    rejected: bool,
    /// Norm of the present state. For the quadratures, and for the first-order components of a system without modes,
    /// it is the maximum since the start.
    size: StateNorm,
    /// Whether the method takes implicit steps.
    pub implicit: bool,
    /// Steps since the last check for a stall, and the time that they cover, s.
    progress: (u64, f64),
    /// Largest error ratio of the accepted steps since it was last read; `None` without steps.
    pub largest_ratio: Option<f64>,
}

impl StepController {
    /// Minimum factor between successive steps.
    const SHRINK: f64 = 0.2;
    /// Maximum factor between successive steps.
    const GROW: f64 = 5.0;
    /// A factor within this range leaves the step unchanged: new tables would cost more than it saves.
    const KEEP: std::ops::Range<f64> = 0.95..1.15;
    /// Error ratio before the first step, and the least that counts.
    const LEAST_RATIO: f64 = 1e-4;

    /// A control whose first step is the maximum step.
    pub fn new(accuracy: Option<Accuracy>, max_step: f64, implicit: bool) -> Self {
        Self {
            accuracy,
            max_step,
            step: max_step,
            previous: Self::LEAST_RATIO,
            rejected: false,
            size: StateNorm::default(),
            implicit,
            progress: (0, 0.0),
            largest_ratio: None,
        }
    }

    /// Initialises the controller at the present state. The first step changes the state by about 1 % of its norm; if the norm
    /// or the slope is zero it is the maximum step.
    pub fn start(&mut self, stepper: &dyn Stepper, sys: &dyn System) {
        (self.step, self.previous, self.rejected) = (self.max_step, Self::LEAST_RATIO, false);
        if self.accuracy.is_some() {
            let parts = self.size.0.into_iter().zip(rate(stepper, sys).0);
            let times = parts
                .filter(|(size, rate)| *size > 0.0 && *rate > 0.0)
                .map(|(size, rate)| size / rate);
            let change = times.fold(f64::INFINITY, f64::min);
            let least = self.min_step(stepper.step().end_time);
            self.step = (0.01 * change).min(self.max_step).max(least);
        }
    }

    /// Discards the norm of the state before a start.
    pub fn forget_norm(&mut self) {
        self.size = StateNorm::default();
    }

    /// The minimum step at time `t` (s): resolvable in floating-point time, and not below 1e-10 of the
    /// maximum step.
    fn min_step(&self, t: f64) -> f64 {
        (16.0 * f64::EPSILON * t.abs()).max(1e-10 * self.max_step)
    }

    /// Limits adaptive steps (s).
    pub fn set_max_step(&mut self, max_step: f64) {
        if self.accuracy.is_some() {
            self.max_step = max_step;
            self.step = self.step.min(max_step);
        }
    }

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
            let wanted = self.step;
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
            if !ends_at_limit && self.accuracy.is_some() {
                // The actual length, which differs from the requested one by the rounding of the end time, stays bitwise
                // constant from step to step, which keeps the tables for it valid.
                self.step = end - start;
            }
            stepper.attempt(law, end);

            let size = StateNorm::of(&stepper.step().end, sys);
            let error = stepper.error(sys);
            let norms = [size, error, rate(&**stepper, sys)];
            let finite = norms.into_iter().all(StateNorm::is_finite);
            let ratio = if finite {
                self.ratio(error, start_size.max(size))
            } else {
                f64::INFINITY
            };
            if ratio <= 1.0 {
                if !ends_at_limit {
                    self.accept(ratio, gain);
                }
                let before = self.largest_ratio.unwrap_or(0.0);
                self.largest_ratio = Some(before.max(ratio));
                stepper.step_mut().stats.steps += 1;
                self.set_norm(size, sys);
                return self.check_stall(end, end - start);
            }

            stepper.step_mut().stats.rejections += 1;
            if !self.reject(start, end - start, ratio, gain) {
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

    /// The error relative to the tolerance at the given norm of the state, zero for constant steps. Values up to 1 are
    /// acceptable.
    fn ratio(&self, error: StateNorm, size: StateNorm) -> f64 {
        self.accuracy.map_or(0.0, |accuracy| {
            let parts = error.0.into_iter().zip(size.0);
            parts
                .map(|(error, size)| error / (accuracy.relative * (size + accuracy.floor)))
                .fold(0.0, f64::max)
        })
    }

    /// Updates an adaptive step after an accepted step of full length.
    fn accept(&mut self, ratio: f64, [gain, by_previous, _]: [f64; 3]) {
        if self.accuracy.is_none() {
            return;
        }
        let mut factor = (0.9 * ratio.powf(-gain) * self.previous.powf(by_previous))
            .clamp(Self::SHRINK, Self::GROW);
        if self.rejected {
            factor = factor.min(1.0);
        }
        let step = (self.step * factor).min(self.max_step);
        if !Self::KEEP.contains(&(step / self.step)) {
            self.step = step;
        }
        self.previous = ratio.max(Self::LEAST_RATIO);
        self.rejected = false;
    }

    /// Reduces an adaptive step after a rejected step of length `h` (s) from time `t` (s). The ratio may be infinite or NaN.
    /// Returns whether it can be reduced.
    fn reject(&mut self, t: f64, h: f64, ratio: f64, [_, _, gain]: [f64; 3]) -> bool {
        if self.accuracy.is_none() {
            return false;
        }
        let factor = 0.9 * ratio.powf(-gain);
        self.step = h * if factor > Self::SHRINK {
            factor
        } else {
            Self::SHRINK
        };
        self.rejected = true;
        self.step >= self.min_step(t)
    }

    /// Checks adaptive steps at intervals for a stall. The last step had length `h` (s) and ended at time `t` (s).
    fn check_stall(&mut self, t: f64, h: f64) -> Result<(), DynamicsError> {
        let (steps, covered) = &mut self.progress;
        *steps += 1;
        *covered += h;
        if *steps < PROGRESS_INTERVAL {
            return Ok(());
        }
        let (steps, covered) = std::mem::take(&mut self.progress);
        let mean = covered / steps as f64;
        if self.accuracy.is_none() || mean >= STALL_STEP * self.max_step {
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
fn rate(stepper: &dyn Stepper, sys: &dyn System) -> StateNorm {
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
