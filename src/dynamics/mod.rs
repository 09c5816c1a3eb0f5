//! Numerical integration of oscillators with nonlinear, non-smooth forces. Knows no joint.
//!
//! A [`System`] says what its natural frequencies are and what force acts on its modes; an
//! [`Integrator`] turns that into states at any times asked for, whatever its own steps.
//!
//! Explicit Runge–Kutta methods are made of two independent choices:
//!
//! * a *tableau*: the pair of Tsitouras, order 5(4), that of Dormand and Prince, order 8(5, 3), or the
//!   classical method of order 4;
//! * a *picture*: the coordinates to which the tableau is applied. In the direct picture it is the
//!   state itself. In the interaction picture the known free vibration is taken out first, so that
//!   the step is limited by how fast the *force* changes what the free vibration would have done.
//!
//! Where the law makes the system stiff, as slip does that comes to rest, a linearly implicit method
//! takes steps that the explicit ones cannot. It needs the derivative of the force
//! ([`System::differentiable`]).
//!
//! | [`Method`] | made of | step | order | dense output |
//! |---|---|---|---|---|
//! | [`Method::Lawson54`] (default) | Tsitouras 5(4), interaction | adaptive | 5 | 4 |
//! | [`Method::Lawson853`] | Dormand and Prince 8(5, 3), interaction | adaptive | 8 | 7, by three more calls |
//! | [`Method::Tsit54`] | Tsitouras 5(4), direct | adaptive | 5 | 4 |
//! | [`Method::Dop853`] | Dormand and Prince 8(5, 3), direct | adaptive | 8 | 7, by three more calls |
//! | [`Method::Rodas5p`] | linearly implicit, Steinebach | adaptive | 5 | 4 |
//! | [`Method::Auto`] | the first, and the last while it is stiff | adaptive | 5 | 4 |
//! | [`Method::Rk4`] | classical, direct | fixed | 4 | 4 in value (cubic Hermite) |
//!
//! Time goes forward. All methods stop at events, take tangent vectors along and lead a neighbour; beside
//! implicit steps the vectors follow the flow and not the steps, and strongly negative exponents come out
//! nearer to zero than they are.
//!
//! Orders are those of the global error on a smooth problem. Contact forces have kinks, impacts and
//! dry friction have jumps. There are two ways through them:
//!
//! * *Evaluate-through*, without further ado: the law is taken anew at each stage. The methods step
//!   over the kinks, and the error estimate shortens the steps where a kink matters. The order is lost,
//!   which costs little at relative errors above about 1e-6. The steps of order 8 are so long that they
//!   may go over a contact shorter than the distance of their stages, unseen.
//! * *Exact* ([`Integrator::with_events`], for a system with [`Switching`]): the law is held while a
//!   step lasts, and the step ends where a guard falls through zero. Kinks and jumps then cost no
//!   order. The fall is found on the dense output; an event costs one call of the force, and what
//!   is thrown away of the step that it cuts.
//!
//! # Example
//!
//! One oscillator with a hardening spring, `q'' + 4 q = -q^3`, sampled ten times a second:
//!
//! ```
//! use squeakscope::dynamics::{Accuracy, Integrator, Method, System};
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
//! }
//!
//! let method = Method::Lawson54 { accuracy: Accuracy::relative(1e-8), max_step: 1.0 };
//! let mut integrator = Integrator::new(method, &Duffing)?;
//! integrator.start(&Duffing, 0.0, &[1.0, 0.0])?;
//! let mut z = [0.0; 2];
//! for k in 0..100 {
//!     integrator.sample(&Duffing, 0.1 * f64::from(k), &mut z)?;
//!     let energy = 0.5 * z[1].powi(2) + 2.0 * z[0].powi(2) + 0.25 * z[0].powi(4);
//!     assert!((energy - 2.25).abs() < 1e-6);
//! }
//! # Ok::<(), squeakscope::dynamics::DynamicsError>(())
//! ```

mod auto;
mod control;
mod error;
mod events;
mod explicit;
mod exponential;
mod integrator;
mod lyapunov;
mod pace;
mod rosenbrock;
mod runge_kutta;
mod stepper;
mod switching;
mod system;
mod tableau;
mod tally;
mod tangents;
#[cfg(test)]
mod tests;
mod trigonometry;

pub use control::{Accuracy, longest_rk4_step};
pub use error::DynamicsError;
pub use integrator::{Integrator, Method, MethodName};
pub use lyapunov::{
    Attractor, Exponent, LyapunovSpectrum, Motion, PERIODS_FOR_ZERO, Sign, Stability,
};
pub use switching::Switching;
pub use system::{Differentiable, System};
pub use tally::{ErrorEstimate, Tally};
