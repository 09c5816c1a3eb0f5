//! Properties of the exponential methods.

use super::reference::extrapolated;
use super::systems::Free;
use super::*;

#[test]
fn lawson_is_exact_for_free_vibration_at_very_long_steps() {
    let free = Free {
        omega: vec![3.0, 41.0, 7.5, 0.0, 19.0],
        damping: vec![0.0, 1e-4, 0.02, 0.0, 0.999],
    };
    let z0 = [1.0, 0.5, -2.0, 0.3, 0.7, -0.2, 4.0, 3.0, 1e-3, -5.0];
    let [lawson, _, _, lawson8, ..] = adaptive_methods(1e-9, 250.0);
    for method in [lawson, lawson8] {
        let mut integrator = Integrator::new(method, &free).unwrap();
        integrator.start(0.0, &z0).unwrap();
        let mut z = [0.0; 10];
        for k in 0..=200 {
            let t = 2.5 * f64::from(k);
            integrator.sample(t, &mut z).unwrap();
            // The phase omega t is accurate only to its rounding, about 41 * 500 * 1e-16.
            assert!(
                distance(&z, &free.exact(&z0, t)) < 1e-9,
                "t = {t}: {z:?} {:?}",
                free.exact(&z0, t)
            );
        }
        assert_eq!(integrator.stats().rejections, 0);
        // The most damped mode limits the step to 300 / (0.999 * 19) = 15.8.
        assert_eq!(integrator.stats().steps, 32);
    }
}

/// Angles of more than 1e6 rad are those of the standard library.
#[test]
fn lawson_is_exact_over_many_turns_in_a_step() {
    let free = Free {
        omega: vec![2e4],
        damping: vec![0.0],
    };
    let [lawson, ..] = adaptive_methods(1e-9, 250.0);
    let integrator = run(lawson, &free, &[1.0, 0.0], 200.0);
    assert_eq!(integrator.stats().steps, 1);
    let exact = free.exact(&[1.0, 0.0], 200.0);
    assert!((integrator.state()[0] - exact[0]).abs() < 1e-8);
}

#[test]
fn lawson_needs_far_fewer_evaluations_for_a_weak_force() {
    let [lawson, tsit, ..] = adaptive_methods(1e-8, 1.0);
    let weak = systems::Forced {
        omega: [10.0],
        force: |_, q: f64, _| -q.powi(3),
    };
    let (lawson, tsit) = (
        run(lawson, &weak, &[1.0, 0.0], 30.0),
        run(tsit, &weak, &[1.0, 0.0], 30.0),
    );
    let exact = extrapolated(&weak, &[1.0, 0.0], 30.0, 1000);
    assert!(2 * lawson.stats().rhs_evals < tsit.stats().rhs_evals);
    assert!(distance(lawson.state(), &exact) <= distance(tsit.state(), &exact));
}
