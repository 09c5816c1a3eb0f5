//! Exponents of small systems: goals, stops, and the sum that equals the mean trace.

use super::*;
use crate::dynamics::{Accuracy, Differentiable, Method};
use crate::systems::Lorenz;
use std::time::Duration;

/// Its exponents are 0.9056, 0 and -14.572 (Sprott, Chaos and Time-Series Analysis, 2003).
const LORENZ: Lorenz = Lorenz::CLASSICAL;

/// `q'' + 0.02 q' + q = (1 - q^2) q'`: self-excited; the trace varies along the limit cycle.
struct VanDerPol;

impl System for VanDerPol {
    fn omega(&self) -> &[f64] {
        &[1.0]
    }
    fn damping(&self) -> &[f64] {
        &[0.01]
    }
    fn force(&self, _t: f64, s: &[f64], out: &mut [f64]) {
        out[0] = (1.0 - s[0] * s[0]) * s[1];
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
}

impl Differentiable for VanDerPol {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        v: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let s = &record[1..];
        for l in 0..width {
            out[l] = -2.0 * s[0] * s[1] * v[l] + (1.0 - s[0] * s[0]) * v[width + l];
        }
    }
}

fn plan(goal: Goal) -> LyapunovPlan {
    LyapunovPlan {
        settle: 20.0,
        goal,
        min_time: 50.0,
        // An exponent counts as zero after 1000 periods.
        max_time: 8000.0,
        sample_interval: 0.02,
    }
}

fn study<Y: System>(
    sys: &Y,
    width: usize,
    plan: &LyapunovPlan,
    watch: OnProgress<'_, LyapunovProgress>,
) -> LyapunovStudy {
    let method = Method::Lawson54 {
        accuracy: Accuracy::relative(1e-8),
        max_step: 0.1,
    };
    let mut integrator = Integrator::new(method, sys)
        .unwrap()
        .with_tangents(sys, width, 1)
        .unwrap();
    let start = vec![1.0; sys.dim()];
    integrator.start(sys, 0.0, &start).unwrap();
    lyapunov(sys, &mut integrator, plan, watch).unwrap()
}

#[test]
fn a_fixed_averaging_time_is_exact() {
    let found = study(&LORENZ, 2, &plan(Goal::Time(100.0)), &mut |_| true);
    assert_eq!(found.ending, Ending::Reached);
    assert!((found.spectrum.time - 100.0).abs() < 1.0, "{found:?}");
    assert!((found.simulated - 120.0).abs() < 1e-9);
    let [largest, zero] = [0, 1].map(|k| found.spectrum.exponents[k].value);
    assert!((largest - 0.9056).abs() < 0.1 && zero.abs() < 0.1);
    let times: Vec<f64> = found.running.iter().map(|r| r.time).collect();
    assert!(times.len() > 50 && times.is_sorted_by(|a, b| a < b));
    let last = found.running.last().unwrap();
    assert_eq!(last.exponents, found.spectrum.exponents);
    // With two of three exponents there is neither a sum nor a trace.
    assert_eq!((found.sum(), found.mean_trace), (None, None));
}

#[test]
fn all_exponents_add_up_to_the_mean_trace() {
    let found = study(&LORENZ, 3, &plan(Goal::Time(100.0)), &mut |_| true);
    let (sum, trace) = (found.sum().unwrap(), found.mean_trace.unwrap());
    assert!((trace + 41.0 / 3.0).abs() < 1e-9, "{trace}");
    assert!((sum - trace).abs() < 1e-5, "{sum} {trace}");

    let long = plan(Goal::Time(1000.0));
    let found = study(&VanDerPol, 2, &long, &mut |_| true);
    let (sum, trace) = (found.sum().unwrap(), found.mean_trace.unwrap());
    // The two averages may end one orthonormalisation interval apart.
    assert!(
        trace < -0.5 && (sum / trace - 1.0).abs() < 0.01,
        "{sum} {trace}"
    );
}

#[test]
fn a_study_is_reproducible() {
    let [one, two] = [0, 1].map(|_| {
        let found = study(&LORENZ, 3, &plan(Goal::Time(40.0)), &mut |_| true);
        LyapunovStudy {
            busy_seconds: 0.0,
            ..found
        }
    });
    assert_eq!(one, two);
}

#[test]
fn a_stop_keeps_the_exponents_so_far() {
    let began = Instant::now();
    let mut stopped = None;
    let found = study(&LORENZ, 1, &plan(Goal::Time(1e8)), &mut |progress| {
        assert!((0.0..=1.0).contains(&progress.share), "{progress:?}");
        let should_continue = progress.phase != Phase::Averaging;
        stopped = stopped.or((!should_continue).then(|| began.elapsed()));
        should_continue
    });
    assert_eq!(found.ending, Ending::Stopped);
    // The callback is called soon, by the clock, and its answer takes effect immediately.
    let asked = stopped.unwrap();
    assert!(asked < Duration::from_secs(2), "{asked:?}");
    assert!(began.elapsed() < asked + Duration::from_secs(1));
    assert_eq!(found.spectrum.exponents.len(), 1);
    assert!(found.spectrum.time > 0.0 && found.spectrum.time < 1e7);
    assert_eq!(found.settled, 20.0);
    let last = found.running.last().unwrap();
    assert_eq!(last.time, found.spectrum.time);
    assert_eq!(last.exponents, found.spectrum.exponents);

    let found = study(&LORENZ, 1, &plan(Goal::Time(1e6)), &mut |_| false);
    assert_eq!(found.ending, Ending::Stopped);
    assert!(found.spectrum.exponents.is_empty() && found.running.is_empty());
    assert_eq!(found.settled, 0.02);
}

#[test]
fn an_integrator_without_tangent_vectors_has_no_exponents() {
    let method = Method::Rk4 { step: 0.01 };
    let mut integrator = Integrator::new(method, &LORENZ).unwrap();
    let found = lyapunov(
        &LORENZ,
        &mut integrator,
        &plan(Goal::Classification),
        &mut |_| true,
    );
    assert!(matches!(
        found,
        Err(DynamicsError::MissingCapability { .. })
    ));
}

#[test]
fn averaging_ends_at_the_target_half_width() {
    let wanted = 0.05;
    let found = study(&LORENZ, 2, &plan(Goal::HalfWidth(wanted)), &mut |_| true);
    assert_eq!(found.ending, Ending::Reached);
    let exponents = &found.spectrum.exponents;
    assert!(
        exponents.iter().all(|e| e.half_width <= wanted),
        "{exponents:?}"
    );
    assert!(found.spectrum.time > 50.0 && found.spectrum.time < 3000.0);
    assert!(
        (exponents[0].value - 0.9056).abs() < 2.0 * wanted,
        "{exponents:?}"
    );

    let short = LyapunovPlan {
        max_time: 60.0,
        ..plan(Goal::HalfWidth(1e-6))
    };
    let found = study(&LORENZ, 2, &short, &mut |_| true);
    assert_eq!(found.ending, Ending::MaxTimeReached);
}

#[test]
fn averaging_ends_at_a_clear_classification() {
    let found = study(&LORENZ, 3, &plan(Goal::Classification), &mut |_| true);
    assert_eq!(found.ending, Ending::Reached);
    assert_eq!(found.spectrum.attractor(), Attractor::Chaos);
    let found = study(&VanDerPol, 2, &plan(Goal::Classification), &mut |_| true);
    assert_eq!(found.ending, Ending::Reached);
    assert_eq!(found.spectrum.attractor(), Attractor::Cycle);
}
