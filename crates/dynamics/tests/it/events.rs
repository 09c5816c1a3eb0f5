//! Event location at kinks: unilateral springs.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use proptest::prelude::*;

use super::reference::unilateral;
use super::springs::Springs;
use super::systems::{Unilateral, by_differences};
use super::*;
use squeakscope_dynamics::{Differentiable, DynamicsError, Switching};

/// Integrates with event location from `z0` at time zero to time `t`.
pub fn run_exact<'a, Y: System>(method: Method, sys: &'a Y, z0: &[f64], t: f64) -> Integrator<'a> {
    let integrator = Integrator::new(method, sys).expect("valid parameters");
    let mut integrator = integrator.with_events().expect("the system has guards");
    integrator.start(0.0, z0).expect("finite initial state");
    integrator
        .integrate_to(t)
        .expect("the integration succeeds");
    integrator
}

/// [`Unilateral`] without the work component, with guards.
pub fn three_springs() -> Springs {
    Springs::new(
        &Unilateral::OMEGA,
        &Unilateral::SHAPES.concat(),
        &[Unilateral::PRESS; 3],
        Unilateral::STIFFNESS,
    )
}

pub const START: [f64; 6] = [0.5, -0.2, 0.1, 0.3, 0.9, -0.6];

#[test]
fn an_event_costs_one_evaluation() {
    let springs = three_springs();
    // Evaluations per step, and additional evaluations for dense output.
    let per_step = [(6, 0), (6, 0), (12, 3), (12, 3), (8, 0), (6, 0), (4, 0)];
    for (method, (per_step, dense)) in all_methods(1e-8, 0.2, 0.02).into_iter().zip(per_step) {
        springs.calls.store(0, Ordering::Relaxed);
        let integrator = run_exact(method, &springs, &START, 20.0);
        let stats = integrator.stats();
        assert!(stats.events > 30, "{stats:?}");
        let attempts = stats.steps + stats.rejections;
        let calls = 1 + per_step * attempts + dense * stats.steps + stats.events;
        assert_eq!(
            (stats.rhs_evals, springs.calls.load(Ordering::Relaxed)),
            (calls, calls)
        );
    }
}

#[test]
fn springs_that_separate_together_are_one_event() {
    // The same spring three times, with differently rounded shapes.
    let shape = 0.1 + 0.2;
    let springs = Springs::new(&[1.3], &[shape, 0.3, -shape], &[0.2, 0.2, 0.2], 2.0);
    for method in all_methods(1e-9, 0.3, 0.05) {
        let stats = run_exact(method, &springs, &[0.9, 0.4], 50.0).stats();
        assert!(stats.events > 10, "{stats:?}");
        let pairs = Springs::new(&[1.3], &[0.3, 0.3], &[0.2, 0.2], 2.0);
        let equal = run_exact(method, &pairs, &[0.9, 0.4], 50.0).stats();
        assert_eq!(equal.crossings, 2 * equal.events);
    }
    let pair = Springs::new(&[1.3], &[shape, 0.3], &[0.2, 0.2], 2.0);
    let stats = run_exact(all_methods(1e-9, 0.3, 0.05)[0], &pair, &[0.9, 0.4], 50.0).stats();
    assert_eq!(stats.crossings, 2 * stats.events, "{stats:?}");
}

#[test]
fn samples_and_step_ends_agree_on_both_sides_of_an_event() {
    let springs = three_springs();
    for method in all_methods(1e-10, 0.3, 1e-3) {
        let mut integrator = run_exact(method, &springs, &START, 0.0);
        let crossed = integrator.next_event(10.0).unwrap().to_vec();
        let (event, at_event) = (integrator.time(), integrator.state().to_vec());
        assert!(event < 10.0 && crossed.len() == 1, "{event} {crossed:?}");
        assert!(distance(&at_event, &unilateral(&START, event)) < 1e-8);

        let mut z = [0.0; 6];
        for t in [event - 1e-3, event, event + 1e-3] {
            let mut sampled = run_exact(method, &springs, &START, 0.0);
            sampled.sample(t, &mut z).unwrap();
            assert!(distance(&z, &unilateral(&START, t)) < 1e-8, "{method:?}");
            sampled.integrate_to(t).unwrap();
            assert_eq!(sampled.time(), t);
            assert!(distance(sampled.state(), &unilateral(&START, t)) < 1e-8);
            sampled.restart(Arc::new(&springs)).unwrap();
            sampled.integrate_to(event + 1.0).unwrap();
            let error = distance(sampled.state(), &unilateral(&START, event + 1.0));
            assert!(error < 1e-7, "{method:?} from {t}: {error:e}");
        }

        // A step that was shortened is reverted to a time before the event.
        let mut shortened = run_exact(method, &springs, &START, 0.0);
        while shortened.time() < event {
            let t = shortened.time() + 1e-9;
            shortened.sample(t, &mut z).unwrap();
        }
        shortened.integrate_to(event - 1e-4).unwrap();
        assert!(distance(shortened.state(), &unilateral(&START, event - 1e-4)) < 1e-8);
        assert_eq!(shortened.next_event(10.0).unwrap(), crossed);
        assert!((shortened.time() - event).abs() < 1e-8);
        // No event occurs before the limit.
        let limit = shortened.time() + 1e-6;
        assert!(shortened.next_event(limit).unwrap().is_empty());
        assert_eq!(shortened.time(), limit);
    }
}

/// A thousand springs on one mode with contact at displacements from -0.5 to 0.5.
fn thousand() -> Springs {
    let levels: Vec<f64> = (0..1000).map(|n| (f64::from(n) - 499.5) / 1000.0).collect();
    let omega = std::f64::consts::TAU * 500.0;
    let stiffness = omega * omega * 1e-3;
    let press: Vec<f64> = levels.iter().map(|level| -stiffness * level).collect();
    Springs::new(&[omega], &[1.0; 1000], &press, stiffness)
}

/// The state of [`thousand`] at time `t_end`, by closed-form solutions between contact changes.
fn thousand_exact(springs: &Springs, z0: [f64; 2], t_end: f64) -> [f64; 2] {
    let k = springs.stiffness;
    let level = |n: usize| -springs.press[n] / k;
    let (mut t, [mut x, mut v]) = (0.0, z0);
    // Springs with an index below this are in contact.
    let mut in_contact = (0..1000).filter(|&n| x > level(n)).count();
    loop {
        // x'' = -omega^2 x - sum over contacts (p + k x) + sum over all p
        let stiffness = springs.omega[0].powi(2) + k * in_contact as f64;
        let force: f64 = springs.press[in_contact..].iter().sum();
        let (w, centre) = (stiffness.sqrt(), force / stiffness);
        let (a, b) = (x - centre, v / w);
        let (radius, phase) = (a.hypot(b), b.atan2(a));
        // x - centre = radius cos(w tau - phase): time until it next reaches a level.
        let until = |target: f64, rising: bool| {
            let ratio = (target - centre) / radius;
            if ratio.abs() >= 1.0 {
                return f64::INFINITY;
            }
            let angle = if rising { -ratio.acos() } else { ratio.acos() };
            (angle + phase).rem_euclid(std::f64::consts::TAU) / w
        };
        let up = if in_contact < 1000 {
            until(level(in_contact), true)
        } else {
            f64::INFINITY
        };
        let down = if in_contact > 0 {
            until(level(in_contact - 1), false)
        } else {
            f64::INFINITY
        };
        let tau = up.min(down).min(t_end - t);
        let (s, c) = (w * tau - phase).sin_cos();
        (x, v) = (centre + radius * c, -w * radius * s);
        t += tau;
        if t >= t_end {
            return [x, v];
        }
        in_contact = if up < down {
            in_contact + 1
        } else {
            in_contact - 1
        };
    }
}

#[test]
fn a_thousand_crossings_per_millisecond_are_all_located() {
    let springs = thousand();
    let (z0, end) = ([0.6, 0.0], 3e-3);
    let exact = thousand_exact(&springs, z0, end);
    let relative = 1e-11;
    let method = MethodName::Lawson54.with(Accuracy::relative(relative), 1e-4);
    let integrator = run_exact(method, &springs, &z0, end);
    let stats = integrator.stats();
    let state = integrator.state();
    assert!(
        stats.crossings > 3000 && stats.steps_without_event_location == 0,
        "{stats:?}"
    );
    let error = [
        (state[0] - exact[0]).abs(),
        (state[1] - exact[1]).abs() / springs.omega[0],
    ];
    assert!(
        error[0].max(error[1]) < relative * stats.steps as f64,
        "the error must not exceed the tolerance times the number of steps: {error:?}"
    );
    let again = run_exact(method, &springs, &z0, end);
    assert_eq!((again.stats(), again.state()), (stats, state));
}

#[test]
fn continuous_chatter_suspends_event_location_for_one_window() {
    let omega = 1e6;
    let springs = Springs::new(&[omega], &[1.0], &[0.0], 1e-3 * omega * omega);
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-7), 1.0);
    let integrator = run_exact(method, &springs, &[1.0, 0.0], 0.035);
    let stats = integrator.stats();
    assert!(
        stats.crossings > 10_000 && stats.steps_without_event_location > 100,
        "{stats:?}"
    );
    let [x, v] = [integrator.state()[0], integrator.state()[1]];
    let spring = 1e-3 * omega * omega * x.max(0.0).powi(2);
    let energy = (v * v + omega * omega * x * x + spring) / (1.001 * omega * omega);
    assert!((energy - 1.0).abs() < 1e-2, "{energy}");
}

/// A system whose guard stays negative after it has fallen through zero.
struct AlwaysNegative;

impl System for AlwaysNegative {
    fn omega(&self) -> &[f64] {
        &[1.0]
    }
    fn force(&self, _t: f64, _z: &[f64], out: &mut [f64]) {
        out.fill(0.0);
    }
    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

by_differences!(AlwaysNegative);

impl Switching for AlwaysNegative {
    fn status_len(&self) -> usize {
        0
    }
    fn status_of(&self, _t: f64, _z: &[f64], _status: &mut [u8]) {}
    fn force_in(&self, _status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        self.force(t, z, out);
    }
    fn guards(&self) -> usize {
        1
    }
    fn guard_values(&self, _status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        values[0] = z[0];
    }
    fn cross(&self, _guard: usize, _t: f64, _z: &mut [f64], _status: &mut [u8]) {}
    fn guard_gradient(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        gradient.copy_from_slice(&[1.0, 0.0]);
        0.0
    }
}

#[test]
fn persistent_chatter_is_an_error_with_a_remedy() {
    for method in all_methods(1e-8, 0.3, 0.01) {
        let integrator = Integrator::new(method, &AlwaysNegative).unwrap();
        let mut integrator = integrator.with_events().unwrap();
        integrator.start(0.0, &[1.0, 0.0]).unwrap();
        let error = integrator.integrate_to(5.0).unwrap_err();
        let DynamicsError::Chatter { time, guard, .. } = error else {
            panic!("{error:?}")
        };
        assert_eq!(guard, 0);
        assert!((time - std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{error}");
        assert!(error.to_string().contains("status"), "{error}");
    }
}

#[test]
fn event_location_without_guards_changes_nothing() {
    let none = Springs::new(&[1.0, 2.5], &[], &[], 1.0);
    for method in all_methods(1e-8, 0.3, 0.01) {
        let z0 = [0.3, -0.1, 0.7, 0.2];
        let (plain, events) = (
            run(method, &none, &z0, 9.0),
            run_exact(method, &none, &z0, 9.0),
        );
        assert_eq!(
            (plain.state(), plain.stats()),
            (events.state(), events.stats())
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..Default::default() })]

    #[test]
    fn random_springs_agree_with_very_small_fixed_steps(
        shapes in prop::collection::vec(-1.0..1.0_f64, 8),
        press in prop::collection::vec(0.02..0.5_f64, 4),
        start in prop::collection::vec(-1.0..1.0_f64, 4),
    ) {
        let springs = Springs::new(&[1.0, 3.1], &shapes, &press, 4.0);
        let tiny = run(MethodName::Rk4.with(Accuracy::relative(1e-6), 2e-5), &springs, &start, 6.0);
        for method in &all_methods(1e-10, 0.5, 1e-3) {
            let exact = run_exact(*method, &springs, &start, 6.0);
            let error = distance(exact.state(), tiny.state());
            prop_assert!(error < 1e-7, "{method:?}: {error:e}, {:?}", exact.stats());
        }
    }
}
