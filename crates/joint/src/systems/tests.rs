//! Derivatives compared with finite differences, and initial states on a guard.

use super::*;
use squeakscope_dynamics::{Differentiable, Switching};

const IMPACT: ImpactOscillator = ImpactOscillator {
    omega: 1.3,
    damping: 0.1,
    drive: 0.7,
    drive_omega: 2.1,
    drive_phase: 0.0,
    wall: 0.2,
    restitution: 0.6,
};

const BELT: MassOnBelt = MassOnBelt {
    omega: 1.3,
    damping: 0.1,
    load: 1.5,
    mu_s: 0.9,
    mu_d: 0.6,
    belt: 0.4,
    stribeck: None,
};

const DAMPED: DampedContact = DampedContact {
    omega: 1.3,
    damping: 0.1,
    drive: 0.7,
    drive_omega: 2.1,
    drive_phase: 0.0,
    contact_stiffness: 5.0,
    contact_damping: 0.8,
};

const STEP: f64 = 1e-6;

/// Central difference of component `k` of `f` with respect to component `c` of `z`.
fn difference(z: [f64; 2], c: usize, k: usize, f: impl Fn(&mut [f64; 2]) -> [f64; 2]) -> f64 {
    let shifted = |by: f64| {
        let mut z = z;
        z[c] += by;
        f(&mut z)[k]
    };
    (shifted(STEP) - shifted(-STEP)) / (2.0 * STEP)
}

fn close(a: f64, b: f64, what: &str) {
    assert!((a - b).abs() < 1e-8, "{what}: {a} is not {b}");
}

/// Compares all derivatives of a system for one status, and those of its resets at the given guards.
fn check<Y: Switching + Differentiable>(
    sys: &Y,
    status: u8,
    t: f64,
    z: [f64; 2],
    resets: &[usize],
) {
    let status = [status];
    let mut record = vec![0.0; sys.record_len()];
    let mut out = [0.0];
    sys.force_recorded(Some(&status), t, &z, &mut out, &mut record);
    let mut expected = [0.0];
    sys.force_in(&status, t, &z, &mut expected);
    assert_eq!(out, expected);

    // Two vectors: the unit vectors.
    let unit = [1.0, 0.0, 0.0, 1.0];
    let mut product = [0.0; 2];
    sys.product(Some(&status), &mut record, &unit, 2, &mut product);
    for (c, product) in product.into_iter().enumerate() {
        let force = |z: &mut [f64; 2]| {
            let mut out = [0.0];
            sys.force_in(&status, t, z, &mut out);
            [out[0], 0.0]
        };
        close(product, difference(z, c, 0, force), "the product");
    }

    for guard in 0..sys.guards() {
        let value = |t: f64, z: &[f64]| {
            let mut values = [0.0; 2];
            sys.guard_values(&status, t, z, &mut values[..sys.guards()]);
            values[guard]
        };
        if value(t, &z) == 1.0 {
            // The status does not use this guard.
            continue;
        }
        let mut gradient = [0.0; 2];
        let rate = sys.guard_gradient(&status, guard, t, &z, &mut gradient);
        for (c, gradient) in gradient.into_iter().enumerate() {
            let by_difference = difference(z, c, 0, |z| [value(t, z), 0.0]);
            close(gradient, by_difference, "the gradient");
        }
        let by_difference = (value(t + STEP, &z) - value(t - STEP, &z)) / (2.0 * STEP);
        close(rate, by_difference, "the time derivative of the guard");
    }

    for &guard in resets {
        let mut vectors = unit;
        sys.reset_tangents(&status, guard, t, &z, (&mut vectors, 2, 0.0));
        for k in 0..2 {
            for c in 0..2 {
                let reset = |z: &mut [f64; 2]| {
                    sys.cross(guard, t, z, &mut status.clone());
                    *z
                };
                close(vectors[2 * k + c], difference(z, c, k, reset), "the reset");
            }
        }
    }
}

#[test]
fn derivatives_agree_with_finite_differences() {
    // At the first time the drive pulls the mass off the wall, at the second it presses the mass against
    // it.
    for (t, z) in [(0.3, [0.2, -0.8]), (1.4, [0.2, -0.8])] {
        check(&IMPACT, ImpactOscillator::FLYING, t, z, &[0]);
        check(&IMPACT, ImpactOscillator::RESTING, t, [0.2, 0.0], &[]);
    }
    check(&BELT, MassOnBelt::SLOWER, 0.0, [0.3, 0.4], &[1]);
    check(&BELT, MassOnBelt::FASTER, 0.0, [0.3, 0.4], &[0]);
    check(&BELT, MassOnBelt::STICKING, 0.0, [0.3, 0.4], &[]);
    check(&DAMPED, DampedContact::FREE, 0.3, [0.0, -0.5], &[0]);
    check(&DAMPED, DampedContact::TOUCHING, 0.3, [0.0, 0.5], &[0]);
}

/// Friction that decreases with the sliding speed: its derivative and the growth rate of a small
/// vibration.
#[test]
fn friction_falling_with_speed_causes_growth() {
    let belt = MassOnBelt {
        stribeck: Some(2.0),
        ..BELT
    };
    check(
        &belt,
        MassOnBelt::SLOWER,
        0.0,
        [0.3, 0.1],
        &[MassOnBelt::FORWARD],
    );
    check(
        &belt,
        MassOnBelt::FASTER,
        0.0,
        [0.3, 0.9],
        &[MassOnBelt::BACKWARD],
    );
    let slope = (belt.coefficient(0.4 + STEP) - belt.coefficient(0.4 - STEP)) / (2.0 * STEP);
    close(belt.slope(0.4), slope, "slope");
    close(
        belt.growth(),
        -0.5 * (1.5 * slope + 2.0 * 0.1 * 1.3),
        "growth",
    );
    // Without a Stribeck law the kinetic coefficient applies at any speed.
    assert_eq!((BELT.coefficient(1e-9), BELT.slope(1e-9)), (0.6, 0.0));
}

#[test]
fn without_a_status_the_force_follows_from_the_state() {
    fn compare<Y: Switching + Differentiable>(sys: &Y, t: f64, z: [f64; 2]) {
        let mut status = [0];
        sys.status_of(t, &z, &mut status);
        let mut record = vec![0.0; sys.record_len()];
        let results = [None, Some(status.as_slice())].map(|status| {
            let (mut force, mut product) = ([0.0], [0.0]);
            sys.force_recorded(status, t, &z, &mut force, &mut record);
            sys.product(status, &mut record, &[0.3, -0.7], 1, &mut product);
            (force, product)
        });
        assert_eq!(results[0], results[1], "at {z:?}");
    }
    for x in [-0.7, 0.0, 0.9] {
        for v in [-0.2, 0.4, 0.8] {
            compare(&BELT, 0.3, [x, v]);
            compare(&DAMPED, 0.3, [x, v]);
        }
    }
}

#[test]
fn an_initial_state_on_a_guard_has_the_status_of_the_next_motion() {
    let status = |sys: &dyn Switching, t: f64, z: [f64; 2]| {
        let mut status = [9];
        sys.status_of(t, &z, &mut status);
        status[0]
    };
    assert_eq!(status(&DAMPED, 0.0, [0.0, 0.1]), DampedContact::FREE);
    assert_eq!(status(&DAMPED, 0.0, [0.0, -0.1]), DampedContact::TOUCHING);
    assert_eq!(status(&DAMPED, 0.0, [0.0, 0.0]), DampedContact::FREE);
    assert_eq!(status(&DAMPED, 1.5, [0.0, 0.0]), DampedContact::TOUCHING);

    // omega^2 x is the larger part of the force required for sticking; the friction limit is 1.35.
    assert_eq!(status(&BELT, 0.0, [0.5, 0.4]), MassOnBelt::STICKING);
    assert_eq!(status(&BELT, 0.0, [0.9, 0.4]), MassOnBelt::SLOWER);
    assert_eq!(status(&BELT, 0.0, [-0.9, 0.4]), MassOnBelt::FASTER);

    assert_eq!(status(&IMPACT, 1.5, [0.2, 0.0]), ImpactOscillator::RESTING);
    assert_eq!(status(&IMPACT, 0.0, [0.2, 0.0]), ImpactOscillator::FLYING);
    assert_eq!(status(&IMPACT, 1.5, [0.2, -0.1]), ImpactOscillator::FLYING);
}
