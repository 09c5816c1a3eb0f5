//! Tests of the integrators as a whole.

mod closed_form;
mod contact;
mod events;
mod exponents;
mod hard_cases;
mod jumps;
mod neighbours;
mod orders;
mod reference;
mod springs;
mod systems;
mod tangents;

use super::{Accuracy, Integrator, Method, System};

/// The adaptive methods at one accuracy, and the fixed one at a step of about the same accuracy.
fn all_methods(relative: f64, max_step: f64, step: f64) -> [Method; 3] {
    let accuracy = Accuracy::relative(relative);
    [
        Method::Lawson54 { accuracy, max_step },
        Method::Tsit54 { accuracy, max_step },
        Method::Rk4 { step },
    ]
}

/// The state at time `t` from `z0` at time zero, reached by a step's end.
fn run<Y: System>(method: Method, sys: &Y, z0: &[f64], t: f64) -> Integrator {
    let mut integrator = Integrator::new(method, sys).expect("valid parameters");
    integrator.start(sys, 0.0, z0).expect("finite start");
    integrator
        .land(sys, t)
        .expect("the integration goes through");
    integrator
}

/// The largest difference of two states.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .fold(0.0, |max, (a, b)| max.max((a - b).abs()))
}
