//! Exponents of small systems: goals, stops, and the sum that equals the mean trace.

use super::*;
use crate::dynamics::{Accuracy, Differentiable, MethodName, System};
use std::time::Duration;

#[path = "../../../crates/dynamics/tests/it/known/lorenz.rs"]
mod lorenz;
use lorenz::Lorenz;

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
    fn is_autonomous(&self) -> bool {
        true
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
    let [min_time, max_time] = match goal {
        Goal::Time(time) => [time; 2],
        // An exponent counts as zero after 1000 periods.
        Goal::HalfWidth(_) | Goal::Classification => [50.0, 8000.0],
    };
    LyapunovPlan {
        settle: 20.0,
        goal,
        min_time,
        max_time,
        sample_interval: 0.02,
        constant_since: 0.0,
    }
}

fn study<Y: System>(
    sys: &Y,
    width: usize,
    plan: &LyapunovPlan,
    progress: OnProgress<'_>,
) -> LyapunovStudy {
    let mut integrator = integrator(sys, width, &vec![1.0; sys.dim()]);
    lyapunov(&mut integrator, plan, progress).unwrap()
}

/// An integrator with tangent vectors, started at a state.
fn integrator<'a, Y: System>(sys: &'a Y, width: usize, start: &[f64]) -> Integrator<'a> {
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-8), 0.1);
    let integrator = Integrator::new(method, sys).unwrap();
    let mut integrator = integrator.with_tangents(width, 1).unwrap();
    integrator.start(0.0, start).unwrap();
    integrator
}

#[test]
fn a_fixed_averaging_time_is_exact() {
    let found = study(&LORENZ, 2, &plan(Goal::Time(100.0)), &mut |_, _| Ok(()));
    assert_eq!(found.ending, Ending::Reached);
    assert!((found.spectrum.time - 100.0).abs() < 1.0, "{found:?}");
    assert!((found.simulated_s - 120.0).abs() < 1e-9);
    let [largest, zero] = [0, 1].map(|k| found.spectrum.exponents[k].value);
    assert!((largest - 0.9056).abs() < 0.1 && zero.abs() < 0.1);
    let times: Vec<f64> = found.running.iter().map(|r| r.time).collect();
    assert!(times.len() > 50 && times.is_sorted_by(|a, b| a < b));
    let last = found.running.last().unwrap();
    assert_eq!(last.exponents, found.spectrum.exponents);
    // With two of three exponents there is neither a sum nor a trace.
    assert_eq!((found.sum(), found.mean_trace_per_s), (None, None));
}

#[test]
fn all_exponents_add_up_to_the_mean_trace() {
    let found = study(&LORENZ, 3, &plan(Goal::Time(100.0)), &mut |_, _| Ok(()));
    let (sum, trace) = (found.sum().unwrap(), found.mean_trace_per_s.unwrap());
    assert!((trace + 41.0 / 3.0).abs() < 1e-9, "{trace}");
    assert!((sum - trace).abs() < 1e-5, "{sum} {trace}");

    let long = plan(Goal::Time(1000.0));
    let found = study(&VanDerPol, 2, &long, &mut |_, _| Ok(()));
    let (sum, trace) = (found.sum().unwrap(), found.mean_trace_per_s.unwrap());
    // The two averages may end one orthonormalisation interval apart.
    assert!(
        trace < -0.5 && (sum / trace - 1.0).abs() < 0.01,
        "{sum} {trace}"
    );
}

#[test]
fn a_study_is_reproducible() {
    let [one, two] = [0, 1].map(|_| {
        let found = study(&LORENZ, 3, &plan(Goal::Time(40.0)), &mut |_, _| Ok(()));
        LyapunovStudy {
            busy_seconds: 0.0,
            real_time_factor: None,
            ..found
        }
    });
    assert_eq!(one, two);
}

#[test]
fn a_stop_keeps_the_exponents_so_far() {
    let began = Instant::now();
    let mut stopped = None;
    let found = study(&LORENZ, 1, &plan(Goal::Time(1e8)), &mut |share, task| {
        assert!((0.0..=1.0).contains(&share), "{share}");
        if !task.starts_with("averaging") {
            return Ok(());
        }
        stopped = stopped.or_else(|| Some(began.elapsed()));
        Err(Stopped)
    });
    assert_eq!(found.ending, Ending::Stopped);
    // The callback is called soon, by the clock, and its answer takes effect immediately.
    let asked = stopped.unwrap();
    assert!(asked < Duration::from_secs(2), "{asked:?}");
    assert!(began.elapsed() < asked + Duration::from_secs(1));
    assert_eq!(found.spectrum.exponents.len(), 1);
    assert!(found.spectrum.time > 0.0 && found.spectrum.time < 1e7);
    assert_eq!(found.settle_s, 20.0);
    let last = found.running.last().unwrap();
    assert_eq!(last.time, found.spectrum.time);
    assert_eq!(last.exponents, found.spectrum.exponents);

    let found = study(&LORENZ, 1, &plan(Goal::Time(1e6)), &mut |_, _| Err(Stopped));
    assert_eq!(found.ending, Ending::Stopped);
    assert!(found.spectrum.exponents.is_empty() && found.running.is_empty());
    assert_eq!(found.settle_s, 0.0);
}

#[test]
fn an_integrator_without_tangent_vectors_has_no_exponents() {
    let method = MethodName::Rk4.with(Accuracy::relative(1e-6), 0.01);
    let mut integrator = Integrator::new(method, LORENZ).unwrap();
    let found = lyapunov(&mut integrator, &plan(Goal::Classification), &mut |_, _| {
        Ok(())
    });
    assert!(matches!(
        found,
        Err(DynamicsError::MissingCapability { .. })
    ));
}

#[test]
fn averaging_ends_at_the_target_half_width() {
    let wanted = 0.05;
    let found = study(&LORENZ, 2, &plan(Goal::HalfWidth(wanted)), &mut |_, _| {
        Ok(())
    });
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
    let found = study(&LORENZ, 2, &short, &mut |_, _| Ok(()));
    assert_eq!(found.ending, Ending::MaxTimeReached);
}

#[test]
fn averaging_ends_at_a_clear_classification() {
    let found = study(&LORENZ, 3, &plan(Goal::Classification), &mut |_, _| Ok(()));
    assert_eq!(found.ending, Ending::Reached);
    assert_eq!(found.spectrum.attractor(), Attractor::Chaos);
    let found = study(&VanDerPol, 2, &plan(Goal::Classification), &mut |_, _| {
        Ok(())
    });
    assert_eq!(found.ending, Ending::Reached);
    assert_eq!(found.spectrum.attractor(), Attractor::Cycle);
}

/// Below `rho` = 24.06 the only attractors of the Lorenz system are two fixed points, but trajectories may be
/// chaotic for a long time before (J. A. Yorke and E. D. Yorke, J. Stat. Phys. 21 (1979) 263-277).
const PRETURBULENT: Lorenz = Lorenz {
    rho: 22.5,
    ..Lorenz::CLASSICAL
};

/// The time at which the trajectory of a study enters the neighbourhood of a fixed point for good.
fn end_of_turbulence(start: &[f64], until: f64) -> f64 {
    let mut integrator = integrator(&PRETURBULENT, 1, start);
    let mut z = [0.0; 3];
    let (mut last_switch, mut side) = (0.0, 1.0);
    for k in 1..(until / 0.02) as u32 {
        let time = 0.02 * f64::from(k);
        integrator.sample(time, &mut z).unwrap();
        if z[0].signum() != side {
            (last_switch, side) = (time, z[0].signum());
        }
    }
    last_switch
}

#[test]
fn a_chaotic_transient_is_separated_from_the_fixed_point_after_it() {
    let plan = plan(Goal::Time(400.0));
    let mut seen = 0;
    for k in 0..40 {
        let start = [0.1 * f64::from(k) - 3.0, 0.0, 20.0];
        let end = end_of_turbulence(&start, 420.0);
        // Long enough before and after the change.
        if !(90.0..=300.0).contains(&end) {
            continue;
        }
        let mut integrator = integrator(&PRETURBULENT, 3, &start);
        let found = lyapunov(&mut integrator, &plan, &mut |_, _| Ok(())).unwrap();
        let attractors: Vec<Attractor> = found.segments.iter().map(|s| s.attractor).collect();
        println!("ends at {end}: {attractors:?} {:?}", found.segments);
        let last = found.segments.last().unwrap();
        assert_eq!(last.attractor, Attractor::FixedPoint);
        assert_eq!(found.attractor(), Attractor::FixedPoint);
        assert_eq!(last.spectrum, found.spectrum);
        let lifetime = found.chaotic_transient_s.unwrap();
        // The trajectory spirals into the fixed point at 0.07 per unit of time.
        assert!(
            (-10.0..40.0).contains(&(lifetime - end)),
            "{lifetime} {end}"
        );
        let chaos = found
            .segments
            .iter()
            .find(|s| s.attractor == Attractor::Chaos);
        let largest = chaos.unwrap().spectrum.exponents[0];
        // The exponent of the chaos before does not contain the decay to the fixed point.
        assert!((0.5..0.9).contains(&largest.value), "{largest:?}");
        seen += 1;
    }
    assert!(seen >= 8, "{seen}");
}

#[test]
fn the_averages_of_one_motion_are_not_divided() {
    for (rho, goal) in [(28.0, 100.0), (28.0, 400.0), (60.0, 200.0)] {
        let lorenz = Lorenz { rho, ..LORENZ };
        let found = study(&lorenz, 3, &plan(Goal::Time(goal)), &mut |_, _| Ok(()));
        assert_eq!(
            found.segments.len(),
            1,
            "{rho} {goal}: {:?}",
            found.segments
        );
        assert!(found.chaotic_transient_s.is_none());
    }
    let found = study(&VanDerPol, 2, &plan(Goal::Time(1000.0)), &mut |_, _| Ok(()));
    assert_eq!(found.segments.len(), 1, "{:?}", found.segments);
}
