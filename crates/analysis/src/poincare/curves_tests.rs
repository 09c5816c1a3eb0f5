//! Closed curves of tori, doubled tori, maps and noise.

use super::*;
use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};

/// Closed curves of the newest 400 crossings of the mean level.
fn curves(signal: &[f64], lag: usize) -> Option<ClosedCurves> {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let crossings = delay_section(signal, lag, 3, mean, Direction::Rising).unwrap();
    let inner = &crossings[1..crossings.len() - 1];
    let newest = &inner[inner.len().saturating_sub(400)..];
    let points: Vec<[f64; 2]> = newest.iter().map(|c| [c.point[0], c.point[2]]).collect();
    let points: Vec<&[f64]> = points.iter().map(|point| &point[..]).collect();
    closed_curves(&points)
}

fn found(count: usize, windings: usize) -> Option<ClosedCurves> {
    Some(ClosedCurves { count, windings })
}

/// Base frequencies of the scene doubled-torus-3deg, Hz.
const F1: f64 = 4112.79;
const F2: f64 = 3874.08;

/// 0.12 s of its torus with further lines (Hz, amplitude) and noise, at 200 kHz.
fn torus(further: &[(f64, f64)], deviation: f64) -> Vec<f64> {
    let tones = [
        (F1, 1.0),
        (F2, 0.16),
        (3.0 * F1, 0.13),
        (F1 + F2, 0.08),
        (F1 - F2, 0.05),
        (2.0 * F1 - F2, 0.03),
    ];
    let tones = tones.iter().chain(further).enumerate();
    let tones: Vec<_> = tones
        .map(|(k, (f, a))| (*f, *a, 0.1 + 1.7 * k as f64))
        .collect();
    let signal = sines(200e3, 24_000, &tones);
    let floor = noise(4, signal.len(), deviation);
    signal.iter().zip(floor).map(|(a, b)| a + b).collect()
}

#[test]
fn a_torus_has_one_curve() {
    for deviation in [0.0, 1e-4, 1e-3, 3e-3] {
        assert_eq!(
            curves(&torus(&[], deviation), 12),
            found(1, 1),
            "{deviation}"
        );
    }
    for (second, amplitude) in [(0.2618, 0.3), (0.618, 0.6), (1.618, 0.3), (0.618, 0.01)] {
        let signal = sines(50.0, 8000, &[(1.0, 1.0, 0.1), (second, amplitude, 0.7)]);
        assert_eq!(curves(&signal, 12), found(1, 1), "{second}");
    }
}

#[test]
fn a_doubled_torus_has_a_longer_curve_or_two() {
    for amplitude in [1e-3, 3e-3, 1e-2, 3e-2] {
        // Halves of f1 are visited in turn; the others lengthen the curve.
        for (line, expected) in [
            (0.5 * (F1 + F2), found(1, 2)),
            (0.5 * F2, found(1, 2)),
            (0.5 * F1, found(2, 1)),
            (1.5 * F1, found(2, 1)),
        ] {
            let seen = curves(&torus(&[(line, amplitude)], 0.0), 12);
            assert_eq!(seen, expected, "{line} {amplitude}");
        }
    }
    // Noise of a fifth of the doubling.
    let seen = curves(&torus(&[(0.5 * (F1 + F2), 1e-2)], 2e-3), 12);
    assert_eq!(seen, found(1, 2));
    // Below the noise, the doubling is not visible.
    let seen = curves(&torus(&[(0.5 * (F1 + F2), 1e-3)], 5e-3), 12);
    assert_eq!(seen, found(1, 1));
}

#[test]
fn a_second_doubling_has_four() {
    let half = (0.5 * (F1 + F2), 2e-2);
    let quarter = curves(&torus(&[half, (0.25 * (F1 + 3.0 * F2), 5e-3)], 0.0), 12);
    assert_eq!(quarter, found(1, 4));
    let quarter = curves(&torus(&[(0.5 * F1, 2e-2), (0.25 * F1, 5e-3)], 0.0), 12);
    assert_eq!(quarter, found(4, 1));
    let mixed = curves(&torus(&[(0.5 * F1, 2e-2), (0.5 * F2, 5e-3)], 0.0), 12);
    assert_eq!(mixed, found(2, 2));
}

/// Points of a map.
fn orbit(map: impl Fn([f64; 2]) -> [f64; 2], n: usize) -> Vec<[f64; 2]> {
    let next = |state: &[f64; 2]| Some(map(*state));
    let orbit = std::iter::successors(Some([0.1, 0.1]), next);
    orbit.skip(1000).take(n).collect()
}

fn of_points(points: &[[f64; 2]]) -> Option<ClosedCurves> {
    let points: Vec<&[f64]> = points.iter().map(|point| &point[..]).collect();
    closed_curves(&points)
}

#[test]
fn chaos_and_noise_have_no_curves() {
    let henon = orbit(|[x, y]| [1.0 - 1.4 * x * x + y, 0.3 * x], 800);
    assert_eq!(of_points(&henon), None);
    let logistic = orbit(|[x, y]| [1.0 - 1.43 * x * x, x + 0.0 * y], 800);
    assert_eq!(of_points(&logistic), None);
    for c in [4.5, 5.0, 5.7] {
        let x = coordinate(&roessler(40_000, 0.05, [0.2, 0.2, c], [1.0, 1.0, 0.0]), 0);
        assert_eq!(curves(&x, 29), None, "{c}");
    }
    let x = coordinate(&lorenz(12_000, 0.02, [1.0, 1.0, 1.0]), 0);
    assert_eq!(curves(&x, 8), None);
    for seed in 1..4 {
        assert_eq!(curves(&noise(seed, 3000, 1.0), 3), None);
    }
    assert_eq!(closed_curves(&[]), None);
}

#[test]
fn the_delayed_logistic_map_has_a_curve_after_its_hopf_bifurcation() {
    // x' = a x (1 - y), y' = x: an invariant circle for a slightly above 2 (Aronson et al. 1982).
    let circle = orbit(|[x, y]| [2.1 * x * (1.0 - y), x], 400);
    assert_eq!(of_points(&circle), found(1, 1));
}

#[test]
fn the_driven_circle_of_kaneko_doubles() {
    // Torus doubling (Kaneko 1984): a logistic map modulated at an irrational rotation; the curve of
    // the fixed point doubles as that of the logistic map does.
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let section = |a: f64| -> Vec<[f64; 2]> {
        let mut x = 0.3;
        let step = |k: u32| {
            let phase = std::f64::consts::TAU * golden * f64::from(k);
            x = a * x * (1.0 - x) + 0.05 * phase.cos();
            [x + 0.3 * phase.cos(), 0.3 * phase.sin()]
        };
        (0..1400).map(step).skip(1000).collect()
    };
    assert_eq!(of_points(&section(2.8)), found(1, 1));
    assert_eq!(of_points(&section(3.2)), found(2, 1));
}

#[test]
fn points_of_a_periodic_motion_are_no_curves() {
    for period in [1, 2, 3, 4, 5, 8] {
        let floor = noise(9, 800, 1e-3);
        let at = |k: usize| (1.0 + (k % period) as f64).sin();
        let points: Vec<[f64; 2]> = (0..400)
            .map(|k| [at(k) + floor[k], at(k + 1) + floor[k + 400]])
            .collect();
        assert_eq!(of_points(&points), None, "{period}");
    }
}
