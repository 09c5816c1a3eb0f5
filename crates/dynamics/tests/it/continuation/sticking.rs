//! Stick-slip of a mass on a belt: an orbit with a multiplier of exactly zero.

use std::f64::consts::PI;

use super::systems::Smooth;
use super::*;
use squeakscope_dynamics::{System, piecewise_system};
use squeakscope_joint::systems::MassOnBelt;

/// The family over the speed of the belt.
fn family() -> Smooth<impl Fn(f64) -> Box<dyn System>> {
    Smooth {
        build: |belt| {
            Box::new(MassOnBelt {
                omega: 1.0,
                damping: 0.0,
                load: 1.0,
                mu_s: 1.0,
                mu_d: 0.5,
                belt,
                stribeck: None,
            }) as Box<dyn System>
        },
        drive: None,
    }
}

/// Slip for `2 (pi - atan(D / v))` and stick for `2 D / v` with `D = 1/2`.
fn period(belt: f64) -> f64 {
    2.0 * (PI - (0.5 / belt).atan()) + 1.0 / belt
}

#[test]
fn the_stick_slip_orbit_has_the_exact_period_and_one_multiplier_of_zero() {
    let family = family();
    assert!((period(0.2) - 8.902_605_4).abs() < 5e-8);
    let options = precise([0.1, 0.6], 0.1);
    for start in [[1.0, 0.0], [0.3, 0.2]] {
        let orbit = settle(&family, 0.2, &start, 33.0, &options);
        let error = (orbit.period_s - period(0.2)).abs();
        eprintln!(
            "period error {error:.1e}, multipliers {:?}, {} segments, events {}",
            orbit.multipliers,
            orbit.segments.len(),
            orbit.events
        );
        assert!(error < 1e-9, "{error:e}");
        assert_eq!(orbit.multipliers.len(), 2);
        assert_eq!(orbit.multipliers[1], Multiplier::ZERO);
        assert!(orbit.multipliers[0].distance_from(1.0) < 1e-9);
        assert!(orbit.stable);
        assert_eq!(orbit.events, 2);
    }
}

/// The shares of sticking and sliding change along the branch, so that for some phases of the first orbit the start of a segment
/// passes an event.
#[test]
fn the_stick_slip_branch_follows_the_closed_form_from_any_phase() {
    for settle_s in [33.0, 34.2, 35.4, 36.6, 37.8, 39.0, 40.2, 41.4] {
        follows_the_closed_form(settle_s);
    }
}

fn follows_the_closed_form(settle_s: f64) {
    let family = family();
    let options = precise([0.1, 0.6], 0.1);
    let orbit = settle(&family, 0.2, &[1.0, 0.0], settle_s, &options);
    let branch = follow(&family, orbit, &options);
    let worst = branch
        .points
        .iter()
        .map(|orbit| (orbit.period_s - period(orbit.parameter)).abs())
        .fold(0.0, f64::max);
    eprintln!(
        "{} points, worst {worst:e}, {:?}",
        branch.points.len(),
        branch.ends
    );
    let bounds = [
        branch.points[0].parameter,
        branch.points.last().unwrap().parameter,
    ];
    assert_eq!(bounds, [0.1, 0.6], "{settle_s}: {:?}", branch.ends);
    assert!(worst < 1e-8, "{worst:e}");
    for orbit in &branch.points {
        assert_eq!(orbit.multipliers[1], Multiplier::ZERO);
    }
    assert!(branch.bifurcations.is_empty() && branch.unresolved.is_empty());
}

/// The same oscillator from closures, on the orbit that is never faster than the belt. Derivatives are differences.
#[test]
fn a_system_of_closures_follows_the_closed_form() {
    let family = |belt: f64| {
        piecewise_system(
            [1.0],
            move |_, _, v| u8::from(v[0] < belt),
            |status, _, q, _, force| force[0] = [q[0], 0.5][usize::from(status)],
            1,
            move |status, _, q, v, guard| {
                guard[0] = [1.0 - q[0], belt - v[0]][usize::from(status)];
            },
            move |status, _, _, v| {
                v[0] = belt;
                1 - status
            },
        )
        .held(move |status, _, v| {
            if status == 0 {
                v[0] = belt;
            }
        })
    };
    let options = ContinuationOptions::new([0.1, 0.6], 0.1);
    let orbit = settle(&family, 0.2, &[0.0, 0.2], 20.0, &options);
    let branch = follow(&family, orbit, &options);
    let ends = [branch.points.first(), branch.points.last()];
    assert_eq!(
        ends.map(|end| end.unwrap().parameter),
        [0.1, 0.6],
        "{:?}",
        branch.ends
    );
    for orbit in &branch.points {
        let error = (orbit.period_s - period(orbit.parameter)).abs();
        assert!(error < 1e-7, "{}: {error:e}", orbit.parameter);
    }
}
