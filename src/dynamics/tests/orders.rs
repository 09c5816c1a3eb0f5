//! Exactness where it is due, and the observed orders elsewhere.

use super::super::explicit::Direct;
use super::super::exponential::Interaction;
use super::super::runge_kutta::RungeKutta;
use super::super::stepper::Stepper;
use super::super::tableau::{RK4, TSIT54};
use super::reference::extrapolated;
use super::systems::{Duffing, Free, Lorenz};
use super::*;

/// The state at `t` after `n` equal steps from `z0` at time zero.
fn equal_steps<M: Stepper, Y: System>(mut stepper: M, sys: &Y, z0: &[f64], t: f64, n: usize) -> M {
    stepper.step_mut().end.copy_from_slice(z0);
    stepper.refresh(sys, None);
    for k in 1..=n {
        stepper.follow(sys, None);
        stepper.attempt(sys, None, t * k as f64 / n as f64);
    }
    stepper
}

/// The base-2 logarithm of how much smaller the second error is.
fn order(errors: [f64; 2]) -> f64 {
    (errors[0] / errors[1]).log2()
}

#[test]
fn the_global_error_falls_at_the_methods_orders() {
    let (z0, t) = (Duffing::START, 6.0);
    let exact = extrapolated(&Duffing, &z0, t, 60);
    let finer = extrapolated(&Duffing, &z0, t, 90);
    let doubt = distance(&exact, &finer);
    let lawson = [120, 240].map(|n| {
        let stepper = RungeKutta::new(&TSIT54, Interaction::new(&Duffing, 7), 7);
        distance(
            &equal_steps(stepper, &Duffing, &z0, t, n).step().end,
            &exact,
        )
    });
    let tsit = [120, 240].map(|n| {
        distance(
            &equal_steps(RungeKutta::new(&TSIT54, Direct, 7), &Duffing, &z0, t, n)
                .step()
                .end,
            &exact,
        )
    });
    let rk4 = [800, 1600].map(|n| {
        distance(
            &equal_steps(RungeKutta::new(&RK4, Direct, 7), &Duffing, &z0, t, n)
                .step()
                .end,
            &exact,
        )
    });
    let least = lawson[1].min(tsit[1]).min(rk4[1]);
    assert!(
        doubt < 0.01 * least,
        "the reference must be far better: {doubt:e} against {least:e}"
    );
    assert!((4.7..5.5).contains(&order(lawson)), "{lawson:?}");
    assert!((4.7..5.5).contains(&order(tsit)), "{tsit:?}");
    assert!((3.8..4.3).contains(&order(rk4)), "{rk4:?}");
}

#[test]
fn first_order_systems_are_integrated_at_the_methods_orders() {
    let (z0, t) = (Lorenz::START, 1.0);
    let exact = extrapolated(&Lorenz, &z0, t, 100);
    let tsit = [400, 800].map(|n| {
        distance(
            &equal_steps(RungeKutta::new(&TSIT54, Direct, 3), &Lorenz, &z0, t, n)
                .step()
                .end,
            &exact,
        )
    });
    let rk4 = [800, 1600].map(|n| {
        distance(
            &equal_steps(RungeKutta::new(&RK4, Direct, 3), &Lorenz, &z0, t, n)
                .step()
                .end,
            &exact,
        )
    });
    assert!((4.6..5.6).contains(&order(tsit)), "{tsit:?}");
    assert!((3.7..4.4).contains(&order(rk4)), "{rk4:?}");
}

#[test]
fn without_modes_the_two_pairs_are_the_same_method() {
    let [lawson, tsit, _] = all_methods(1e-7, 0.1, 1e-3);
    let (lawson, tsit) = (
        run(lawson, &Lorenz, &Lorenz::START, 5.0),
        run(tsit, &Lorenz, &Lorenz::START, 5.0),
    );
    assert_eq!(lawson.state(), tsit.state());
    assert_eq!(lawson.tally(), tsit.tally());
}

/// The largest error of the dense output within one step of length `h`.
fn dense_error<M: Stepper, Y: System>(stepper: M, sys: &Y, z0: &[f64], h: f64) -> f64 {
    let mut stepper = equal_steps(stepper, sys, z0, h, 1);
    stepper.densify(sys, None);
    let mut z = z0.to_vec();
    (1..10).fold(0.0, |worst, k| {
        let t = 0.1 * f64::from(k) * h;
        stepper.interpolate(t, &mut z);
        f64::max(worst, distance(&z, &extrapolated(sys, z0, t, 2)))
    })
}

#[test]
fn the_dense_outputs_local_error_is_one_order_above_its_order() {
    let z0 = Duffing::START;
    let steps = [0.02, 0.01];
    let lawson = steps.map(|h| {
        dense_error(
            RungeKutta::new(&TSIT54, Interaction::new(&Duffing, 7), 7),
            &Duffing,
            &z0,
            h,
        )
    });
    let tsit = steps.map(|h| dense_error(RungeKutta::new(&TSIT54, Direct, 7), &Duffing, &z0, h));
    let rk4 = steps.map(|h| dense_error(RungeKutta::new(&RK4, Direct, 7), &Duffing, &z0, h));
    assert!((4.7..5.4).contains(&order(lawson)), "{lawson:?}");
    assert!((4.7..5.4).contains(&order(tsit)), "{tsit:?}");
    assert!((3.7..4.3).contains(&order(rk4)), "{rk4:?}");
}

#[test]
fn dense_output_meets_both_ends_of_a_step() {
    let stepper = RungeKutta::new(&TSIT54, Interaction::new(&Duffing, 7), 7);
    let mut stepper = equal_steps(stepper, &Duffing, &Duffing::START, 0.2, 1);
    let mut z = [0.0; 7];
    stepper.interpolate(0.0, &mut z);
    assert_eq!(z, Duffing::START);
    stepper.interpolate(0.2, &mut z);
    assert_eq!(z, stepper.step().end[..]);
    stepper.interpolate(0.2 * (1.0 - 1e-15), &mut z);
    assert!(distance(&z, &stepper.step().end) < 1e-14);
}

#[test]
fn lawson_takes_free_vibration_exactly_at_huge_steps() {
    let free = Free {
        omega: vec![3.0, 41.0, 7.5, 0.0, 19.0],
        damping: vec![0.0, 1e-4, 0.02, 0.0, 0.999],
    };
    let z0 = [1.0, 0.5, -2.0, 0.3, 0.7, -0.2, 4.0, 3.0, 1e-3, -5.0];
    let method = Method::Lawson54 {
        accuracy: Accuracy::relative(1e-9),
        max_step: 250.0,
    };
    let mut integrator = Integrator::new(method, &free).unwrap();
    integrator.start(&free, 0.0, &z0).unwrap();
    let mut z = [0.0; 10];
    for k in 0..=200 {
        let t = 2.5 * f64::from(k);
        integrator.sample(&free, t, &mut z).unwrap();
        // The phase omega t is itself only known to its rounding, about 41 * 500 * 1e-16.
        assert!(
            distance(&z, &free.exact(&z0, t)) < 1e-9,
            "t = {t}: {z:?} {:?}",
            free.exact(&z0, t)
        );
    }
    assert_eq!(integrator.tally().rejections, 0);
    // The most damped mode allows 300 / (0.999 * 19) = 15.8.
    assert_eq!(integrator.tally().steps, 32);
}

#[test]
fn lawson_needs_far_fewer_calls_where_the_force_is_weak() {
    let [lawson, tsit, _] = all_methods(1e-8, 1.0, 1e-3);
    let weak = systems::Forced {
        omega: [10.0],
        force: |_, q: f64, _| -q.powi(3),
    };
    let (lawson, tsit) = (
        run(lawson, &weak, &[1.0, 0.0], 30.0),
        run(tsit, &weak, &[1.0, 0.0], 30.0),
    );
    let exact = extrapolated(&weak, &[1.0, 0.0], 30.0, 1000);
    assert!(2 * lawson.tally().calls < tsit.tally().calls);
    assert!(distance(lawson.state(), &exact) <= distance(tsit.state(), &exact));
}

#[test]
fn the_error_follows_the_tolerance_and_the_three_methods_meet() {
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
