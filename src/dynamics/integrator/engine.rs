//! The workspaces of all methods in one enum.

use super::{Method, MethodName};
use crate::dynamics::auto::Auto;
use crate::dynamics::rosenbrock::Rosenbrock;
use crate::dynamics::runge_kutta::RungeKutta;
use crate::dynamics::tableau::{DOP853, RK4, TSIT5};
use crate::dynamics::{DynamicsError, System};

/// Evaluates the body with the active stepper, whatever its type.
macro_rules! with_stepper {
    ($engine:expr, $stepper:ident => $body:expr) => {
        match $engine {
            Engine::Classical($stepper) => $body,
            Engine::Order5($stepper) => $body,
            Engine::Order8($stepper) => $body,
            Engine::Rodas5P($stepper) => $body,
            Engine::Auto($stepper) => $body,
        }
    };
}

/// One workspace per tableau and implicit method.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a run has a single integrator, so its size is irrelevant"
)]
pub(super) enum Engine {
    Classical(RungeKutta<5>),
    Order5(RungeKutta<7>),
    Order8(RungeKutta<16>),
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
        let modes = sys.modes();
        let order5 = |modes| RungeKutta::new(&TSIT5, sys, modes);
        let order8 = |modes| RungeKutta::new(&DOP853, sys, modes);
        Ok(match method.name {
            MethodName::Lawson54 => Self::Order5(order5(modes)),
            MethodName::Tsit5 => Self::Order5(order5(0)),
            MethodName::Lawson853 => Self::Order8(order8(modes)),
            MethodName::Dop853 => Self::Order8(order8(0)),
            MethodName::Rk4 => Self::Classical(RungeKutta::new(&RK4, sys, 0)),
            MethodName::Rodas5P => Self::Rodas5P(Rosenbrock::new(sys, derivative()?)),
            MethodName::Auto => {
                let implicit = Rosenbrock::new(sys, derivative()?);
                Self::Auto(Auto::new(order5(modes), implicit, sys.tangent_dim()))
            }
        })
    }

    /// Whether the method needs the derivative of the force.
    pub fn needs_derivative(&self) -> bool {
        matches!(self, Self::Rodas5P(_) | Self::Auto(_))
    }
}
