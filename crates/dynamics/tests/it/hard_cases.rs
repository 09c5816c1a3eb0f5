//! Equilibrium, extreme magnitudes, changes of the system, and failures.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::systems::{Duffing, Forced, Free, Lorenz, Unilateral, by_differences};
use super::*;
use squeakscope_dynamics::{Differentiable, DynamicsError, Stopped};

#[test]
fn an_equilibrium_stays_bitwise_unchanged() {
    for method in all_methods(1e-6, 0.25, 0.25) {
        let mut integrator = Integrator::new(method, &Unilateral).unwrap();
        integrator.start(0.0, &[0.0; 7]).unwrap();
        let mut z = [f64::NAN; 7];
        for k in 0..1000 {
            integrator.sample(0.1 * f64::from(k), &mut z).unwrap();
            assert!(z.iter().all(|x| x.to_bits() == 0), "{method:?}: {z:?}");
        }
        let stats = integrator.stats();
        assert_eq!(
            (stats.steps, stats.rejections),
            (400, 0),
            "{method:?} must take its maximum steps"
        );
    }
}

#[test]
fn growth_over_540_decades_keeps_its_relative_accuracy() {
    // q'' + q = 2 a q' grows as exp(a t); from 1e-280 to about 1e262.
    let (a, t) = (0.05, 25_000.0);
    let growing = Forced {
        omega: [1.0],
        force: |_, _, v: f64| 2.0 * a * v,
    };
    let w = (1.0 - a * a).sqrt();
    for method in &adaptive_methods(1e-10, 1.0) {
        let integrator = run(*method, &growing, &[1e-280, 0.0], t);
        let (s, c) = (w * t).sin_cos();
        let size = (a * t + 1e-280_f64.ln()).exp();
        let exact = [size * (c - a / w * s), -size * s / w];
        let error = distance(integrator.state(), &exact) / size;
        // At most 1e-10 per step times several 1e5 steps.
        assert!(error < 1e-5, "{method:?}: {error:e}");
    }
}

#[test]
fn denormal_and_very_large_initial_states_are_integrated() {
    for method in &adaptive_methods(1e-6, 0.5) {
        let tiny = run(
            *method,
            &Unilateral,
            &[5e-324, 0.0, 0.0, 0.0, -1e-310, 0.0, 0.0],
            10.0,
        );
        assert!(
            tiny.state().iter().all(|x| x.abs() < 1e-300),
            "{:?}",
            tiny.state()
        );
        assert!(tiny.stats().steps < 1000, "{:?}", tiny.stats());

        let mut start = Unilateral::START;
        start.iter_mut().for_each(|x| *x *= 1e150);
        let huge = run(*method, &Unilateral, &start, 10.0);
        assert!(
            huge.state()[..6].iter().all(|x| x.abs() < 1e152),
            "{:?}",
            huge.state()
        );
        assert!(huge.stats().steps < 2000, "{:?}", huge.stats());
    }
}

#[test]
fn results_are_bitwise_independent_of_sampling() {
    for method in all_methods(1e-7, 0.5, 1e-2) {
        let unsampled = run(method, &Unilateral, &Unilateral::START, 20.0);
        let mut sampled = run(method, &Unilateral, &Unilateral::START, 0.0);
        let mut z = [0.0; 7];
        for k in 0..=1900 {
            sampled.sample(0.01 * f64::from(k), &mut z).unwrap();
        }
        sampled.integrate_to(20.0).unwrap();
        assert_eq!(unsampled.state(), sampled.state(), "{method:?}");
        let (mut unsampled, mut sampled) = (unsampled.stats(), sampled.stats());
        // Samples may need additional evaluations.
        assert!(unsampled.rhs_evals <= sampled.rhs_evals);
        (unsampled.rhs_evals, sampled.rhs_evals) = (0, 0);
        assert_eq!(unsampled, sampled, "{method:?}");
    }
}

#[test]
fn integrate_to_ends_a_step_exactly_and_keeps_the_step_size() {
    for method in all_methods(1e-9, 0.5, 1e-2) {
        let mut integrator = run(method, &Duffing, &Duffing::START, 0.0);
        let mut z = [0.0; 7];
        for frame in 1..=50 {
            let frame_end = 0.4 * f64::from(frame);
            integrator.sample(frame_end - 1e-3, &mut z).unwrap();
            let (before, rejections) = (integrator.step_size(), integrator.stats().rejections);
            integrator.integrate_to(frame_end).unwrap();
            assert_eq!(integrator.time(), frame_end);
            integrator.sample(frame_end, &mut z).unwrap();
            assert_eq!(
                integrator.state(),
                z,
                "the state at the step end must equal the sample there"
            );
            if integrator.stats().rejections == rejections {
                assert_eq!(integrator.step_size(), before, "{method:?} at {frame_end}");
            }
            integrator.restart(Arc::new(&Duffing)).unwrap();
        }
        let error = distance(
            integrator.state(),
            &super::reference::extrapolated(&Duffing, &Duffing::START, 20.0, 300),
        );
        assert!(error < 1e-7, "{method:?}: {error:e}");
    }
}

#[test]
fn a_changed_system_continues_from_the_step_end() {
    let before = Free {
        omega: vec![3.0, 11.0],
        damping: vec![],
    };
    let after = Free {
        omega: vec![4.0, 0.5],
        damping: vec![0.1, 0.0],
    };
    let z0 = [1.0, -0.5, 0.2, 3.0];
    let (change, end) = (1.2345, 4.0);
    let exact = after.exact(&before.exact(&z0, change), end - change);
    for method in all_methods(1e-11, 0.5, 5e-4) {
        let mut integrator = Integrator::new(method, &before).unwrap();
        let mut z = [0.0; 4];
        integrator.start(0.0, &z0).unwrap();
        integrator.sample(change - 0.01, &mut z).unwrap();
        integrator.integrate_to(change).unwrap();
        integrator.restart(Arc::new(&after)).unwrap();
        integrator.sample(end, &mut z).unwrap();
        assert!(distance(&z, &exact) < 1e-8, "{method:?}");
        if matches!(method.name, MethodName::Lawson54 | MethodName::Lawson853) {
            assert!(
                distance(&z, &exact) < 1e-13,
                "free vibration must be exact across the change"
            );
        }
    }
}

#[test]
fn a_nan_force_is_reported_with_the_last_finite_state() {
    struct NotFinite;
    impl System for NotFinite {
        fn omega(&self) -> &[f64] {
            &[1.0, 2.0, 3.0]
        }
        fn force(&self, t: f64, _z: &[f64], out: &mut [f64]) {
            out.copy_from_slice(&[0.0, 0.0, if t > 1.0 { f64::NAN } else { 0.0 }]);
        }
        fn differentiable(&self) -> Option<&dyn Differentiable> {
            Some(self)
        }
        fn is_autonomous(&self) -> bool {
            // Until it fails.
            true
        }
    }
    by_differences!(NotFinite);
    for method in all_methods(1e-6, 0.3, 0.01) {
        let mut integrator = run(method, &NotFinite, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.0);
        let error = integrator.integrate_to(2.0).unwrap_err();
        let DynamicsError::NonFinite {
            time,
            last_good_time,
            component,
            ref last_good_state,
            ..
        } = error
        else {
            panic!("{error:?}")
        };
        let fixed = method.name == MethodName::Rk4;
        assert!(
            last_good_time <= 1.0 && last_good_time > if fixed { 0.98 } else { 1.0 - 1e-9 },
            "{error:?}"
        );
        assert!(time > last_good_time && time < 1.02);
        assert_eq!(
            component % 3,
            2,
            "the non-finite force acts on the last mode: {error:?}"
        );
        assert_eq!(integrator.time(), last_good_time);
        assert_eq!(integrator.state(), last_good_state);
        assert!(
            error.to_string().contains(["q3 ", "qdot3 "][component / 3]),
            "{error}"
        );
        let (q, v) = (integrator.state()[0], integrator.state()[3]);
        assert!(distance(&[q, v], &[last_good_time.cos(), -last_good_time.sin()]) < 1e-5);
        assert!(error.to_string().contains("fixed step"), "{error}");
    }
}

#[test]
fn overflow_is_reported() {
    let growing = Forced {
        omega: [1.0],
        force: |_, _, v: f64| v,
    };
    for method in all_methods(1e-4, 1.0, 0.05) {
        let mut integrator = run(method, &growing, &[1.0, 0.0], 0.0);
        let error = integrator.integrate_to(2000.0).unwrap_err();
        let DynamicsError::NonFinite { last_good_time, .. } = error else {
            panic!("{error:?}")
        };
        // exp(t / 2) overflows at t = 2 * 709.8.
        assert!((1400.0..1420.0).contains(&last_good_time), "{error:?}");
        assert!(integrator.state().iter().all(|x| x.is_finite()));
    }
}

/// A pseudo-random number between -1 and 1 from the bits of `x`.
fn noise(x: f64) -> f64 {
    let mixed = x.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64
        / (1_u64 << 52) as f64
        - 1.0
}

#[test]
fn noise_above_the_tolerance_is_an_underflow_that_a_floor_prevents() {
    let noisy = Forced {
        omega: [1.0],
        force: |_, q, _| 1e-6 * noise(q),
    };
    let start = [0.0, 1e-20];
    let mut method = MethodName::Lawson54.with(Accuracy::relative(1e-6), 0.5);
    let mut integrator = Integrator::new(method, &noisy).unwrap();
    integrator.start(1.0, &start).unwrap();
    let error = integrator.integrate_to(2.0).unwrap_err();
    assert!(
        matches!(error, DynamicsError::StepUnderflow { .. }),
        "{error:?}"
    );
    assert!(error.to_string().contains("floor"), "{error}");
    assert!(integrator.state().iter().all(|x| x.is_finite()));

    method = MethodName::Lawson54.with(
        Accuracy {
            relative: 1e-6,
            floor: 1.0,
        },
        0.5,
    );
    let bounded = run(method, &noisy, &start, 100.0);
    assert!(bounded.state().iter().all(|x| x.abs() < 1e-4));
    assert!(bounded.stats().steps < 1000, "{:?}", bounded.stats());
}

#[test]
fn a_singularity_is_not_crossed() {
    // w' = w^2 with w(0) = 1 has a pole at t = 1.
    struct Pole;
    impl System for Pole {
        fn omega(&self) -> &[f64] {
            &[]
        }
        fn first_order(&self) -> usize {
            1
        }
        fn force(&self, _t: f64, w: &[f64], out: &mut [f64]) {
            out[0] = w[0] * w[0];
        }
        fn differentiable(&self) -> Option<&dyn Differentiable> {
            Some(self)
        }
        fn is_autonomous(&self) -> bool {
            true
        }
    }
    by_differences!(Pole);
    for method in &adaptive_methods(1e-8, 0.5) {
        let mut integrator = run(*method, &Pole, &[1.0], 0.0);
        let error = integrator.integrate_to(2.0).unwrap_err();
        assert!(
            matches!(error, DynamicsError::StepUnderflow { .. }),
            "{error:?}"
        );
        assert!((integrator.time() - 1.0).abs() < 1e-6);
    }
}

/// A rapidly oscillating force limits the step of every method. The error never recommends the method in
/// use.
#[test]
fn a_stall_is_reported_with_another_method_as_remedy() {
    struct FastForcing;
    impl System for FastForcing {
        fn omega(&self) -> &[f64] {
            &[1.0]
        }
        fn force(&self, t: f64, _z: &[f64], out: &mut [f64]) {
            out[0] = 1e7 * (1e7 * t).sin();
        }
        fn differentiable(&self) -> Option<&dyn Differentiable> {
            Some(self)
        }
        fn is_autonomous(&self) -> bool {
            false
        }
    }
    by_differences!(FastForcing);
    for method in adaptive_methods(1e-6, 1.0) {
        let mut integrator = run(method, &FastForcing, &[1.0, 0.0], 0.0);
        let error = integrator.integrate_to(100.0).unwrap_err();
        let message = error.to_string();
        let DynamicsError::Stalled { step, implicit, .. } = error else {
            panic!("{error:?}");
        };
        assert!(step < 1e-5, "{step}");
        let takes_implicit = matches!(method.name, MethodName::Rodas5P | MethodName::Auto);
        assert_eq!(implicit, takes_implicit);
        assert_eq!(message.contains("rodas5p"), !implicit, "{message}");
    }
}

#[test]
fn the_stop_flag_ends_stepping_and_keeps_the_state() {
    let stop = Arc::new(AtomicBool::new(false));
    for method in all_methods(1e-6, 0.25, 0.25) {
        let mut unstopped = run(method, &Duffing, &Duffing::START, 0.0);
        let mut stopped = unstopped.clone();
        stopped.set_stop_flag(Arc::clone(&stop));
        let (mut z, mut same) = ([0.0; 7], [0.0; 7]);
        unstopped.sample(1.0, &mut same).unwrap();
        stopped.sample(1.0, &mut z).unwrap();
        assert_eq!(z, same, "{method:?}");
        stop.store(true, Ordering::Relaxed);
        let time = stopped.time();
        stopped.sample(time, &mut z).unwrap();
        let error = stopped.sample(time + 1.0, &mut z).unwrap_err();
        assert_eq!(error, DynamicsError::Stopped(Stopped));
        assert_eq!(stopped.time(), time);
        stop.store(false, Ordering::Relaxed);
        unstopped.sample(3.0, &mut same).unwrap();
        stopped.sample(3.0, &mut z).unwrap();
        assert_eq!(z, same, "{method:?}");
    }
}

#[test]
fn parameters_out_of_range_are_rejected() {
    let bad_accuracy = |relative, floor| MethodName::Tsit5.with(Accuracy { relative, floor }, 1.0);
    let methods = [
        (bad_accuracy(0.0, 1.0), "relative accuracy"),
        (bad_accuracy(f64::NAN, 1.0), "relative accuracy"),
        (bad_accuracy(0.5, 1.0), "relative accuracy"),
        (bad_accuracy(1e-6, 0.0), "floor"),
        (bad_accuracy(1e-6, f64::INFINITY), "floor"),
        (
            MethodName::Lawson54.with(Accuracy::relative(1e-6), f64::INFINITY),
            "maximum step",
        ),
        (
            MethodName::Rk4.with(Accuracy::relative(1e-6), -1e-6),
            "the step",
        ),
    ];
    // A fixed step below the resolution of the time would never finish.
    let mut integrator = Integrator::new(
        MethodName::Rk4.with(Accuracy::relative(1e-6), 1e-20),
        &Lorenz,
    )
    .unwrap();
    integrator.start(1.0, &Lorenz::START).unwrap();
    assert!(matches!(
        integrator.integrate_to(2.0),
        Err(DynamicsError::Parameter { .. })
    ));

    for (method, expected) in methods {
        let error = Integrator::new(method, &Lorenz).unwrap_err();
        assert!(
            matches!(error, DynamicsError::Parameter { .. }),
            "{method:?}"
        );
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn non_oscillating_modes_are_rejected() {
    let rejected = |omega: Vec<f64>, damping: Vec<f64>| {
        Integrator::new(all_methods(1e-6, 1.0, 1.0)[0], &Free { omega, damping }).unwrap_err()
    };
    assert!(matches!(
        rejected(vec![1.0, -2.0], vec![]),
        DynamicsError::Mode { mode: 1, .. }
    ));
    assert!(matches!(
        rejected(vec![f64::NAN], vec![]),
        DynamicsError::Mode { mode: 0, .. }
    ));
    assert!(matches!(
        rejected(vec![1.0], vec![1.0]),
        DynamicsError::Mode { mode: 0, .. }
    ));
    assert!(matches!(
        rejected(vec![1.0, 2.0], vec![0.1]),
        DynamicsError::Size {
            expected: 2,
            found: 1,
            ..
        }
    ));
}

#[test]
fn wrong_sizes_and_times_are_rejected_without_side_effects() {
    let mut integrator = run(
        all_methods(1e-6, 0.5, 0.1)[0],
        &Duffing,
        &Duffing::START,
        3.0,
    );
    let (state, stats) = (integrator.state().to_vec(), integrator.stats());
    let mut z = [0.0; 7];
    let size = |error| matches!(error, Err(DynamicsError::Size { .. }));
    let time = |error| matches!(error, Err(DynamicsError::Time { .. }));
    assert!(size(integrator.start(0.0, &[0.0; 6])));
    assert!(size(integrator.sample(4.0, &mut [0.0; 8])));
    assert!(size(integrator.restart(Arc::new(&Lorenz))));
    assert!(time(integrator.start(f64::NAN, &Duffing::START)));
    assert!(time(integrator.sample(1.0, &mut z)));
    assert!(time(integrator.sample(f64::INFINITY, &mut z)));
    assert!(time(integrator.integrate_to(1.0)));
    assert!(time(integrator.integrate_to(f64::NAN)));
    assert_eq!(
        (integrator.time(), integrator.state(), integrator.stats()),
        (3.0, &state[..], stats)
    );
}

#[test]
fn a_non_finite_initial_state_is_rejected() {
    let mut integrator = Integrator::new(all_methods(1e-6, 0.5, 0.1)[0], &Duffing).unwrap();
    let mut start = Duffing::START;
    start[4] = f64::NAN;
    let error = integrator.start(0.5, &start).unwrap_err();
    assert_eq!(
        error,
        DynamicsError::NonFinite {
            time: 0.5,
            last_good_time: 0.5,
            component: 4,
            modes: 3,
            part: None,
            last_good_state: vec![],
        }
    );
}
