//! The methods at work, one variant each.

use super::Method;
use crate::dynamics::auto::Auto;
use crate::dynamics::explicit::Direct;
use crate::dynamics::exponential::Interaction;
use crate::dynamics::rosenbrock::Rosenbrock;
use crate::dynamics::runge_kutta::RungeKutta;
use crate::dynamics::tableau::{DOP853, RK4, TSIT54};
use crate::dynamics::{DynamicsError, System};

/// Does the same with whichever stepper there is.
macro_rules! with_stepper {
    ($engine:expr, $stepper:ident => $body:expr) => {
        match $engine {
            Engine::Lawson54($stepper) => $body,
            Engine::Tsit54($stepper) => $body,
            Engine::Rk4($stepper) => $body,
            Engine::Dop853($stepper) => $body,
            Engine::Lawson853($stepper) => $body,
            Engine::Rodas5p($stepper) => $body,
            Engine::Auto($stepper) => $body,
        }
    };
}

/// The methods' workspaces: a tableau in a picture each.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a run has one integrator: its size does not matter"
)]
pub(super) enum Engine {
    Lawson54(RungeKutta<Interaction, 7>),
    Tsit54(RungeKutta<Direct, 7>),
    Rk4(RungeKutta<Direct, 5>),
    Dop853(RungeKutta<Direct, 16>),
    Lawson853(RungeKutta<Interaction, 16>),
    Rodas5p(Rosenbrock),
    Auto(Auto),
}

/// What an implicit method says to a system without a derivative.
pub(super) const LACKS_DERIVATIVE: DynamicsError = DynamicsError::Lacks {
    what: "derivative of its force",
    wish: "implicit steps (rodas5p, auto)",
};

impl Engine {
    /// The workspace of a method for a system.
    pub fn new<Y: System + ?Sized>(method: Method, sys: &Y) -> Result<Self, DynamicsError> {
        let dim = sys.dim();
        let derivative = || sys.differentiable().ok_or(LACKS_DERIVATIVE);
        let lawson54 = || {
            let picture = Interaction::new(sys, TSIT54.nodes.len());
            RungeKutta::new(&TSIT54, picture, dim)
        };
        Ok(match method {
            Method::Lawson54 { .. } => Self::Lawson54(lawson54()),
            Method::Tsit54 { .. } => Self::Tsit54(RungeKutta::new(&TSIT54, Direct, dim)),
            Method::Rk4 { .. } => Self::Rk4(RungeKutta::new(&RK4, Direct, dim)),
            Method::Dop853 { .. } => Self::Dop853(RungeKutta::new(&DOP853, Direct, dim)),
            Method::Lawson853 { .. } => {
                let picture = Interaction::new(sys, DOP853.nodes.len());
                Self::Lawson853(RungeKutta::new(&DOP853, picture, dim))
            }
            Method::Rodas5p { .. } => Self::Rodas5p(Rosenbrock::new(sys, derivative()?)),
            Method::Auto { .. } => {
                let implicit = Rosenbrock::new(sys, derivative()?);
                Self::Auto(Auto::new(lawson54(), implicit, sys.tangent_dim()))
            }
        })
    }

    /// Whether it needs the derivative of the force.
    pub fn needs_derivative(&self) -> bool {
        matches!(self, Self::Rodas5p(_) | Self::Auto(_))
    }
}
