//! The workspaces of all methods in one enum.

use super::{Method, MethodName};
use crate::dynamics::auto::Auto;
use crate::dynamics::integrating_factor::IntegratingFactor;
use crate::dynamics::plain::Plain;
use crate::dynamics::rosenbrock::Rosenbrock;
use crate::dynamics::runge_kutta::RungeKutta;
use crate::dynamics::tableau::{DOP853, RK4, TSIT5};
use crate::dynamics::{DynamicsError, System};

/// Evaluates the body with the active stepper, whatever its type.
macro_rules! with_stepper {
    ($engine:expr, $stepper:ident => $body:expr) => {
        match $engine {
            Engine::Lawson54($stepper) => $body,
            Engine::Tsit5($stepper) => $body,
            Engine::Rk4($stepper) => $body,
            Engine::Dop853($stepper) => $body,
            Engine::Lawson853($stepper) => $body,
            Engine::Rodas5P($stepper) => $body,
            Engine::Auto($stepper) => $body,
        }
    };
}

/// One workspace per method: a tableau and a form, or an implicit method.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a run has a single integrator, so its size is irrelevant"
)]
pub(super) enum Engine {
    Lawson54(RungeKutta<IntegratingFactor, 7>),
    Tsit5(RungeKutta<Plain, 7>),
    Rk4(RungeKutta<Plain, 5>),
    Dop853(RungeKutta<Plain, 16>),
    Lawson853(RungeKutta<IntegratingFactor, 16>),
    Rodas5P(Rosenbrock),
    Auto(Auto),
}

/// The error of an implicit method for a system without derivative.
pub(super) const NO_DERIVATIVE: DynamicsError = DynamicsError::MissingCapability {
    what: "derivative of the force",
    purpose: "implicit steps (rodas5p, auto)",
};

impl Engine {
    /// Creates the workspace of a method for a system.
    pub fn new<Y: System + ?Sized>(method: Method, sys: &Y) -> Result<Self, DynamicsError> {
        let derivative = || sys.differentiable().ok_or(NO_DERIVATIVE);
        let lawson54 = || {
            let form = IntegratingFactor::new(sys, TSIT5.nodes.len());
            RungeKutta::new(&TSIT5, form, sys)
        };
        Ok(match method.name {
            MethodName::Lawson54 => Self::Lawson54(lawson54()),
            MethodName::Tsit5 => Self::Tsit5(RungeKutta::new(&TSIT5, Plain::new(sys), sys)),
            MethodName::Rk4 => Self::Rk4(RungeKutta::new(&RK4, Plain::new(sys), sys)),
            MethodName::Dop853 => Self::Dop853(RungeKutta::new(&DOP853, Plain::new(sys), sys)),
            MethodName::Lawson853 => {
                let form = IntegratingFactor::new(sys, DOP853.nodes.len());
                Self::Lawson853(RungeKutta::new(&DOP853, form, sys))
            }
            MethodName::Rodas5P => Self::Rodas5P(Rosenbrock::new(sys, derivative()?)),
            MethodName::Auto => {
                let implicit = Rosenbrock::new(sys, derivative()?);
                Self::Auto(Auto::new(lawson54(), implicit, sys.tangent_dim()))
            }
        })
    }

    /// Whether the method needs the derivative of the force.
    pub fn needs_derivative(&self) -> bool {
        matches!(self, Self::Rodas5P(_) | Self::Auto(_))
    }
}
