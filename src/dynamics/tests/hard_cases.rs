//! Rest, extremes of size, changes of the system, and failures.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::DynamicsError;
use super::systems::{Duffing, Forced, Free, Lorenz, Unilateral, differenced};
use super::*;
use crate::dynamics::Differentiable;

#[test]
fn rest_stays_rest_to_the_last_bit() {
    for method in all_methods(1e-6, 0.25, 0.25) {
        let mut integrator = Integrator::new(method, &Unilateral).unwrap();
        integrator.start(&Unilateral, 0.0, &[0.0; 7]).unwrap();
        let mut z = [f64::NAN; 7];
        for k in 0..1000 {
            integrator
                .sample(&Unilateral, 0.1 * f64::from(k), &mut z)
                .unwrap();
            assert!(z.iter().all(|x| x.to_bits() == 0), "{method:?}: {z:?}");
        }
        let tally = integrator.tally();
        assert_eq!(
            (tally.steps, tally.rejections),
            (400, 0),
            "{method:?} must take its longest steps"
        );
    }
}

#[test]
fn growth_over_five_hundred_decades_keeps_its_relative_accuracy() {
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
        // At worst, the 1e-10 allowed in a step times several 1e5 steps.
        assert!(error < 1e-5, "{method:?}: {error:e}");
    }
}

#[test]
fn denormal_and_huge_starts_go_through() {
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
        assert!(tiny.tally().steps < 1000, "{:?}", tiny.tally());

        let mut start = Unilateral::START;
        start.iter_mut().for_each(|x| *x *= 1e150);
        let huge = run(*method, &Unilateral, &start, 10.0);
        assert!(
            huge.state()[..6].iter().all(|x| x.abs() < 1e152),
            "{:?}",
            huge.state()
        );
        assert!(huge.tally().steps < 2000, "{:?}", huge.tally());
    }
}

#[test]
fn runs_repeat_bit_for_bit_whatever_is_sampled() {
    for method in all_methods(1e-7, 0.5, 1e-2) {
        let silent = run(method, &Unilateral, &Unilateral::START, 20.0);
        let mut sampled = run(method, &Unilateral, &Unilateral::START, 0.0);
        let mut z = [0.0; 7];
        for k in 0..=1900 {
            sampled
                .sample(&Unilateral, 0.01 * f64::from(k), &mut z)
                .unwrap();
        }
        sampled.land(&Unilateral, 20.0).unwrap();
        assert_eq!(silent.state(), sampled.state(), "{method:?}");
        let (mut silent, mut sampled) = (silent.tally(), sampled.tally());
        // Samples may cost calls.
        assert!(silent.calls <= sampled.calls);
        (silent.calls, sampled.calls) = (0, 0);
        assert_eq!(silent, sampled, "{method:?}");
    }
}

#[test]
fn landing_ends_a_step_exactly_and_keeps_the_step_size() {
    for method in all_methods(1e-9, 0.5, 1e-2) {
        let mut integrator = run(method, &Duffing, &Duffing::START, 0.0);
        let mut z = [0.0; 7];
        for frame in 1..=50 {
            let border = 0.4 * f64::from(frame);
            integrator.sample(&Duffing, border - 1e-3, &mut z).unwrap();
            let (before, had) = (integrator.step_size(), integrator.tally().rejections);
            integrator.land(&Duffing, border).unwrap();
            assert_eq!(integrator.time(), border);
            integrator.sample(&Duffing, border, &mut z).unwrap();
            assert_eq!(
                integrator.state(),
                z,
                "the landed state is the sample there"
            );
            if integrator.tally().rejections == had {
                assert_eq!(integrator.step_size(), before, "{method:?} at {border}");
            }
            integrator.restart(&Duffing).unwrap();
        }
        let error = distance(
            integrator.state(),
            &super::reference::extrapolated(&Duffing, &Duffing::START, 20.0, 300),
        );
        assert!(error < 1e-7, "{method:?}: {error:e}");
    }
}

#[test]
fn a_changed_system_takes_over_at_the_landing() {
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
        integrator.start(&before, 0.0, &z0).unwrap();
        integrator.sample(&before, change - 0.01, &mut z).unwrap();
        integrator.land(&before, change).unwrap();
        integrator.restart(&after).unwrap();
        integrator.sample(&after, end, &mut z).unwrap();
        assert!(distance(&z, &exact) < 1e-8, "{method:?}");
        if matches!(method, Method::Lawson54 { .. } | Method::Lawson853 { .. }) {
            assert!(
                distance(&z, &exact) < 1e-13,
                "free vibration is exact across the change"
            );
        }
    }
}

#[test]
fn a_force_that_turns_nan_is_reported_with_the_last_good_state() {
    struct Broken;
    impl System for Broken {
        fn omega(&self) -> &[f64] {
            &[1.0, 2.0, 3.0]
        }
        fn force(&self, t: f64, _z: &[f64], out: &mut [f64]) {
            out.copy_from_slice(&[0.0, 0.0, if t > 1.0 { f64::NAN } else { 0.0 }]);
        }
        fn differentiable(&self) -> Option<&dyn Differentiable> {
            Some(self)
        }
    }
    differenced!(Broken);
    for method in all_methods(1e-6, 0.3, 0.01) {
        let mut integrator = run(method, &Broken, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.0);
        let error = integrator.land(&Broken, 2.0).unwrap_err();
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
        let fixed = matches!(method, Method::Rk4 { .. });
        assert!(
            last_good_time <= 1.0 && last_good_time > if fixed { 0.98 } else { 1.0 - 1e-9 },
            "{error:?}"
        );
        assert!(time > last_good_time && time < 1.02);
        assert_eq!(
            component % 3,
            2,
            "the force acts on the last mode: {error:?}"
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
fn overflow_is_reported_not_carried_on() {
    let growing = Forced {
        omega: [1.0],
        force: |_, _, v: f64| v,
    };
    for method in all_methods(1e-4, 1.0, 0.05) {
        let mut integrator = run(method, &growing, &[1.0, 0.0], 0.0);
        let error = integrator.land(&growing, 2000.0).unwrap_err();
        let DynamicsError::NonFinite { last_good_time, .. } = error else {
            panic!("{error:?}")
        };
        // exp(t / 2) leaves the range of a number at t = 2 * 709.8.
        assert!((1400.0..1420.0).contains(&last_good_time), "{error:?}");
        assert!(integrator.state().iter().all(|x| x.is_finite()));
    }
}

/// A number between -1 and 1 that looks random in the bits of `x`.
fn noise(x: f64) -> f64 {
    let mixed = x.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64
        / (1_u64 << 52) as f64
        - 1.0
}

#[test]
fn noise_above_the_tolerance_ends_in_underflow_and_a_floor_cures_it() {
    let noisy = Forced {
        omega: [1.0],
        force: |_, q, _| 1e-6 * noise(q),
    };
    let start = [0.0, 1e-20];
    let mut method = Method::Lawson54 {
        accuracy: Accuracy::relative(1e-6),
        max_step: 0.5,
    };
    let mut integrator = Integrator::new(method, &noisy).unwrap();
    integrator.start(&noisy, 1.0, &start).unwrap();
    let error = integrator.land(&noisy, 2.0).unwrap_err();
    assert!(
        matches!(error, DynamicsError::StepUnderflow { .. }),
        "{error:?}"
    );
    assert!(error.to_string().contains("floor"), "{error}");
    assert!(integrator.state().iter().all(|x| x.is_finite()));

    method = Method::Lawson54 {
        accuracy: Accuracy {
            relative: 1e-6,
            floor: 1.0,
        },
        max_step: 0.5,
    };
    let calm = run(method, &noisy, &start, 100.0);
    assert!(calm.state().iter().all(|x| x.abs() < 1e-4));
    assert!(calm.tally().steps < 1000, "{:?}", calm.tally());
}

#[test]
fn a_singularity_is_not_stepped_over() {
    // w' = w^2 from 1 has its pole at t = 1.
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
    }
    differenced!(Pole);
    for method in &adaptive_methods(1e-8, 0.5) {
        let mut integrator = run(*method, &Pole, &[1.0], 0.0);
        let error = integrator.land(&Pole, 2.0).unwrap_err();
        assert!(
            matches!(error, DynamicsError::StepUnderflow { .. }),
            "{error:?}"
        );
        assert!((integrator.time() - 1.0).abs() < 1e-6);
    }
}

/// A force that every step must follow holds any method down: all say so, and none advises itself.
#[test]
fn steps_that_get_nowhere_end_with_a_remedy_that_is_another_method() {
    struct Hum;
    impl System for Hum {
        fn omega(&self) -> &[f64] {
            &[1.0]
        }
        fn force(&self, t: f64, _z: &[f64], out: &mut [f64]) {
            out[0] = 1e7 * (1e7 * t).sin();
        }
        fn differentiable(&self) -> Option<&dyn Differentiable> {
            Some(self)
        }
    }
    differenced!(Hum);
    for method in adaptive_methods(1e-6, 1.0) {
        let mut integrator = run(method, &Hum, &[1.0, 0.0], 0.0);
        let error = integrator.land(&Hum, 100.0).unwrap_err();
        let words = error.to_string();
        let DynamicsError::Stalled { step, implicit, .. } = error else {
            panic!("{error:?}");
        };
        assert!(step < 1e-5, "{step}");
        let takes_implicit = matches!(method, Method::Rodas5p { .. } | Method::Auto { .. });
        assert_eq!(implicit, takes_implicit);
        assert_eq!(words.contains("rodas5p"), !implicit, "{words}");
    }
}

#[test]
fn told_to_stop_it_steps_no_further_and_keeps_what_it_has() {
    let stop = Arc::new(AtomicBool::new(false));
    for method in all_methods(1e-6, 0.25, 0.25) {
        let mut free = run(method, &Duffing, &Duffing::START, 0.0);
        let mut told = free.clone();
        told.heed(Arc::clone(&stop));
        let (mut z, mut same) = ([0.0; 7], [0.0; 7]);
        free.sample(&Duffing, 1.0, &mut same).unwrap();
        told.sample(&Duffing, 1.0, &mut z).unwrap();
        assert_eq!(z, same, "{method:?}");
        stop.store(true, Ordering::Relaxed);
        let time = told.time();
        told.sample(&Duffing, time, &mut z).unwrap();
        let error = told.sample(&Duffing, time + 1.0, &mut z).unwrap_err();
        assert_eq!(error, DynamicsError::Stopped { time });
        stop.store(false, Ordering::Relaxed);
        free.sample(&Duffing, 3.0, &mut same).unwrap();
        told.sample(&Duffing, 3.0, &mut z).unwrap();
        assert_eq!(z, same, "{method:?}");
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let bad_accuracy = |relative, floor| Method::Tsit54 {
        accuracy: Accuracy { relative, floor },
        max_step: 1.0,
    };
    let methods = [
        (bad_accuracy(0.0, 1.0), "relative accuracy"),
        (bad_accuracy(f64::NAN, 1.0), "relative accuracy"),
        (bad_accuracy(0.5, 1.0), "relative accuracy"),
        (bad_accuracy(1e-6, 0.0), "floor"),
        (bad_accuracy(1e-6, f64::INFINITY), "floor"),
        (
            Method::Lawson54 {
                accuracy: Accuracy::relative(1e-6),
                max_step: f64::INFINITY,
            },
            "longest step",
        ),
        (Method::Rk4 { step: -1e-6 }, "the step"),
    ];
    // A fixed step below the resolution of the time would go on for ever.
    let mut integrator = Integrator::new(Method::Rk4 { step: 1e-20 }, &Lorenz).unwrap();
    integrator.start(&Lorenz, 1.0, &Lorenz::START).unwrap();
    assert!(matches!(
        integrator.land(&Lorenz, 2.0),
        Err(DynamicsError::Parameter { .. })
    ));

    for (method, named) in methods {
        let error = Integrator::new(method, &Lorenz).unwrap_err();
        assert!(
            matches!(error, DynamicsError::Parameter { .. }),
            "{method:?}"
        );
        assert!(error.to_string().contains(named), "{error}");
    }
}

#[test]
fn modes_that_do_not_oscillate_are_refused() {
    let refused = |omega: Vec<f64>, damping: Vec<f64>| {
        Integrator::new(all_methods(1e-6, 1.0, 1.0)[0], &Free { omega, damping }).unwrap_err()
    };
    assert!(matches!(
        refused(vec![1.0, -2.0], vec![]),
        DynamicsError::Mode { mode: 1, .. }
    ));
    assert!(matches!(
        refused(vec![f64::NAN], vec![]),
        DynamicsError::Mode { mode: 0, .. }
    ));
    assert!(matches!(
        refused(vec![1.0], vec![1.0]),
        DynamicsError::Mode { mode: 0, .. }
    ));
    assert!(matches!(
        refused(vec![1.0, 2.0], vec![0.1]),
        DynamicsError::Size {
            expected: 2,
            found: 1,
            ..
        }
    ));
}

#[test]
fn wrong_sizes_and_times_are_refused_and_change_nothing() {
    let mut integrator = run(
        all_methods(1e-6, 0.5, 0.1)[0],
        &Duffing,
        &Duffing::START,
        3.0,
    );
    let (state, tally) = (integrator.state().to_vec(), integrator.tally());
    let mut z = [0.0; 7];
    let size = |error| matches!(error, Err(DynamicsError::Size { .. }));
    let time = |error| matches!(error, Err(DynamicsError::Time { .. }));
    assert!(size(integrator.start(&Duffing, 0.0, &[0.0; 6])));
    assert!(size(integrator.sample(&Duffing, 4.0, &mut [0.0; 8])));
    assert!(size(integrator.restart(&Lorenz)));
    assert!(time(integrator.start(&Duffing, f64::NAN, &Duffing::START)));
    assert!(time(integrator.sample(&Duffing, 1.0, &mut z)));
    assert!(time(integrator.sample(&Duffing, f64::INFINITY, &mut z)));
    assert!(time(integrator.land(&Duffing, 1.0)));
    assert!(time(integrator.land(&Duffing, f64::NAN)));
    assert_eq!(
        (integrator.time(), integrator.state(), integrator.tally()),
        (3.0, &state[..], tally)
    );
}

#[test]
fn a_start_that_is_not_finite_is_refused() {
    let mut integrator = Integrator::new(all_methods(1e-6, 0.5, 0.1)[0], &Duffing).unwrap();
    let mut start = Duffing::START;
    start[4] = f64::NAN;
    let error = integrator.start(&Duffing, 0.5, &start).unwrap_err();
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
