//! Tests of the integrators as a whole.

mod auto;
mod closed_form;
mod conformance;
mod contact;
mod events;
mod exponents;
mod hard_cases;
mod jumps;
mod lawson;
mod neighbours;
mod reference;
mod springs;
mod systems;
mod tangents;

use super::{Accuracy, Integrator, Method, System};

/// A method and what it promises.
struct Promise {
    name: &'static str,
    method: fn(Accuracy, f64) -> Method,
    /// Order of the global error on a smooth problem.
    order: f64,
    /// Order of the dense output.
    dense: f64,
    /// The longest of the steps at which the orders show on problems of unit frequency, s.
    step: f64,
}

/// All methods: those that choose their steps, then the one that does not.
const METHODS: [Promise; 7] = [
    Promise {
        name: "lawson54",
        method: |accuracy, max_step| Method::Lawson54 { accuracy, max_step },
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Promise {
        name: "tsit54",
        method: |accuracy, max_step| Method::Tsit54 { accuracy, max_step },
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Promise {
        name: "dop853",
        method: |accuracy, max_step| Method::Dop853 { accuracy, max_step },
        order: 8.0,
        dense: 7.0,
        step: 0.2,
    },
    Promise {
        name: "lawson853",
        method: |accuracy, max_step| Method::Lawson853 { accuracy, max_step },
        order: 8.0,
        dense: 7.0,
        step: 0.2,
    },
    Promise {
        name: "rodas5p",
        method: |accuracy, max_step| Method::Rodas5p { accuracy, max_step },
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Promise {
        name: "auto",
        method: |accuracy, max_step| Method::Auto { accuracy, max_step },
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Promise {
        name: "rk4",
        method: |_, step| Method::Rk4 { step },
        order: 4.0,
        dense: 3.0,
        step: 0.05,
    },
];

/// The methods that choose their steps, at one accuracy.
fn adaptive_methods(relative: f64, max_step: f64) -> [Method; 6] {
    std::array::from_fn(|k| (METHODS[k].method)(Accuracy::relative(relative), max_step))
}

/// The adaptive methods at one accuracy, and the fixed one at a step of about the same accuracy.
fn all_methods(relative: f64, max_step: f64, step: f64) -> [Method; 7] {
    let adaptive = adaptive_methods(relative, max_step);
    std::array::from_fn(|k| adaptive.get(k).copied().unwrap_or(Method::Rk4 { step }))
}

/// The methods at steps of one length, whatever the error.
fn equal_steps(step: f64) -> [Method; 7] {
    let accuracy = Accuracy {
        relative: 0.1,
        floor: 1e9,
    };
    std::array::from_fn(|k| (METHODS[k].method)(accuracy, step))
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

/// The order by errors at steps that are halved from one to the next: of the line through all.
fn fitted_order(errors: &[f64]) -> f64 {
    let middle = (errors.len() - 1) as f64 / 2.0;
    let (mut above, mut below) = (0.0, 0.0);
    for (k, error) in errors.iter().enumerate() {
        above -= (k as f64 - middle) * error.log2();
        below += (k as f64 - middle).powi(2);
    }
    above / below
}
