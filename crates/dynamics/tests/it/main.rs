//! Tests of all integration methods, of equilibria and of the continuation, against closed forms and published values.

mod auto;
mod closed_form;
mod conformance;
mod contact;
mod continuation;
mod equilibrium;
mod events;
mod exponents;
mod hard_cases;
mod jumps;
mod known;
mod lawson;
mod perturbed;
mod reference;
mod springs;
mod systems;
mod tangents;

use squeakscope_dynamics::{Accuracy, Integrator, Method, MethodName, System};

/// A method and its theoretical properties.
struct Properties {
    name: &'static str,
    method: MethodName,
    /// Order of the global error on a smooth problem.
    order: f64,
    /// Order of the dense output.
    dense: f64,
    /// Longest step in the asymptotic range on problems of unit frequency, s.
    step: f64,
}

/// All methods, the adaptive ones first.
const METHODS: [Properties; 7] = [
    Properties {
        name: "lawson54",
        method: MethodName::Lawson54,
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Properties {
        name: "tsit5",
        method: MethodName::Tsit5,
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Properties {
        name: "dop853",
        method: MethodName::Dop853,
        order: 8.0,
        dense: 7.0,
        step: 0.2,
    },
    Properties {
        name: "lawson853",
        method: MethodName::Lawson853,
        order: 8.0,
        dense: 7.0,
        step: 0.2,
    },
    Properties {
        name: "rodas5p",
        method: MethodName::Rodas5P,
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Properties {
        name: "auto",
        method: MethodName::Auto,
        order: 5.0,
        dense: 4.0,
        step: 0.1,
    },
    Properties {
        name: "rk4",
        method: MethodName::Rk4,
        order: 4.0,
        dense: 3.0,
        step: 0.05,
    },
];

/// The adaptive methods at one relative tolerance.
fn adaptive_methods(relative: f64, max_step: f64) -> [Method; 6] {
    std::array::from_fn(|k| {
        METHODS[k]
            .method
            .with(Accuracy::relative(relative), max_step)
    })
}

/// The adaptive methods at one relative tolerance, and the fixed-step method at a step of similar
/// accuracy.
fn all_methods(relative: f64, max_step: f64, step: f64) -> [Method; 7] {
    let accuracy = Accuracy::relative(relative);
    METHODS.map(|properties| {
        let is_fixed = properties.method.has_fixed_step();
        (properties.method).with(accuracy, if is_fixed { step } else { max_step })
    })
}

/// All methods with constant steps, whatever the error.
fn equal_steps(step: f64) -> [Method; 7] {
    let accuracy = Accuracy {
        relative: 0.1,
        floor: 1e9,
    };
    METHODS.map(|properties| properties.method.with(accuracy, step))
}

/// Integrates from `z0` at time zero to a step that ends at time `t`.
fn run<'a, Y: System>(method: Method, sys: &'a Y, z0: &[f64], t: f64) -> Integrator<'a> {
    let mut integrator = Integrator::new(method, sys).expect("valid parameters");
    integrator.start(0.0, z0).expect("finite initial state");
    integrator
        .integrate_to(t)
        .expect("the integration succeeds");
    integrator
}

/// Largest absolute difference between two states.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .fold(0.0, |max, (a, b)| max.max((a - b).abs()))
}

/// Convergence order from the errors at successively halved steps, by linear regression.
fn fitted_order(errors: &[f64]) -> f64 {
    let middle = (errors.len() - 1) as f64 / 2.0;
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for (k, error) in errors.iter().enumerate() {
        numerator -= (k as f64 - middle) * error.log2();
        denominator += (k as f64 - middle).powi(2);
    }
    numerator / denominator
}
