//! Neimark-Sacker points with known parameter and rotation number.

use std::f64::consts::TAU;

use super::systems::autonomous;
use super::*;

/// Frequencies of the two oscillators, rad/s.
const OMEGA: [f64; 2] = [3.0, 4.2];

/// Growth of the second oscillator by the first one.
const COUPLING: f64 = 0.3;

/// Shift of the second frequency by the first oscillator, rad/s.
const SHIFT: f64 = 0.15;

/// Mixes the four coordinates, so that no oscillator has coordinates of its own.
const MIX: [[f64; 4]; 4] = [
    [0.5, 0.5, 0.5, 0.5],
    [0.5, -0.5, 0.5, -0.5],
    [0.5, 0.5, -0.5, -0.5],
    [0.5, -0.5, -0.5, 0.5],
];

fn mixed(w: &[f64]) -> [f64; 4] {
    std::array::from_fn(|i| (0..4).map(|j| MIX[i][j] * w[j]).sum())
}

/// Rates of the two oscillators `z1' = (1 - |z1|^2 + 3 i) z1`, `z2' = (p + (0.3 + 0.15 i) |z1|^2 - |z2|^2 + 4.2 i) z2`.
fn rates(parameter: f64, z: [f64; 4]) -> [f64; 4] {
    let [a, b] = [z[0] * z[0] + z[1] * z[1], z[2] * z[2] + z[3] * z[3]];
    let (first, second) = (1.0 - a, parameter + COUPLING * a - b);
    let turn = OMEGA[1] + SHIFT * a;
    [
        first * z[0] - OMEGA[0] * z[1],
        first * z[1] + OMEGA[0] * z[0],
        second * z[2] - turn * z[3],
        second * z[3] + turn * z[2],
    ]
}

/// Both oscillators in mixed coordinates; the matrix is its own inverse.
fn family() -> impl Family {
    autonomous(
        4,
        |parameter, w, out| out.copy_from_slice(&mixed(&rates(parameter, mixed(w)))),
        |parameter, w, out| differences(w, out, |z: &[f64; 4]| mixed(&rates(parameter, mixed(z)))),
    )
}

/// The derivative of rates by central differences of order 4, which are nearly exact for cubic rates.
fn differences<const N: usize>(z: &[f64], out: &mut [f64], rates: impl Fn(&[f64; N]) -> [f64; N]) {
    let h = 1e-3;
    for j in 0..N {
        let at = |k: f64| {
            let mut moved: [f64; N] = std::array::from_fn(|i| z[i]);
            moved[j] += k * h;
            rates(&moved)
        };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(at);
        for i in 0..N {
            out[i * N + j] = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h);
        }
    }
}

/// Rates around a circle with the angle `a` and unit speed: the distances `y` and `x` from the circle, in directions that turn
/// half as fast as `a`, change as `y' = p y - y^3` and `x' = -x`. After a turn both directions are reversed.
fn half_turns(parameter: f64, sign: f64, [u, v, s]: [f64; 3]) -> [f64; 3] {
    let (angle, radius) = (v.atan2(u), u.hypot(v));
    let (sin, cos) = (0.5 * angle).sin_cos();
    let outward = radius - 1.0;
    let (y, x) = (outward * cos + s * sin, s * cos - outward * sin);
    let (dy, dx) = (parameter * y - sign * y.powi(3), -x);
    let radial = dy * cos - dx * sin - 0.5 * s;
    let axial = dy * sin + dx * cos + 0.5 * outward;
    let (sin, cos) = angle.sin_cos();
    [
        radial * cos - radius * sin,
        radial * sin + radius * cos,
        axial,
    ]
}

/// The circle doubles its period at exactly `p = 0`; a distance `y` becomes `-y / sqrt(1 +- 2 T y^2)` there.
#[test]
fn the_normal_form_of_a_period_doubling_is_exact() {
    for (sign, criticality) in [
        (1.0, Criticality::Supercritical),
        (-1.0, Criticality::Subcritical),
    ] {
        let family = autonomous(
            3,
            move |parameter, z, out| {
                out.copy_from_slice(&half_turns(parameter, sign, [z[0], z[1], z[2]]));
            },
            move |parameter, z, out| {
                differences(z, out, |z: &[f64; 3]| half_turns(parameter, sign, *z));
            },
        );
        let options = precise([-0.5, 0.3], 0.2);
        let orbit = settle(&family, -0.4, &[1.1, 0.0, 0.1], 80.0, &options);
        let branch = follow(&family, orbit, &options);
        let [doubling] = &branch.bifurcations[..] else {
            panic!("{:?}", branch.bifurcations);
        };
        assert_eq!(doubling.kind, BifurcationKind::PeriodDoubling);
        assert!(doubling.parameter.abs() < 1e-9, "{}", doubling.parameter);
        let birth = doubling.birth.unwrap();
        assert_eq!(birth.criticality, criticality);
        let error = (birth.coefficient - sign * TAU).abs();
        assert!(
            error < 2e-3 && error <= birth.coefficient_error,
            "{birth:?}"
        );
        // The first orbit of twice the period lies on the side of the coefficient.
        let start = doubled_orbit(&family, doubling, 0.05, &options).unwrap();
        assert_eq!(start.orbit.parameter > 0.0, sign > 0.0);
    }
}

/// The orbit `|z1| = 1`, `z2 = 0` loses its stability at exactly `p = -0.3`, and the second oscillator turns `4.35 / 3` times
/// per period.
#[test]
fn the_neimark_sacker_point_and_its_rotation_number_are_exact() {
    let family = family();
    let options = precise([-1.0, 0.5], 0.2);
    let start = mixed(&[1.0, 0.0, 0.0, 0.0]);
    let orbit = settle(&family, -0.8, &start, 60.0, &options);
    let branch = follow(&family, orbit, &options);
    assert_eq!(branch.bifurcations.len(), 1, "{:?}", branch.bifurcations);
    let found = &branch.bifurcations[0];
    assert_eq!(found.kind, BifurcationKind::NeimarkSacker);
    eprintln!(
        "Neimark-Sacker error {:e}, accuracy {:e}, rotation {:?}, rate {:?}",
        found.parameter + COUPLING,
        found.accuracy,
        found.rotation_number,
        found.crossing_rate
    );
    assert!((found.parameter + COUPLING).abs() < 1e-9);
    assert!((found.parameter + COUPLING).abs() <= 10.0 * found.accuracy + 1e-12);
    let turns = (OMEGA[1] + SHIFT) / OMEGA[0];
    let exact = (turns - turns.round()).abs();
    assert!((found.rotation_number.unwrap() - exact).abs() < 1e-10);
    assert_eq!(found.resonance, None);
    assert_eq!(found.unstable_change, 2);
    // The growth over the period is linear in the parameter.
    let period = TAU / OMEGA[0];
    assert!((found.crossing_rate.unwrap() / period - 1.0).abs() < 1e-6);
    // |z2|^2 shrinks by 2 T |z2|^4 per period, and |z2|^2 = 2 |w|^2.
    let birth = found.birth.unwrap();
    assert_eq!(birth.criticality, Criticality::Supercritical);
    let error = (birth.coefficient + 2.0 * period).abs();
    assert!(
        error < 1e-3 && error <= birth.coefficient_error,
        "{birth:?}"
    );
    let beyond = branch.points.iter().filter(|orbit| orbit.parameter > -0.29);
    for orbit in beyond {
        assert_eq!(orbit.unstable_multipliers, 2);
        let [first, second] = orbit.torus_frequencies_hz().unwrap();
        assert!((first * period - 1.0).abs() < 1e-9);
        assert!((second * period - exact).abs() < 1e-9);
    }
    assert!(branch.unresolved.is_empty());
}

#[test]
fn strong_resonances_are_flagged() {
    for (number, resonance) in [
        (0.5, Some(Resonance::OneToTwo)),
        (0.334, Some(Resonance::OneToThree)),
        (0.249, Some(Resonance::OneToFour)),
        (0.3, None),
        (0.2, None),
    ] {
        assert_eq!(Resonance::of(number), resonance, "{number}");
    }
}
