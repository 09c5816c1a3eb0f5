//! The front: states at the times asked for, whatever the steps.

use super::control::{Accuracy, Control, Controller, Size};
use super::explicit::Direct;
use super::exponential::Interaction;
use super::pace::Pace;
use super::stepper::Stepper;
use super::tableau::{RK4, TSIT54};
use super::{DynamicsError, System, Tally};

/// The choice of method, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Exponential pair of order 5(4), free vibration exact: Lawson's integrating factor with the
    /// pair of Tsitouras. The default.
    Lawson54 {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// Plain embedded pair of order 5(4) of Tsitouras.
    Tsit54 {
        /// How accurate a step must be.
        accuracy: Accuracy,
        /// The longest step, s. Needing less than 1e-10 of it counts as a failure.
        max_step: f64,
    },
    /// Classical Runge–Kutta method of order 4.
    Rk4 {
        /// The step, s.
        step: f64,
    },
}

impl Method {
    /// The control of the step, with its parameters checked.
    fn control(self) -> Result<Control, DynamicsError> {
        let positive = |name, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(DynamicsError::Parameter {
                    name,
                    value,
                    allowed: "positive and finite",
                })
            }
        };
        match self {
            Self::Lawson54 { accuracy, max_step } | Self::Tsit54 { accuracy, max_step } => {
                accuracy.check()?;
                positive("the longest step", max_step)?;
                Ok(Control::Adaptive(Controller::new(accuracy, max_step)))
            }
            Self::Rk4 { step } => {
                positive("the step", step)?;
                Ok(Control::Fixed(step))
            }
        }
    }
}

/// The methods' workspaces: a tableau in a picture each.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a run has one integrator: its size does not matter"
)]
enum Engine {
    Lawson54(Stepper<Interaction, 7>),
    Tsit54(Stepper<Direct, 7>),
    Rk4(Stepper<Direct, 5>),
}

/// Does the same with whichever stepper there is.
macro_rules! with_stepper {
    ($engine:expr, $stepper:ident => $body:expr) => {
        match $engine {
            Engine::Lawson54($stepper) => $body,
            Engine::Tsit54($stepper) => $body,
            Engine::Rk4($stepper) => $body,
        }
    };
}

/// Integrates a [`System`] and gives its state at any times in rising order.
///
/// The steps are the integrator's own; samples are interpolated ([`Integrator::sample`]). Where
/// the system itself changes at a known time, [`Integrator::land`] makes a step end there and
/// [`Integrator::restart`] goes on from there with the changed system.
///
/// The system is passed to each call and must stay the same between `start` or `restart` and the
/// next of these. Nothing is allocated after [`Integrator::new`]. When a step fails, the last good
/// state is still held by [`Integrator::state`].
#[derive(Clone, Debug)]
pub struct Integrator {
    engine: Engine,
    pace: Pace,
    /// The longest step by the method's parameters, s; the linear part may allow less.
    max_step: f64,
    dim: usize,
}

impl Integrator {
    /// An integrator for systems of this one's size. It rests in the zero state at time zero until
    /// [`Integrator::start`].
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] for a parameter of the method out of its range,
    /// [`DynamicsError::Mode`] or [`DynamicsError::Size`] for a linear part that is no oscillation.
    pub fn new<Y: System + ?Sized>(method: Method, sys: &Y) -> Result<Self, DynamicsError> {
        let control = method.control()?;
        check_modes(sys)?;
        let dim = sys.dim();
        let engine = match method {
            Method::Lawson54 { .. } => Engine::Lawson54(Stepper::new(
                &TSIT54,
                Interaction::new(sys, TSIT54.nodes.len()),
                dim,
            )),
            Method::Tsit54 { .. } => Engine::Tsit54(Stepper::new(&TSIT54, Direct, dim)),
            Method::Rk4 { .. } => Engine::Rk4(Stepper::new(&RK4, Direct, dim)),
        };
        let max_step = control.step();
        let omega = sys.omega().to_vec();
        let pace = Pace {
            control,
            omega,
            size: Size::default(),
            tally: Tally::default(),
        };
        let mut integrator = Self {
            engine,
            pace,
            max_step,
            dim,
        };
        integrator.limit_step();
        Ok(integrator)
    }

    /// Starts at time `t` (s) from the state `z` (length [`System::dim`]), forgetting all before
    /// but the [`Integrator::tally`]. Costs one call.
    ///
    /// # Errors
    /// Those of [`Integrator::restart`], and [`DynamicsError::Size`] when `z` has another length,
    /// [`DynamicsError::Time`] when `t` is not finite.
    pub fn start<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        t: f64,
        z: &[f64],
    ) -> Result<(), DynamicsError> {
        check_size("the initial state", self.dim, z.len())?;
        if !t.is_finite() {
            return Err(DynamicsError::Time {
                asked: t,
                earliest: f64::MIN,
            });
        }
        with_stepper!(&mut self.engine, stepper => {
            stepper.end_time = t;
            stepper.end.copy_from_slice(z);
        });
        self.pace.size = Size::default();
        self.restart(sys)?;
        let rate = with_stepper!(&self.engine, stepper => self.pace.rate(stepper));
        if let Control::Adaptive(controller) = &mut self.pace.control {
            controller.start(t, self.pace.size, rate);
        }
        Ok(())
    }

    /// Goes on from the present time and state with a changed system of the same size, at the
    /// present length of the step. States before the present time are out of reach from now on.
    /// Costs one call.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] when the system has another size, [`DynamicsError::Mode`] when its
    /// linear part is no oscillation, [`DynamicsError::NonFinite`] when the present state or the
    /// right-hand side there is not finite.
    pub fn restart<Y: System + ?Sized>(&mut self, sys: &Y) -> Result<(), DynamicsError> {
        check_modes(sys)?;
        check_size(
            "the list of natural frequencies",
            self.pace.omega.len(),
            sys.modes(),
        )?;
        check_size("the state of the system", self.dim, sys.dim())?;
        self.pace.omega.copy_from_slice(sys.omega());
        if let Engine::Lawson54(stepper) = &mut self.engine {
            stepper.picture.reread(sys);
        }
        self.limit_step();
        with_stepper!(&mut self.engine, stepper => self.pace.refresh(stepper, sys))
    }

    /// Writes the state at time `t` (s) to `out` (length [`System::dim`]), stepping past it as
    /// needed. Times must not go back before the start of the last step.
    ///
    /// # Errors
    /// [`DynamicsError::Size`] when `out` has another length, [`DynamicsError::Time`] when `t` is
    /// out of reach, [`DynamicsError::NonFinite`] and [`DynamicsError::StepUnderflow`] when the
    /// integration cannot go on.
    pub fn sample<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        t: f64,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        check_size("the sample", self.dim, out.len())?;
        self.check_time(t)?;
        with_stepper!(&mut self.engine, stepper => {
            while stepper.end_time < t {
                self.pace.step(stepper, sys, f64::INFINITY)?;
            }
            stepper.interpolate(t, out);
        });
        Ok(())
    }

    /// Makes a step end exactly at time `t` (s): then [`Integrator::time`] is `t` and
    /// [`Integrator::state`] the state there, at the method's full order. A step that has gone past
    /// `t` is taken again, shorter; the length of the steps that follow is not affected.
    ///
    /// # Errors
    /// [`DynamicsError::Time`] when `t` is out of reach, [`DynamicsError::NonFinite`] and
    /// [`DynamicsError::StepUnderflow`] when the integration cannot go on.
    pub fn land<Y: System + ?Sized>(&mut self, sys: &Y, t: f64) -> Result<(), DynamicsError> {
        self.check_time(t)?;
        with_stepper!(&mut self.engine, stepper => {
            if stepper.end_time > t {
                self.pace.rewind(stepper);
            }
            while stepper.end_time < t {
                self.pace.step(stepper, sys, t)?;
            }
        });
        Ok(())
    }

    /// The time reached, s: the end of the last step.
    pub fn time(&self) -> f64 {
        with_stepper!(&self.engine, stepper => stepper.end_time)
    }

    /// The state at [`Integrator::time`].
    pub fn state(&self) -> &[f64] {
        with_stepper!(&self.engine, stepper => &stepper.end)
    }

    /// The length of the next full step, s.
    pub fn step_size(&self) -> f64 {
        self.pace.control.step()
    }

    /// Work done since [`Integrator::new`].
    pub fn tally(&self) -> Tally {
        self.pace.tally
    }

    /// Checks that a time is not before the last step.
    fn check_time(&self, t: f64) -> Result<(), DynamicsError> {
        let earliest = with_stepper!(&self.engine, stepper => stepper.start_time);
        if t >= earliest && t.is_finite() {
            Ok(())
        } else {
            Err(DynamicsError::Time { asked: t, earliest })
        }
    }

    /// Keeps the steps within what the parameters and the linear part allow.
    fn limit_step(&mut self) {
        if let (Engine::Lawson54(stepper), Control::Adaptive(controller)) =
            (&self.engine, &mut self.pace.control)
        {
            controller.limit(self.max_step.min(stepper.picture.longest_step()));
        }
    }
}

/// Checks that every mode of a system is an oscillation.
fn check_modes<Y: System + ?Sized>(sys: &Y) -> Result<(), DynamicsError> {
    if !sys.damping().is_empty() {
        check_size(
            "the list of damping ratios",
            sys.modes(),
            sys.damping().len(),
        )?;
    }
    for (mode, &omega) in sys.omega().iter().enumerate() {
        let damping = sys.damping().get(mode).copied().unwrap_or(0.0);
        if !(omega >= 0.0 && omega.is_finite() && damping.abs() < 1.0) {
            return Err(DynamicsError::Mode {
                mode,
                omega,
                damping,
            });
        }
    }
    Ok(())
}

/// Checks the length of something.
fn check_size(what: &'static str, expected: usize, found: usize) -> Result<(), DynamicsError> {
    if expected == found {
        Ok(())
    } else {
        Err(DynamicsError::Size {
            what,
            expected,
            found,
        })
    }
}
