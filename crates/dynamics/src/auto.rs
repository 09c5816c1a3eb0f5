//! Automatic switching between explicit and implicit steps.
//!
//! A joint is stiff while sliding friction changes to sticking: the friction force, which hardly depends
//! on the sliding velocity at high speed, then acts as a strong damper. Stability limits the step of the
//! explicit exponential pair of order 5(4), and the Rosenbrock method takes over. The explicit method
//! resumes when the implicit steps are so short that it covers the same time at the same cost.
//!
//! The criterion compares `h rho` with the stability limit of the explicit method on the negative real
//! axis. `h` is the step length and `rho` (1/s) the fastest rate of the force:
//!
//! * In explicit steps `rho` is the change of the force divided by the change of the state between the
//!   last two stages, which belong to the same time (E. Hairer, G. Wanner, Solving Ordinary Differential
//!   Equations II, 2nd ed., Springer 1996, Section IV.2). A step limited by stability comes close to the
//!   limit. [`MIN_STIFF_STEPS`] such steps with few others between them trigger the switch. This number doubles
//!   each time the implicit steps bring no gain.
//! * In implicit steps `rho` is the largest eigenvalue of the Jacobian of the force, by power iteration.
//!   [`MIN_NON_STIFF_STEPS`] steps within [`IMPLICIT_LIMIT_FACTOR`] times the limit trigger the switch. This number doubles each time
//!   the explicit steps bring no gain.
//!
//! Both estimates assume a smooth law. A law as steep as dry friction can escape them: explicit steps
//! then alternate between the two signs of the sliding velocity, far outside the narrow region where the
//! law is steep. The estimate sees the jump of the force over a velocity change that the step itself
//! produces, and `h rho` is about 1 for any step length. The progress of the two methods is therefore
//! compared, too. The mean step of the inactive method is stored. Explicit steps that are more
//! than [`IMPLICIT_COST`] times shorter than the implicit ones count as limited by stability. Implicit steps are also tried if
//! explicit steps become shorter than [`MIN_EXPLICIT_PHASE`] without a high rate.
//!
//! A switch costs one evaluation of the right-hand side. Both methods have dense output of order 4.

use std::ops::{Deref, DerefMut};

use super::rosenbrock::Rosenbrock;
use super::runge_kutta::RungeKutta;
use super::stepper::{Law, Stepper};
use super::tableau::{DOP853, RK4, TSIT5};
use super::{DynamicsError, Method, MethodName, System};

/// The error of an implicit method for a system without derivative.
pub(super) const NO_DERIVATIVE: DynamicsError = DynamicsError::MissingCapability {
    what: "derivative of the force",
    purpose: "implicit steps (rodas5p, auto)",
};

/// Stability limit `h rho` of the pair of Tsitouras on the negative real axis.
const STABILITY_LIMIT: f64 = 3.5;

/// Fraction of the stability limit above which an explicit step counts as limited by stability. Error
/// control keeps the steps well below the limit.
const STABILITY_FRACTION: f64 = 0.5;

/// Initial number of stability-limited explicit steps that trigger implicit steps.
const MIN_STIFF_STEPS: u32 = 15;

/// Maximum of that number.
const MAX_STIFF_STEPS: u32 = 480;

/// A shorter sequence of implicit steps counts as no gain.
const MIN_USEFUL_STEPS: u32 = 12;

/// Number of consecutive explicit steps below the limit that resets the count.
const RESET_STEPS: u32 = 6;

/// Multiple of the stability limit below which an implicit step is not worth its cost of about three
/// explicit steps.
const IMPLICIT_LIMIT_FACTOR: f64 = 2.5;

/// Initial number of consecutive short implicit steps that trigger explicit steps.
const MIN_NON_STIFF_STEPS: u32 = 3;

/// Maximum of that number.
const MAX_NON_STIFF_STEPS: u32 = 480;

/// Cost of an implicit step in explicit steps.
const IMPLICIT_COST: f64 = 3.0;

/// Explicit steps shorter than this divided by the highest natural frequency (rad/s) are not limited by
/// the vibration.
const MIN_EXPLICIT_PHASE: f64 = 1e-3;

/// The methods of an integration, one of which is active.
#[derive(Clone, Debug)]
pub(super) struct Steppers {
    pub explicit: RungeKutta,
    pub implicit: Option<Rosenbrock>,
    /// Whether the implicit method is active.
    pub is_implicit: bool,
    /// The choice between both methods; `None` without one.
    detector: Option<StiffnessDetector>,
    /// The prescribed choice (`true` for implicit), which overrides the detector.
    pub prescribed: Option<bool>,
}

/// Detects when the inactive method should take over.
#[derive(Clone, Copy, Debug)]
struct StiffnessDetector {
    /// `h rho` of the last attempted step until it is counted.
    last: Option<f64>,
    /// Steps in favour of the inactive method.
    hits: u32,
    /// Consecutive steps since then that are not.
    misses: u32,
    /// Steps of the active method since the last switch.
    steps: u32,
    /// Time covered by these steps, s.
    covered: f64,
    /// Mean step of the inactive method when it was last active, s; zero initially.
    inactive_mean_step: f64,
    /// Explicit steps required for a switch; doubled if implicit steps brought no gain.
    explicit_threshold: u32,
    /// Implicit steps required for a switch; doubled if explicit steps brought no gain.
    implicit_threshold: u32,
}

impl StiffnessDetector {
    fn new() -> Self {
        Self {
            last: None,
            hits: 0,
            misses: 0,
            steps: 0,
            covered: 0.0,
            inactive_mean_step: 0.0,
            explicit_threshold: MIN_STIFF_STEPS,
            implicit_threshold: MIN_NON_STIFF_STEPS,
        }
    }

    /// Resets the counts after a switch.
    fn reset(&mut self, was_implicit: bool) {
        let mean = self.covered / f64::from(self.steps.max(1));
        let (mut explicit_threshold, mut implicit_threshold) =
            (self.explicit_threshold, self.implicit_threshold);
        if was_implicit {
            // Implicit steps without a larger step per cost brought no gain.
            let further =
                self.inactive_mean_step > 0.0 && mean > IMPLICIT_COST * self.inactive_mean_step;
            explicit_threshold = if self.steps < MIN_USEFUL_STEPS && !further {
                MAX_STIFF_STEPS.min(2 * explicit_threshold)
            } else {
                MIN_STIFF_STEPS
            };
        } else if self.inactive_mean_step > 0.0 {
            implicit_threshold = if IMPLICIT_COST * mean < self.inactive_mean_step {
                MAX_NON_STIFF_STEPS.min(2 * implicit_threshold)
            } else {
                MIN_NON_STIFF_STEPS
            };
        }
        *self = Self {
            inactive_mean_step: mean,
            explicit_threshold,
            implicit_threshold,
            ..Self::new()
        };
    }

    /// Counts the last step, of length `h` (s), of a system with the highest natural frequency `omega`
    /// (rad/s). Returns whether the inactive method should take the next step.
    fn should_switch(&mut self, is_implicit: bool, h: f64, omega: f64) -> bool {
        let Some(last) = self.last.take() else {
            return false;
        };
        self.steps += 1;
        self.covered += h;
        let (hit, enough, relief) = if is_implicit {
            (
                last < IMPLICIT_LIMIT_FACTOR * STABILITY_LIMIT,
                self.implicit_threshold,
                1,
            )
        } else {
            // After a change of the law the last step has length zero.
            let short = h > 0.0
                && (IMPLICIT_COST * h < self.inactive_mean_step || h * omega < MIN_EXPLICIT_PHASE);
            (
                last > STABILITY_FRACTION * STABILITY_LIMIT || short,
                self.explicit_threshold,
                RESET_STEPS,
            )
        };
        if hit {
            self.hits += 1;
            self.misses = 0;
        } else {
            self.misses += 1;
            if self.misses >= relief {
                self.hits = 0;
            }
        }
        self.hits >= enough
    }
}

impl Steppers {
    /// The workspaces of a method for a system. The method `auto` starts with the explicit one.
    pub fn new(method: Method, sys: &dyn System) -> Result<Self, DynamicsError> {
        let (tableau, modes) = match method.name {
            MethodName::Lawson54 | MethodName::Auto => (&TSIT5, sys.modes()),
            MethodName::Lawson853 => (&DOP853, sys.modes()),
            MethodName::Tsit5 | MethodName::Rodas5P => (&TSIT5, 0),
            MethodName::Dop853 => (&DOP853, 0),
            MethodName::Rk4 => (&RK4, 0),
        };
        let implicit = method.needs_derivative().then(|| {
            let derivative = sys.differentiable().ok_or(NO_DERIVATIVE)?;
            Ok::<_, DynamicsError>(Rosenbrock::new(sys, derivative))
        });
        let chooses = method.name == MethodName::Auto;
        Ok(Self {
            explicit: RungeKutta::new(tableau, sys, modes),
            implicit: implicit.transpose()?,
            is_implicit: method.name == MethodName::Rodas5P,
            detector: chooses.then(StiffnessDetector::new),
            prescribed: None,
        })
    }

    /// Chooses the method of the next step, if there is a choice, and activates it.
    pub fn choose(&mut self, law: Law<'_>) {
        let (Some(detector), Some(implicit)) = (&mut self.detector, &mut self.implicit) else {
            return;
        };
        let (from, to) = (&mut self.explicit.step, &mut implicit.step);
        let (from, to) = if self.is_implicit {
            (to, from)
        } else {
            (from, to)
        };
        let fastest = law.sys.omega().iter().fold(0.0, |a: f64, b| a.max(*b));
        let due = detector.should_switch(self.is_implicit, from.length(), fastest);
        if self
            .prescribed
            .map_or(!due, |prescribed| prescribed == self.is_implicit)
        {
            return;
        }
        to.end_time = from.end_time;
        to.end.copy_from_slice(&from.end);
        detector.reset(self.is_implicit);
        self.is_implicit = !self.is_implicit;
        to.stats = from.stats;
        to.stats.switches += 1;
        self.reinitialise(law);
    }

    /// As [`Stepper::attempt`], with an estimate of the stiffness.
    pub fn attempt(&mut self, law: Law<'_>, end_time: f64) {
        (**self).attempt(law, end_time);
        if self.detector.is_none() {
            return;
        }
        let rate = match &self.implicit {
            Some(implicit) if self.is_implicit => implicit.step.length() * implicit.fastest_rate,
            _ => self.explicit.step.length() * self.explicit.fastest_rate(law.sys),
        };
        if let Some(detector) = &mut self.detector {
            detector.last = Some(rate);
        }
    }

    /// As [`Stepper::reject_step`].
    pub fn reject_step(&mut self) {
        if let Some(detector) = &mut self.detector {
            detector.last = None;
        }
        (**self).reject_step();
    }

    /// Enables tangent vectors; returns the number of slopes that each of them needs.
    pub fn enable_tangents(&mut self, law: Law<'_>) -> usize {
        let implicit = self.implicit.as_mut();
        let stages = implicit.map_or(0, |implicit| implicit.enable_tangents(law));
        self.explicit.enable_tangents(law).max(stages)
    }
}

/// The active method.
impl Deref for Steppers {
    type Target = dyn Stepper;

    fn deref(&self) -> &Self::Target {
        match &self.implicit {
            Some(implicit) if self.is_implicit => implicit,
            _ => &self.explicit,
        }
    }
}

impl DerefMut for Steppers {
    fn deref_mut(&mut self) -> &mut Self::Target {
        match &mut self.implicit {
            Some(implicit) if self.is_implicit => implicit,
            _ => &mut self.explicit,
        }
    }
}
