//! Settled responses of the scenes.

use super::*;
use crate::analysis::Regime;
use crate::scene::Parameter;

fn take(scene: &Scene, from: From<'_>, plan: &ResponsePlan) -> Response {
    response(scene, from, plan, &mut None, &mut |_| true)
        .unwrap()
        .expect("it is not stopped")
}

/// A short measurement.
const SHORT: ResponsePlan = ResponsePlan {
    least: 0.05,
    most: 0.6,
    measure: 0.06,
    exponents: 2,
    portrait: true,
    most_calls: None,
};

#[test]
fn a_pure_tone_is_told_as_one() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let found = take(&scene, From::Cold, &SHORT);
    assert!(found.settled, "{}", found.transient);
    // It grows from nothing with some 750 1/s, and the slowest decay onto it has 60 1/s.
    assert!(
        (0.06..0.3).contains(&found.transient),
        "{}",
        found.transient
    );
    assert_eq!(found.regime, Regime::Periodic);
    assert!(
        (found.lines[0].frequency - 4110.8).abs() < 1.0,
        "{:?}",
        found.lines
    );
    assert!(
        (found.amplitude / 0.688e-6 - 1.0).abs() < 0.01,
        "{}",
        found.amplitude
    );
    assert!((found.peak_velocity / 17.76e-3 - 1.0).abs() < 0.01);
    let spread = crate::analysis::range(found.maxima.iter().copied());
    // One line, but for what its harmonics make of the shoulders.
    assert!(found.maxima.len() >= 240, "{}", found.maxima.len());
    assert!(spread[1] - spread[0] < 0.01 * found.amplitude, "{spread:?}");
    let exponents = found.exponents.unwrap();
    assert!(exponents.exponents[0].value.abs() < 5.0, "{exponents:?}");
    assert!(exponents.exponents[1].value < -20.0, "{exponents:?}");
    assert_eq!(found.linear.unwrap().unstable().count(), 4);
    let determinism = found.recurrence.unwrap().determinism.unwrap();
    // The edges of the stripes are shorter than a period.
    assert!((0.6..0.8).contains(&determinism), "{determinism}");
    let period = found.recurrence_period.unwrap();
    assert!((period * 4110.8 - 1.0).abs() < 0.01, "{period}");
    assert_eq!(found.state.len(), 22);
    let portrait = found.portrait.unwrap();
    assert_eq!(portrait.displacement.len(), 4000);
    assert_eq!(portrait.velocity.len(), 4000);
}

#[test]
fn a_motion_that_goes_on_needs_no_new_transient() {
    let scene = Scene::load("periodic-2deg").unwrap();
    let cold = take(&scene, From::Cold, &SHORT);
    let next = scene.with_values(&[(Parameter::tilt(), 2.1)]).unwrap();
    let on = take(&next, From::State(&cold.state), &SHORT);
    assert!(
        on.settled && on.transient < cold.transient,
        "{} {}",
        on.transient,
        cold.transient
    );
    assert!((on.amplitude / cold.amplitude - 1.0).abs() < 0.05);
}

#[test]
fn printed_friction_is_silent() {
    let scene = Scene::load("printed-friction").unwrap();
    let found = take(&scene, From::Cold, &SHORT);
    assert_eq!((found.regime, found.settled), (Regime::Silent, true));
    assert_eq!(found.linear.unwrap().unstable().count(), 0);
    assert!(found.maxima.is_empty() && found.lines.is_empty() && found.recurrence.is_none());
}

#[test]
fn a_small_system_responds_too() {
    let scene = Scene::load("mass-on-belt").unwrap();
    let plan = ResponsePlan {
        least: 0.5,
        most: 5.0,
        measure: 0.5,
        exponents: 9,
        ..SHORT
    };
    let found = take(&scene, From::Cold, &plan);
    assert!(found.settled && found.linear.is_none());
    assert_eq!(found.regime, Regime::Periodic);
    assert_eq!(found.exponents.unwrap().exponents.len(), 2);
}

#[test]
fn it_stops_when_told_to() {
    let scene = Scene::load("torus-3deg").unwrap();
    let mut calls = 0;
    let stopped = response(&scene, From::Cold, &SHORT, &mut None, &mut |progress| {
        calls += 1;
        assert!(progress.simulated <= progress.expected);
        calls < 3
    });
    assert_eq!((stopped.unwrap(), calls), (None, 3));
}
