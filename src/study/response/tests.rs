//! Settled responses of the built-in scenes.

use super::*;
use crate::analysis::{AnalysisError, recurrence::RecurrenceKind, regime::Regime};
use crate::dynamics::Sign;
use crate::scene::{Parameter, Scene};
use crate::study::Stopped;
use crate::study::subject::SILENCE;

fn take(scene: &Scene, earlier: Option<&SettledResponse>, plan: &ResponsePlan) -> SettledResponse {
    let trial = Trial::of_scene(scene.clone()).unwrap();
    response(trial, earlier, plan, &mut || Ok(())).unwrap()
}

/// The response whose displacement (m) is a signal sampled at `rate` (Hz).
pub fn measured(
    scene: &Scene,
    rate: f64,
    displacement: &[f64],
) -> Result<SettledResponse, AnalysisError> {
    let pairs = || displacement.windows(2);
    let samples = Samples {
        rate,
        displacement: pairs().map(|pair| pair[0]).collect(),
        velocity: pairs().map(|pair| (pair[1] - pair[0]) * rate).collect(),
    };
    samples.response(section_lag(scene), SILENCE, Bases::None)
}

/// A short plan for tests.
const SHORT: ResponsePlan = ResponsePlan {
    min_transient_s: 0.05,
    max_transient_s: 0.6,
    measurement_s: 0.06,
    exponents: 2,
    orbits: false,
    portrait: true,
    max_rhs_evals: None,
};

#[test]
fn a_pure_tone_is_classified_as_periodic() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let found = take(&scene, None, &SHORT);
    assert!(found.settled, "{}", found.transient_s);
    // It grows from zero at about 750 1/s; the slowest decay towards the limit cycle has a rate of 60 1/s.
    assert!(
        (0.06..0.3).contains(&found.transient_s),
        "{}",
        found.transient_s
    );
    assert_eq!(found.regime, Regime::Periodic);
    assert!(
        (found.lines[0].frequency - 4110.8).abs() < 1.0,
        "{:?}",
        found.lines
    );
    assert!(
        (found.amplitude_m / 0.688e-6 - 1.0).abs() < 0.01,
        "{}",
        found.amplitude_m
    );
    assert!((found.peak_velocity_m_per_s / 17.76e-3 - 1.0).abs() < 0.01);
    let spread = crate::analysis::stats::range(found.maxima_m.iter().copied());
    // A narrow band; the harmonics add secondary maxima.
    assert!(found.maxima_m.len() >= 240, "{}", found.maxima_m.len());
    assert!(
        spread[1] - spread[0] < 0.01 * found.amplitude_m,
        "{spread:?}"
    );
    let exponents = found.exponents.unwrap();
    assert!(exponents.exponents[0].value.abs() < 5.0, "{exponents:?}");
    assert!(exponents.exponents[1].value < -20.0, "{exponents:?}");
    assert_eq!(found.linear.unwrap().unstable().count(), 4);
    let determinism = found.recurrence.unwrap().determinism.unwrap();
    // The ends of the diagonal stripes are shorter than a period.
    assert!((0.6..0.8).contains(&determinism), "{determinism}");
    let periods = &found.recurrence_periods;
    assert_eq!(periods.0.len(), 1, "{periods:?}");
    let period = periods.last(RecurrenceKind::Finest).unwrap().period;
    assert!((period * 4110.8 - 1.0).abs() < 0.01, "{period}");
    assert_eq!(found.state.len(), 22);
    let portrait = found.portrait.unwrap();
    assert_eq!(portrait.u_m.len(), 4000);
    assert_eq!(portrait.v_m_per_s.len(), 4000);
}

#[test]
fn a_periodic_motion_has_the_exponents_of_its_orbit() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let averaged = ResponsePlan {
        measurement_s: 0.4,
        exponents: 3,
        ..SHORT
    };
    let of_orbit = ResponsePlan {
        orbits: true,
        ..averaged
    };
    let [averaged, of_orbit] = [averaged, of_orbit].map(|plan| take(&scene, None, &plan));
    let [long, exact] = [&averaged, &of_orbit].map(|found| found.exponents.as_ref().unwrap());
    assert_eq!((long.time, exact.dimension), (0.4, 22));
    assert!((exact.time * 4110.8 - 1.0).abs() < 1e-3, "{exact:?}");
    for (long, exact) in long.exponents.iter().zip(&exact.exponents) {
        let error = (long.value - exact.value).abs();
        assert!(error < 1.5 * long.half_width, "{long:?} {exact:?}");
        assert!(exact.half_width < 1e-2, "{exact:?}");
    }
    assert_eq!(
        exact.attractor(),
        crate::dynamics::Attractor::Cycle,
        "{exact:?}"
    );
    assert_eq!(
        (of_orbit.regime, of_orbit.confidence),
        (Regime::Periodic, 1.0)
    );
    assert_eq!(averaged.transient_s, of_orbit.transient_s);
    assert!((averaged.amplitude_m / of_orbit.amplitude_m - 1.0).abs() < 1e-3);
    let [long, short] = [&averaged, &of_orbit].map(|found| found.stats.rhs_evals);
    assert!(2 * short < long, "{short} of {long} evaluations");
}

#[test]
fn exponents_decide_on_weak_chaos() {
    // The samples of this motion, which developed from a torus, are those of a torus.
    let scene = Scene::load("torus-1.75deg").unwrap();
    let scene = scene.with_values(&[(Parameter::tilt(), 7.0)]).unwrap();
    let found = take(&scene, None, &ResponsePlan::default());
    let exponents = found.exponents.as_ref().unwrap();
    assert_eq!(exponents.sign(0), Sign::Positive, "{exponents:?}");
    assert_eq!((&*found.motion(), found.confidence), ("chaotic", 0.95));
}

#[test]
fn a_torus_has_no_orbit() {
    let scene = Scene::load("doubled-torus-3deg").unwrap();
    let plan = ResponsePlan {
        orbits: true,
        ..SHORT
    };
    let found = take(&scene, None, &plan);
    assert_eq!(found.exponents.unwrap().time, plan.measurement_s);
}

#[test]
fn continuation_from_a_final_state_shortens_the_transient() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let first = take(&scene, None, &SHORT);
    let next = scene.with_values(&[(Parameter::tilt(), 2.1)]).unwrap();
    let on = take(&next, Some(&first), &SHORT);
    assert!(
        on.settled && on.transient_s < first.transient_s,
        "{} {}",
        on.transient_s,
        first.transient_s
    );
    assert!((on.amplitude_m / first.amplitude_m - 1.0).abs() < 0.05);
}

#[test]
fn printed_friction_is_silent() {
    let scene = Scene::load("printed-friction").unwrap();
    let found = take(&scene, None, &SHORT);
    assert_eq!((found.regime, found.settled), (Regime::Silent, true));
    assert_eq!(found.linear.unwrap().unstable().count(), 0);
    assert!(found.maxima_m.is_empty() && found.lines.is_empty() && found.recurrence.is_none());
}

#[test]
fn a_small_system_has_a_settled_response() {
    let scene = Scene::load("mass-on-belt").unwrap();
    let plan = ResponsePlan {
        min_transient_s: 0.5,
        max_transient_s: 5.0,
        measurement_s: 0.5,
        exponents: 9,
        ..SHORT
    };
    for orbits in [false, true] {
        let plan = ResponsePlan { orbits, ..plan };
        let found = take(&scene, None, &plan);
        assert!(found.settled && found.linear.is_none());
        assert_eq!(found.regime, Regime::Periodic);
        let exponents = found.exponents.unwrap();
        assert_eq!(exponents.exponents.len(), 2);
        // The direction across the belt's speed collapses while the mass sticks.
        assert_eq!(exponents.exponents[1].value, f64::NEG_INFINITY);
        assert_eq!(exponents.time < 0.5, orbits, "{exponents:?}");
    }
}

#[test]
fn the_callback_stops_a_response() {
    let scene = Scene::load("doubled-torus-3deg").unwrap();
    // Far longer than three intervals between two calls, which are of wall time.
    let plan = ResponsePlan {
        min_transient_s: 100.0,
        max_transient_s: 200.0,
        ..SHORT
    };
    let mut calls = 0;
    let trial = Trial::of_scene(scene).unwrap();
    let stopped = response(trial, None, &plan, &mut || {
        calls += 1;
        if calls < 3 { Ok(()) } else { Err(Stopped) }
    });
    assert!(matches!(stopped, Err(StudyError::Stopped(_))));
    assert_eq!(calls, 3);
}
