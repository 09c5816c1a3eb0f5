//! Conformance tests that every integration method must pass.
//!
//! The neighbouring files on hard cases, events, jumps, tangent vectors and perturbed trajectories use
//! the same table of methods. A separate test with a counting allocator shows that a step does not
//! allocate.

use std::sync::Arc;

use super::events::{run_exact, three_springs};
use super::jumps::{BOUNCING, DAMPED, bouncing_exact, damped_exact};
use super::reference::{extrapolated, extrapolated_from, unilateral};
use super::systems::{Duffing, Lorenz};
use super::*;
use squeakscope_dynamics::{Differentiable, DynamicsError};

/// Permitted difference between the theoretical and the measured order.
const MAX_ORDER_DEFICIT: f64 = 0.35;

/// All methods with their indices.
fn methods() -> impl Iterator<Item = (usize, &'static Properties)> {
    METHODS.iter().enumerate()
}

/// Errors at successively halved steps.
fn errors<const N: usize>(k: usize, longest: f64, error: impl Fn(Method) -> f64) -> [f64; N] {
    std::array::from_fn(|n| error(equal_steps(longest / f64::from(1 << n))[k]))
}

/// Checks the order from the errors above the accuracy of the reference and the rounding.
fn check(properties: &Properties, what: &str, errors: &[f64], floor: f64, expected: f64) {
    let good = errors.iter().take_while(|error| **error > floor).count();
    let name = properties.name;
    assert!(good > 1, "{name}, {what}: {errors:?}");
    let order = fitted_order(&errors[..good]);
    assert!(
        order > expected - MAX_ORDER_DEFICIT,
        "{name}, {what}: {order:.2} by {errors:?}"
    );
    println!("{name:<10} {what:<20} {order:.2}");
}

#[test]
fn methods_have_their_order_on_a_smooth_problem() {
    let (z0, t) = (Duffing::START, 6.0);
    let exact = extrapolated(&Duffing, &z0, t, 60);
    let reference_error = distance(&exact, &extrapolated(&Duffing, &z0, t, 90));
    assert!(reference_error < 3e-13, "{reference_error:e}");
    for (k, properties) in methods() {
        let errors: [f64; 3] = errors(k, properties.step, |method| {
            distance(run(method, &Duffing, &z0, t).state(), &exact)
        });
        check(properties, "smooth", &errors, 1e-12, properties.order);
    }
}

#[test]
fn methods_have_their_order_on_a_first_order_system() {
    let (z0, t) = (Lorenz::START, 1.0);
    let exact = extrapolated(&Lorenz, &z0, t, 100);
    for (k, properties) in methods() {
        let errors: [f64; 3] = errors(k, 0.016 * properties.order * properties.step, |method| {
            distance(run(method, &Lorenz, &z0, t).state(), &exact)
        });
        check(properties, "first order", &errors, 1e-11, properties.order);
    }
}

#[test]
fn the_error_is_proportional_to_the_tolerance_for_all_methods() {
    let (z0, t) = (Duffing::START, 20.0);
    let exact = extrapolated(&Duffing, &z0, t, 300);
    for (relative, step) in [(1e-6, 2e-2), (1e-8, 6e-3), (1e-10, 2e-3), (1e-12, 6e-4)] {
        for method in all_methods(relative, 1.0, step) {
            let integrator = run(method, &Duffing, &z0, t);
            let error = distance(integrator.state(), &exact);
            assert!(error < 100.0 * relative, "{method:?}: {error:e}");
        }
    }
}

#[test]
fn kinks_cost_no_order_with_event_location_only() {
    // Sum of the errors at several times, because a single error may be small by coincidence.
    let times: [f64; 8] = std::array::from_fn(|k| 1.5 * (k + 1) as f64);
    let exact = times.map(|t| unilateral(&super::events::START, t));
    let springs = three_springs();
    for (k, properties) in methods() {
        let errors = |stops: bool| -> [f64; 4] {
            errors(k, properties.step, |method| {
                let mut integrator = Integrator::new(method, &springs).unwrap();
                if stops {
                    integrator = integrator.with_events().unwrap();
                }
                integrator.start(0.0, &super::events::START).unwrap();
                let pairs = times.iter().zip(&exact);
                let error = pairs.map(|(t, exact)| {
                    integrator.integrate_to(*t).unwrap();
                    distance(integrator.state(), exact)
                });
                error.sum()
            })
        };
        let (stopped, through) = (errors(true), errors(false));
        check(properties, "kinks", &stopped, 1e-11, properties.order);
        let order = fitted_order(&through);
        assert!(order < 3.5, "{}: {order} by {through:?}", properties.name);
        assert!(through[3] > 10.0 * stopped[3], "{through:?} {stopped:?}");
    }
}

#[test]
fn resets_cost_no_order() {
    // Sum of the errors from several initial states, because a single error may be small by coincidence.
    let end = 8.0;
    let starts: [[f64; 2]; 8] = std::array::from_fn(|k| [0.3 + 0.1 * k as f64, 0.2]);
    let exact = starts.map(|z0| bouncing_exact(z0, end));
    for (k, properties) in methods() {
        let errors: [f64; 3] = errors(k, properties.step, |method| {
            let pairs = starts.iter().zip(&exact);
            let error = pairs
                .map(|(z0, exact)| distance(run_exact(method, &BOUNCING, z0, end).state(), exact));
            error.sum()
        });
        check(properties, "resets", &errors, 1e-12, properties.order);
    }
}

#[test]
fn force_jumps_cost_no_order_with_event_location_only() {
    let (z0, end) = ([0.5, 0.0], 15.0);
    let exact = damped_exact(z0, end);
    for (k, properties) in methods() {
        let stopped: [f64; 4] = errors(k, properties.step, |method| {
            distance(run_exact(method, &DAMPED, &z0, end).state(), &exact)
        });
        check(properties, "force jumps", &stopped, 1e-12, properties.order);
        let through: [f64; 4] = errors(k, properties.step, |method| {
            distance(run(method, &DAMPED, &z0, end).state(), &exact)
        });
        let order = fitted_order(&through);
        assert!(order < 3.5, "{}: {order} by {through:?}", properties.name);
    }
}

/// The maximum does not depend on how often it is read. It is at most 1 and reaches a substantial
/// fraction of it.
#[test]
fn the_largest_error_estimate_covers_the_steps_since_it_was_read() {
    let relative = 1e-7;
    for method in all_methods(relative, 1.0, 6e-3) {
        let has_fixed_step = method.name == MethodName::Rk4;
        let mut often = started(method);
        let mut once = often.clone();
        let mut out = Duffing::START;
        let mut largest: f64 = 0.0;
        often.take_error_estimate();
        once.take_error_estimate();
        assert_eq!(
            often.take_error_estimate(),
            None,
            "{method:?}: no step since the last reading"
        );
        for k in 1..=100 {
            let t = 1.0 + 0.1 * f64::from(k);
            often.sample(t, &mut out).unwrap();
            once.sample(t, &mut out).unwrap();
            if let Some(estimate) = often.take_error_estimate() {
                largest = largest.max(estimate.ratio);
            }
        }
        let estimate = once.take_error_estimate();
        assert_eq!(estimate.is_none(), has_fixed_step, "{method:?}");
        let Some(estimate) = estimate else { continue };
        assert_eq!((estimate.ratio, estimate.tolerance), (largest, relative));
        assert!(largest > 0.3 && largest <= 1.0, "{method:?}: {largest}");
        assert_eq!(estimate.relative(), largest * relative);
    }
}

/// An integrator whose next step has full length: the first steps after a start are shorter.
fn started(method: Method) -> Integrator<'static> {
    run(method, &Duffing, &Duffing::START, 1.0)
}

#[test]
fn the_local_error_of_dense_output_is_one_order_higher_than_its_order() {
    for (k, properties) in methods() {
        let errors: [f64; 3] = errors(k, properties.step, |method| {
            let mut integrator = started(method);
            let (z0, h) = (integrator.state().to_vec(), integrator.step_size());
            let mut z = [0.0; 7];
            (1..10).fold(0.0, |worst, place| {
                let t = 1.0 + 0.1 * f64::from(place) * h;
                integrator.sample(t, &mut z).unwrap();
                let exact = extrapolated_from(&Duffing, 1.0, &z0, t, 2);
                f64::max(worst, distance(&z, &exact))
            })
        });
        check(properties, "dense", &errors, 1e-13, properties.dense + 1.0);
    }
}

#[test]
fn samples_and_slopes_are_continuous_across_steps() {
    for method in equal_steps(0.125) {
        let mut integrator = started(method);
        let mut z = [[0.0; 7]; 3];
        let close = 1e-6;
        for step in 1..20 {
            let t = 1.0 + 0.125 * f64::from(step);
            for (z, t) in z.iter_mut().zip([t - close, t, t + close]) {
                integrator.sample(t, z).unwrap();
            }
            for (c, before) in z[0].iter().enumerate() {
                let slopes = [z[1][c] - before, z[2][c] - z[1][c]].map(|x| x / close);
                let jump = (slopes[1] - slopes[0]).abs();
                // Permitted: the change of the slope over the interval and the error of its dense
                // output.
                assert!(jump < 2e-3, "{method:?} at {t}, {c}: {slopes:?}");
            }
        }
    }
}

#[test]
fn dense_output_agrees_with_both_ends_of_a_step() {
    for method in equal_steps(0.25) {
        let mut integrator = started(method);
        let (start, mut z) = (integrator.state().to_vec(), [0.0; 7]);
        integrator.sample(1.0 + 1e-15, &mut z).unwrap();
        assert!(distance(&z, &start) < 1e-14);
        integrator.sample(1.25, &mut z).unwrap();
        assert_eq!(z, integrator.state());
        integrator.sample(1.25 - 1e-15, &mut z).unwrap();
        assert!(distance(&z, integrator.state()) < 2e-13, "{method:?}");
        integrator.sample(1.0, &mut z).unwrap();
        assert_eq!(z, start[..]);
    }
}

#[test]
fn a_restart_with_the_same_system_changes_nothing() {
    // Step ends that are exactly representable, so the requested times coincide with them.
    for method in equal_steps(0.0625) {
        let mut straight = started(method);
        straight.integrate_to(8.0).unwrap();
        let mut again = started(method);
        for k in 2..=8 {
            again.integrate_to(f64::from(k)).unwrap();
            again.restart(Arc::new(&Duffing)).unwrap();
        }
        assert_eq!(straight.state(), again.state(), "{method:?}");
        assert_eq!(straight.stats().steps, again.stats().steps);
    }
    for method in adaptive_methods(1e-10, 0.5) {
        let springs = three_springs();
        let straight = run_exact(method, &springs, &super::events::START, 9.0);
        let mut again = run_exact(method, &springs, &super::events::START, 0.0);
        for k in 1..=20 {
            again.integrate_to(0.45 * f64::from(k)).unwrap();
            again.restart(Arc::new(&springs)).unwrap();
        }
        let error = distance(straight.state(), again.state());
        assert!(error < 1e-8, "{method:?}: {error:e}");
    }
}

/// A system with reversed time: its state is `[q | -q' | w]`.
struct Reversed<'a, Y>(&'a Y, Vec<f64>);

impl<Y: System> System for Reversed<'_, Y> {
    fn omega(&self) -> &[f64] {
        self.0.omega()
    }
    fn damping(&self) -> &[f64] {
        &self.1
    }
    fn first_order(&self) -> usize {
        self.0.first_order()
    }
    fn quadratures(&self) -> usize {
        self.0.quadratures()
    }
    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        let m = self.modes();
        let mut z = z.to_vec();
        z[m..2 * m].iter_mut().for_each(|v| *v = -*v);
        self.0.force(-t, &z, out);
        out[m..].iter_mut().for_each(|g| *g = -*g);
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        self.0.is_autonomous()
    }
}

impl<Y: System> Differentiable for Reversed<'_, Y> {
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let m = self.modes();
        let mut z = record.to_vec();
        z[0] = -z[0];
        z[1 + m..1 + 2 * m].iter_mut().for_each(|v| *v = -*v);
        let mut vectors = vectors.to_vec();
        let velocities = &mut vectors[m * width..2 * m * width];
        velocities.iter_mut().for_each(|v| *v = -*v);
        let derivative = self.0.differentiable().unwrap();
        derivative.product(status, &mut z, &vectors, width, out);
        out[m * width..].iter_mut().for_each(|g| *g = -*g);
    }
    fn time_derivative(&self, status: Option<&[u8]>, t: f64, z: &[f64], out: &mut [f64]) {
        let derivative = self.0.differentiable().unwrap();
        derivative.time_derivative(status, -t, z, out);
        out[..self.modes()].iter_mut().for_each(|f| *f = -*f);
    }
}

/// The integrator only integrates forward and reports an error otherwise. A time-reversed system returns
/// to the initial state with every method.
#[test]
fn a_time_reversed_system_returns_to_its_initial_state() {
    let reversed = Reversed(
        &Duffing,
        Duffing.damping().iter().map(|zeta| -zeta).collect(),
    );
    let reverse = |z: &[f64]| {
        let mut z = z.to_vec();
        z[3..6].iter_mut().for_each(|v| *v = -*v);
        z
    };
    for method in all_methods(1e-10, 0.5, 1e-3) {
        let mut forward = run(method, &Duffing, &Duffing::START, 5.0);
        assert!(matches!(
            forward.integrate_to(0.0),
            Err(DynamicsError::Time { .. })
        ));
        let mut back = Integrator::new(method, &reversed).unwrap();
        back.start(-5.0, &reverse(forward.state())).unwrap();
        back.integrate_to(0.0).unwrap();
        let error = distance(&reverse(back.state()), &Duffing::START);
        assert!(error < 1e-8, "{method:?}: {error:e}");
    }
}

#[test]
fn a_missing_derivative_is_reported_by_name() {
    struct Bare;
    impl System for Bare {
        fn omega(&self) -> &[f64] {
            &[1.0]
        }
        fn force(&self, _t: f64, _z: &[f64], out: &mut [f64]) {
            out.fill(0.0);
        }
        fn is_autonomous(&self) -> bool {
            true
        }
    }
    for properties in &METHODS {
        let method = properties.method.with(Accuracy::relative(1e-6), 0.1);
        let needs = matches!(method.name, MethodName::Rodas5P | MethodName::Auto);
        match Integrator::new(method, &Bare) {
            Ok(_) => assert!(!needs),
            Err(error) => {
                assert!(needs && matches!(error, DynamicsError::MissingCapability { .. }));
                assert!(error.to_string().contains("implicit"), "{error}");
            }
        }
    }
}

/// Values for a component of the state, from ordinary to extreme.
const EXTREME_VALUES: [f64; 10] = [
    0.0,
    -0.0,
    5e-324,
    -1e-310,
    1e-160,
    1.0,
    -1e150,
    1e300,
    f64::INFINITY,
    f64::NAN,
];

#[test]
fn extreme_states_are_integrated_or_reported_as_not_finite() {
    let springs = three_springs();
    for method in all_methods(1e-6, 0.25, 0.05) {
        for (value, component) in EXTREME_VALUES
            .iter()
            .flat_map(|x| (0..6).map(move |c| (*x, c)))
        {
            let mut start = super::events::START;
            start[component] = value;
            let mut integrator = Integrator::new(method, &springs).unwrap();
            let result = integrator
                .start(0.0, &start)
                .and_then(|()| integrator.integrate_to(2.0));
            match result {
                Ok(()) => {
                    assert!(value.is_finite());
                    assert!(integrator.state().iter().all(|x| x.is_finite()));
                }
                Err(error) => {
                    let named = matches!(error, DynamicsError::NonFinite { .. });
                    assert!(!value.is_finite() && named, "{method:?} {value}: {error:?}");
                }
            }
        }
    }
}
