//! Numerical integration of oscillators with nonlinear, non-smooth forces. Independent of the joint
//! model.
//!
//! A [`System`] supplies its natural frequencies and the nonlinear force on its modes. An [`Integrator`]
//! computes the state at requested times and chooses its own time steps.
//!
//! An explicit Runge–Kutta method combines two independent choices:
//!
//! * a *tableau*: the 5(4) pair of Tsitouras, the 8(5, 3) method of Dormand and Prince, or the classical
//!   method of order 4;
//! * a *form*: the coordinates to which the tableau is applied. The plain form integrates the state. The
//!   integrating-factor (Lawson) form integrates coordinates from which the linear free vibration has
//!   been removed exactly. Without a force its step is unlimited. A force turns in these coordinates as fast as the
//!   modes that it drives, and this limits the step: a constant force is not integrated exactly, and a fixed point is
//!   kept to the tolerance only. Subtract the force at the equilibrium.
//!
//! A linearly implicit method is available for stiff phases, for example when sliding friction changes
//! to sticking. It needs the derivative of the force ([`System::differentiable`]).
//!
//! | [`Method`] | composition | step | order | order of dense output |
//! |---|---|---|---|---|
//! | [`MethodName::Lawson54`] (default) | Tsitouras 5(4), integrating factor | adaptive | 5 | 4 |
//! | [`MethodName::Lawson853`] | Dormand and Prince 8(5, 3), integrating factor | adaptive | 8 | 7, with three more evaluations |
//! | [`MethodName::Tsit5`] | Tsitouras 5(4), plain | adaptive | 5 | 4 |
//! | [`MethodName::Dop853`] | Dormand and Prince 8(5, 3), plain | adaptive | 8 | 7, with three more evaluations |
//! | [`MethodName::Rodas5P`] | linearly implicit, Steinebach | adaptive | 5 | 4 |
//! | [`MethodName::Auto`] | Lawson54, and Rodas5P while the system is stiff | adaptive | 5 | 4 |
//! | [`MethodName::Rk4`] | classical, plain | fixed | 4 | 4 in value (cubic Hermite) |
//!
//! Integration runs forward in time only. All methods support event location, tangent vectors and a
//! perturbed trajectory. Tangent vectors pass through the stages of each step: they follow the numerical map.
//!
//! The orders are those of the global error on a smooth problem. Contact forces have kinks; impacts and
//! dry friction have jumps. Two treatments are available:
//!
//! * *Integration through the kinks* (default): the law is evaluated at every stage. Steps cross the
//!   kinks, and the error estimate shortens a step where a kink matters. The order drops at a kink, which
//!   costs little at relative errors above about 1e-6. The steps of an 8th-order method are long enough to
//!   miss a contact that is shorter than the distance between its stages.
//! * *Event location* ([`Integrator::with_events`], for a system with [`Switching`]): the law is frozen
//!   during a step, and the step ends where a guard falls through zero. Kinks and jumps then do not
//!   reduce the order. The zero is located on the dense output. An event costs one force evaluation and the
//!   discarded part of the step.
//!
//! # Reproducibility
//!
//! The same build on the same machine returns the same bits, however the motion is sampled. On machines with other
//! instruction sets results agree to rounding, which a chaotic motion amplifies: a force may use fused multiply-adds,
//! and sums in vectors of any length.
//!
//! # Example
//!
//! One oscillator with a hardening spring, `q'' + 4 q = -q^3`, sampled every 0.1 s:
//!
//! ```
//! use squeakscope_dynamics::{Accuracy, Integrator, MethodName, System};
//!
//! struct Duffing;
//!
//! impl System for Duffing {
//!     fn omega(&self) -> &[f64] {
//!         &[2.0]
//!     }
//!     fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
//!         out[0] = -z[0].powi(3);
//!     }
//!     fn is_autonomous(&self) -> bool {
//!         true
//!     }
//! }
//!
//! let method = MethodName::Lawson54.with(Accuracy::relative(1e-8), 1.0);
//! let mut integrator = Integrator::new(method, &Duffing)?;
//! integrator.start(0.0, &[1.0, 0.0])?;
//! let mut z = [0.0; 2];
//! for k in 0..100 {
//!     integrator.sample(0.1 * f64::from(k), &mut z)?;
//!     let energy = 0.5 * z[1].powi(2) + 2.0 * z[0].powi(2) + 0.25 * z[0].powi(4);
//!     assert!((energy - 2.25).abs() < 1e-6);
//! }
//! # Ok::<(), squeakscope_dynamics::DynamicsError>(())
//! ```
//!
//! A system may also be made of closures ([`system()`], [`piecewise_system`]); derivatives are then central differences.

#![cfg_attr(
    test,
    allow(
        clippy::too_many_lines,
        reason = "a test that reads from top to bottom is easier to follow than one split into helpers"
    )
)]

mod auto;
pub mod continuation;
pub mod equilibrium;
mod error;
mod error_control;
mod events;
mod integrating_factor;
mod integrator;
mod lyapunov;
mod normal_form;
mod own;
mod root_bracket;
mod rosenbrock;
mod runge_kutta;
mod simd;
mod stats;
mod step_controller;
mod stepper;
mod switching;
mod system;
mod tableau;
mod tangents;
mod trigonometry;

pub use error::{DynamicsError, Stopped};
pub use error_control::{Accuracy, max_rk4_step};
pub use integrator::{Integrator, Method, MethodName};
pub use lyapunov::{
    Attractor, Exponent, LyapunovSpectrum, MIN_PERIODS_FOR_ZERO, Motion, Sign, student,
};
pub use own::{OwnSystem, piecewise_system, system};
pub use root_bracket::RootBracket;
pub use simd::vectorised;
pub use stats::{ErrorEstimate, SolverStats};
pub use switching::Switching;
pub use system::{Differentiable, System, central_difference};
