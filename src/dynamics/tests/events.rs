//! Steps that stop at kinks: springs that open and close.

use proptest::prelude::*;

use super::super::DynamicsError;
use super::reference::unilateral;
use super::springs::Springs;
use super::systems::{Unilateral, differenced};
use super::*;
use crate::dynamics::{Differentiable, Switching};

/// The integrator at time `t` from `z0` at time zero, stopping at events.
pub fn run_exact<Y: System>(method: Method, sys: &Y, z0: &[f64], t: f64) -> Integrator {
    let integrator = Integrator::new(method, sys).expect("valid parameters");
    let mut integrator = integrator.with_events(sys).expect("it has guards");
    integrator.start(sys, 0.0, z0).expect("finite start");
    integrator
        .land(sys, t)
        .expect("the integration goes through");
    integrator
}

/// [`Unilateral`] without the work, with its guards.
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
fn an_event_costs_one_call() {
    let springs = three_springs();
    // Calls a step, and those more that states between its ends cost.
    let a_step = [(6, 0), (6, 0), (12, 3), (12, 3), (8, 0), (6, 0), (4, 0)];
    for (method, (a_step, between)) in all_methods(1e-8, 0.2, 0.02).into_iter().zip(a_step) {
        springs.calls.set(0);
        let integrator = run_exact(method, &springs, &START, 20.0);
        let tally = integrator.tally();
        assert!(tally.events > 30, "{tally:?}");
        let tries = tally.steps + tally.rejections;
        let calls = 1 + a_step * tries + between * tally.steps + tally.events;
        assert_eq!((tally.calls, springs.calls.get()), (calls, calls));
    }
}

#[test]
fn springs_that_open_together_are_one_event() {
    // The same spring three times, the shape rounded differently.
    let shape = 0.1 + 0.2;
    let springs = Springs::new(&[1.3], &[shape, 0.3, -shape], &[0.2, 0.2, 0.2], 2.0);
    for method in all_methods(1e-9, 0.3, 0.05) {
        let tally = run_exact(method, &springs, &[0.9, 0.4], 50.0).tally();
        assert!(tally.events > 10, "{tally:?}");
        let pairs = Springs::new(&[1.3], &[0.3, 0.3], &[0.2, 0.2], 2.0);
        let equal = run_exact(method, &pairs, &[0.9, 0.4], 50.0).tally();
        assert_eq!(equal.crossings, 2 * equal.events);
    }
    let pair = Springs::new(&[1.3], &[shape, 0.3], &[0.2, 0.2], 2.0);
    let tally = run_exact(all_methods(1e-9, 0.3, 0.05)[0], &pair, &[0.9, 0.4], 50.0).tally();
    assert_eq!(tally.crossings, 2 * tally.events, "{tally:?}");
}

#[test]
fn samples_and_landings_agree_on_both_sides_of_an_event() {
    let springs = three_springs();
    for method in all_methods(1e-10, 0.3, 1e-3) {
        let mut integrator = run_exact(method, &springs, &START, 0.0);
        let crossed = integrator.next_event(&springs, 10.0).unwrap().to_vec();
        let (event, at_event) = (integrator.time(), integrator.state().to_vec());
        assert!(event < 10.0 && crossed.len() == 1, "{event} {crossed:?}");
        assert!(distance(&at_event, &unilateral(&START, event)) < 1e-8);

        let mut z = [0.0; 6];
        for t in [event - 1e-3, event, event + 1e-3] {
            let mut sampled = run_exact(method, &springs, &START, 0.0);
            sampled.sample(&springs, t, &mut z).unwrap();
            assert!(distance(&z, &unilateral(&START, t)) < 1e-8, "{method:?}");
            sampled.land(&springs, t).unwrap();
            assert_eq!(sampled.time(), t);
            assert!(distance(sampled.state(), &unilateral(&START, t)) < 1e-8);
            sampled.restart(&springs).unwrap();
            sampled.land(&springs, event + 1.0).unwrap();
            let error = distance(sampled.state(), &unilateral(&START, event + 1.0));
            assert!(error < 1e-7, "{method:?} from {t}: {error:e}");
        }

        // A step that was cut is taken back to a time before the event.
        let mut cut = run_exact(method, &springs, &START, 0.0);
        while cut.time() < event {
            let t = cut.time() + 1e-9;
            cut.sample(&springs, t, &mut z).unwrap();
        }
        cut.land(&springs, event - 1e-4).unwrap();
        assert!(distance(cut.state(), &unilateral(&START, event - 1e-4)) < 1e-8);
        assert_eq!(cut.next_event(&springs, 10.0).unwrap(), crossed);
        assert!((cut.time() - event).abs() < 1e-8);
        // No event before the limit.
        let limit = cut.time() + 1e-6;
        assert!(cut.next_event(&springs, limit).unwrap().is_empty());
        assert_eq!(cut.time(), limit);
    }
}

/// A thousand springs on one mode, that open at deflections from -0.5 to 0.5.
fn thousand() -> Springs {
    let levels: Vec<f64> = (0..1000).map(|n| (f64::from(n) - 499.5) / 1000.0).collect();
    let omega = std::f64::consts::TAU * 500.0;
    let stiffness = omega * omega * 1e-3;
    let press: Vec<f64> = levels.iter().map(|level| -stiffness * level).collect();
    Springs::new(&[omega], &[1.0; 1000], &press, stiffness)
}

/// The state of [`thousand`] at time `t`, from one stretch between two openings to the next.
fn thousand_exact(springs: &Springs, z0: [f64; 2], t_end: f64) -> [f64; 2] {
    let k = springs.stiffness;
    let level = |n: usize| -springs.press[n] / k;
    let (mut t, [mut x, mut v]) = (0.0, z0);
    // The springs below this one are closed, those from it on open.
    let mut closed = (0..1000).filter(|&n| x > level(n)).count();
    loop {
        // x'' = -omega^2 x - sum over closed (p + k x) + sum over all p
        let stiffness = springs.omega[0].powi(2) + k * closed as f64;
        let force: f64 = springs.press[closed..].iter().sum();
        let (w, centre) = (stiffness.sqrt(), force / stiffness);
        let (a, b) = (x - centre, v / w);
        let (radius, phase) = (a.hypot(b), b.atan2(a));
        // x - centre = radius cos(w tau - phase): when it comes to a level, later than now.
        let until = |target: f64, rising: bool| {
            let ratio = (target - centre) / radius;
            if ratio.abs() >= 1.0 {
                return f64::INFINITY;
            }
            let angle = if rising { -ratio.acos() } else { ratio.acos() };
            (angle + phase).rem_euclid(std::f64::consts::TAU) / w
        };
        let up = if closed < 1000 {
            until(level(closed), true)
        } else {
            f64::INFINITY
        };
        let down = if closed > 0 {
            until(level(closed - 1), false)
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
        closed = if up < down { closed + 1 } else { closed - 1 };
    }
}

#[test]
fn a_thousand_crossings_a_millisecond_are_all_stopped_at() {
    let springs = thousand();
    let (z0, end) = ([0.6, 0.0], 3e-3);
    let exact = thousand_exact(&springs, z0, end);
    let relative = 1e-11;
    let method = Method::Lawson54 {
        accuracy: Accuracy::relative(relative),
        max_step: 1e-4,
    };
    let integrator = run_exact(method, &springs, &z0, end);
    let tally = integrator.tally();
    let state = integrator.state();
    assert!(tally.crossings > 3000 && tally.overrun == 0, "{tally:?}");
    let error = [
        (state[0] - exact[0]).abs(),
        (state[1] - exact[1]).abs() / springs.omega[0],
    ];
    assert!(
        error[0].max(error[1]) < relative * tally.steps as f64,
        "no more than what is allowed in each step: {error:?}"
    );
    let again = run_exact(method, &springs, &z0, end);
    assert_eq!((again.tally(), again.state()), (tally, state));
}

#[test]
fn continuous_chatter_is_run_over_for_the_rest_of_the_window() {
    let omega = 1e6;
    let springs = Springs::new(&[omega], &[1.0], &[0.0], 1e-3 * omega * omega);
    let method = Method::Lawson54 {
        accuracy: Accuracy::relative(1e-7),
        max_step: 1.0,
    };
    let integrator = run_exact(method, &springs, &[1.0, 0.0], 0.035);
    let tally = integrator.tally();
    assert!(tally.crossings > 10_000 && tally.overrun > 100, "{tally:?}");
    let [x, v] = [integrator.state()[0], integrator.state()[1]];
    let spring = 1e-3 * omega * omega * x.max(0.0).powi(2);
    let energy = (v * v + omega * omega * x * x + spring) / (1.001 * omega * omega);
    assert!((energy - 1.0).abs() < 1e-2, "{energy}");
}

/// A system that never gets clear of its guard once it has fallen.
struct Stuck;

impl System for Stuck {
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
}

differenced!(Stuck);

impl Switching for Stuck {
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
fn chatter_without_end_is_an_error_with_a_remedy() {
    for method in all_methods(1e-8, 0.3, 0.01) {
        let integrator = Integrator::new(method, &Stuck).unwrap();
        let mut integrator = integrator.with_events(&Stuck).unwrap();
        integrator.start(&Stuck, 0.0, &[1.0, 0.0]).unwrap();
        let error = integrator.land(&Stuck, 5.0).unwrap_err();
        let DynamicsError::Chatter { time, guard, .. } = error else {
            panic!("{error:?}")
        };
        assert_eq!(guard, 0);
        assert!((time - std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{error}");
        assert!(error.to_string().contains("status"), "{error}");
    }
}

#[test]
fn without_guards_events_change_nothing() {
    let none = Springs::new(&[1.0, 2.5], &[], &[], 1.0);
    for method in all_methods(1e-8, 0.3, 0.01) {
        let z0 = [0.3, -0.1, 0.7, 0.2];
        let (plain, events) = (
            run(method, &none, &z0, 9.0),
            run_exact(method, &none, &z0, 9.0),
        );
        assert_eq!(
            (plain.state(), plain.tally()),
            (events.state(), events.tally())
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..Default::default() })]

    #[test]
    fn random_springs_move_as_by_tiny_steps(
        shapes in prop::collection::vec(-1.0..1.0_f64, 8),
        press in prop::collection::vec(0.02..0.5_f64, 4),
        start in prop::collection::vec(-1.0..1.0_f64, 4),
    ) {
        let springs = Springs::new(&[1.0, 3.1], &shapes, &press, 4.0);
        let tiny = run(Method::Rk4 { step: 2e-5 }, &springs, &start, 6.0);
        for method in &all_methods(1e-10, 0.5, 1e-3) {
            let exact = run_exact(*method, &springs, &start, 6.0);
            let error = distance(exact.state(), tiny.state());
            prop_assert!(error < 1e-7, "{method:?}: {error:e}, {:?}", exact.tally());
        }
    }
}
