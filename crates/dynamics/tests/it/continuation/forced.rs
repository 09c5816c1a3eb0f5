//! Forced oscillators: folds of the Duffing oscillator, tongues of the Mathieu equation.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::systems::{Equations, Smooth};
use super::*;
use squeakscope_dynamics::System;

const DAMPING: f64 = 0.05;
const CUBIC: f64 = 0.3;
const FORCE: f64 = 0.3;

/// `x'' + 2 zeta x' + x + 0.3 x^3 = 0.3 cos(W t)` over the drive frequency W (rad/s).
fn duffing() -> Smooth<impl Fn(f64) -> Box<dyn System>> {
    Smooth {
        build: |omega: f64| {
            Box::new(Equations {
                dimension: 2,
                rates: move |t: f64, w: &[f64], out: &mut [f64]| {
                    out[0] = w[1];
                    out[1] = -2.0 * DAMPING * w[1] - w[0] - CUBIC * w[0].powi(3)
                        + FORCE * (omega * t).cos();
                },
                jacobian: |_: f64, w: &[f64], out: &mut [f64]| {
                    out.copy_from_slice(&[
                        0.0,
                        1.0,
                        -1.0 - 3.0 * CUBIC * w[0] * w[0],
                        -2.0 * DAMPING,
                    ]);
                },
                autonomous: false,
            }) as Box<dyn System>
        },
        drive: Some(|omega| TAU / omega),
    }
}

/// Odd harmonics of the balance.
const HARMONICS: usize = 9;

/// Residual of harmonic balance for the cosine and sine coefficients of odd harmonics.
fn balance(coefficients: &DVector<f64>, omega: f64) -> DVector<f64> {
    let samples = 8 * HARMONICS;
    let mut residual = DVector::zeros(2 * HARMONICS);
    for k in 0..HARMONICS {
        let n = (2 * k + 1) as f64;
        let (c, s) = (coefficients[2 * k], coefficients[2 * k + 1]);
        let stiffness = 1.0 - (n * omega).powi(2);
        let damping = 2.0 * DAMPING * n * omega;
        residual[2 * k] = stiffness * c + damping * s;
        residual[2 * k + 1] = stiffness * s - damping * c;
    }
    residual[0] -= FORCE;
    for j in 0..samples {
        let angle = TAU * j as f64 / samples as f64;
        let x: f64 = (0..HARMONICS)
            .map(|k| {
                let (sin, cos) = ((2 * k + 1) as f64 * angle).sin_cos();
                coefficients[2 * k] * cos + coefficients[2 * k + 1] * sin
            })
            .sum();
        let cubic = CUBIC * x.powi(3) * 2.0 / samples as f64;
        for k in 0..HARMONICS {
            let (sin, cos) = ((2 * k + 1) as f64 * angle).sin_cos();
            residual[2 * k] += cubic * cos;
            residual[2 * k + 1] += cubic * sin;
        }
    }
    residual
}

/// The frequency for which the first harmonic has the given phase (rad), by Newton's method on all coefficients and the
/// frequency; the phase increases along the resonance curve.
fn frequency_at_phase(phase: f64, guess: &mut DVector<f64>) -> f64 {
    let n = 2 * HARMONICS;
    let (sin, cos) = phase.sin_cos();
    let equations = |u: &DVector<f64>| {
        let mut all = DVector::zeros(n + 1);
        all.rows_mut(0, n)
            .copy_from(&balance(&u.rows(0, n).into_owned(), u[n]));
        all[n] = u[0] * sin - u[1] * cos;
        all
    };
    for _ in 0..30 {
        let here = equations(guess);
        let h = 1e-6;
        let jacobian = DMatrix::from_columns(
            &(0..=n)
                .map(|j| {
                    let [mut a, mut b] = [guess.clone(), guess.clone()];
                    a[j] += h;
                    b[j] -= h;
                    (equations(&a) - equations(&b)) / (2.0 * h)
                })
                .collect::<Vec<_>>(),
        );
        let step = jacobian.lu().solve(&here).expect("regular");
        *guess -= &step;
        if step.norm() < 1e-13 {
            break;
        }
    }
    guess[n]
}

/// The extremes of the frequency along the resonance curve, as its phase goes from 0 to pi.
fn folds_by_harmonic_balance() -> Vec<f64> {
    let mut u = DVector::zeros(2 * HARMONICS + 1);
    u[0] = FORCE;
    u[2 * HARMONICS] = 0.3;
    let mut curve = Vec::new();
    let count = 600;
    for k in 1..count {
        let phase = PI * f64::from(k) / f64::from(count);
        curve.push((phase, frequency_at_phase(phase, &mut u), u.clone()));
    }
    let mut folds = Vec::new();
    for triple in curve.windows(3) {
        let rises = [triple[1].1 - triple[0].1, triple[2].1 - triple[1].1];
        if rises[0] * rises[1] >= 0.0 {
            continue;
        }
        let sign = rises[0].signum();
        // Golden section.
        let (mut low, mut high) = (triple[0].0, triple[2].0);
        let mut u = triple[1].2.clone();
        let mut value = |phase: f64| sign * frequency_at_phase(phase, &mut u);
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        for _ in 0..60 {
            let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
            if value(a) > value(b) {
                high = b;
            } else {
                low = a;
            }
        }
        folds.push(sign * value(0.5 * (low + high)));
    }
    folds
}

#[test]
fn the_folds_of_the_duffing_resonance_agree_with_harmonic_balance() {
    let family = duffing();
    let options = precise([0.6, 2.5], 0.2);
    let orbit = settle(&family, 0.7, &[0.3, 0.0], 400.0, &options);
    assert_eq!(orbit.drive_periods, Some(1));
    assert_eq!(orbit.trivial_multiplier_error, None);
    let branch = follow(&family, orbit, &options);
    let folds = of_kind(&branch, BifurcationKind::Fold);
    let mut expected = folds_by_harmonic_balance();
    expected.sort_by(|a, b| b.total_cmp(a));
    let found: Vec<f64> = folds.iter().map(|fold| fold.parameter).collect();
    eprintln!(
        "folds {found:?} expected {expected:?}, {} points, {:?}",
        branch.points.len(),
        branch.newton_iterations
    );
    assert_eq!(found.len(), 2);
    assert_eq!(expected.len(), 2);
    for ((found, fold), expected) in found.iter().zip(&folds).zip(&expected) {
        assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        assert!(fold.accuracy < 1e-7);
        // Damping sets the product of the multipliers.
        let sum: f64 = fold.orbit.multipliers.iter().map(|m| m.ln_magnitude).sum();
        assert!((sum + 2.0 * DAMPING * fold.orbit.period_s).abs() < 1e-9);
    }
    // Unstable between the folds.
    assert_eq!(folds[0].unstable_change, 1);
    assert_eq!(folds[1].unstable_change, -1);
    assert!(folds[0].fold_curvature.unwrap() < 0.0 && folds[1].fold_curvature.unwrap() > 0.0);
    assert!(branch.unresolved.is_empty());
    assert_eq!(branch.ends[1], Some(BranchEnd::ParameterBound));
}

/// Each fold of the resonance ends a motion that attracts, on whichever side of it the located orbit lies; not if another
/// multiplier is outside the unit circle.
#[test]
fn a_fold_has_a_stable_side_whichever_side_its_orbit_is_on() {
    let family = duffing();
    let options = precise([0.6, 2.5], 0.2);
    let orbit = settle(&family, 0.7, &[0.3, 0.0], 400.0, &options);
    let branch = follow(&family, orbit, &options);
    for fold in of_kind(&branch, BifurcationKind::Fold) {
        for distance in [0.0, -0.01, 0.01] {
            let mut moved = fold.clone();
            moved.orbit.multipliers[0].ln_magnitude += distance;
            assert!(moved.has_stable_side());
            moved.orbit.multipliers[1] = Multiplier {
                ln_magnitude: 1.5_f64.ln(),
                angle: PI,
            };
            assert!(!moved.has_stable_side());
        }
    }
}

/// `x'' + 2 d x' + (a - 2 q cos 2 t) x = 0` over `a`: the orbit is rest.
fn mathieu(q: f64, damping: f64) -> Smooth<impl Fn(f64) -> Box<dyn System>> {
    Smooth {
        build: move |a: f64| {
            let stiffness = move |t: f64| a - 2.0 * q * (2.0 * t).cos();
            Box::new(Equations {
                dimension: 2,
                rates: move |t: f64, w: &[f64], out: &mut [f64]| {
                    out[0] = w[1];
                    out[1] = -2.0 * damping * w[1] - stiffness(t) * w[0];
                },
                jacobian: move |t: f64, _: &[f64], out: &mut [f64]| {
                    out.copy_from_slice(&[0.0, 1.0, -stiffness(t), -2.0 * damping]);
                },
                autonomous: false,
            }) as Box<dyn System>
        },
        drive: Some(|_| PI),
    }
}

/// The characteristic values a1, b1 (anti-periodic) and a2, b2 (periodic solutions), as eigenvalues of the truncated
/// recurrences (M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, Section 20.2).
fn characteristic_values(q: f64) -> [f64; 4] {
    let count = 20;
    let tridiagonal = |diagonal: &dyn Fn(usize) -> f64, first: f64| {
        let matrix = DMatrix::from_fn(count, count, |i, j| match i.abs_diff(j) {
            0 => diagonal(i),
            1 if i.min(j) == 0 => first,
            1 => q,
            _ => 0.0,
        });
        let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let odd = |sign: f64| {
        move |i: usize| {
            let shift = if i == 0 { sign * q } else { 0.0 };
            ((2 * i + 1) as f64).powi(2) + shift
        }
    };
    let a1 = tridiagonal(&odd(1.0), q)[0];
    let b1 = tridiagonal(&odd(-1.0), q)[0];
    let a2 = tridiagonal(&|i| (2.0 * i as f64).powi(2), 2.0_f64.sqrt() * q)[1];
    let b2 = tridiagonal(&|i| (2.0 * (i + 1) as f64).powi(2), q)[0];
    [a1, b1, a2, b2]
}

/// The tongues of the undamped Mathieu equation: multipliers of -1 at b1 and a1, of 1 at b2 and a2.
#[test]
fn the_tongues_of_the_mathieu_equation_end_at_the_characteristic_values() {
    let q = 1.0;
    let [a1, b1, a2, b2] = characteristic_values(q);
    // Abramowitz and Stegun, Table 20.1.
    for (value, table) in [
        (a1, 1.859_108_07),
        (b1, -0.110_248_82),
        (a2, 4.371_300_98),
        (b2, 3.917_024_77),
    ] {
        assert!((value - table).abs() < 1e-8, "{value} {table}");
    }
    let family = mathieu(q, 0.0);
    // At rest the error is zero for any step, so the maximum step sets the accuracy of the multipliers.
    let options = precise([-0.3, 4.6], 0.02);
    let orbit = settle(&family, 2.5, &[0.0, 0.0], 0.0, &options);
    let branch = follow(&family, orbit, &options);
    let found: Vec<_> = branch
        .bifurcations
        .iter()
        .map(|bifurcation| (bifurcation.kind, bifurcation.parameter))
        .collect();
    eprintln!("{found:?} {} points", branch.points.len());
    let expected = [
        (BifurcationKind::PeriodDoubling, b1),
        (BifurcationKind::PeriodDoubling, a1),
        (BifurcationKind::BranchPoint, b2),
        (BifurcationKind::BranchPoint, a2),
    ];
    assert_eq!(found.len(), 4, "{found:?}");
    for ((kind, at), (expected_kind, expected)) in found.iter().zip(expected) {
        assert_eq!(*kind, expected_kind);
        assert!((at - expected).abs() < 1e-8, "{at} {expected}");
    }
    for orbit in &branch.points {
        let a = orbit.parameter;
        let is_unstable = (b1..a1).contains(&a) || (b2..a2).contains(&a);
        assert_eq!(orbit.unstable_multipliers, usize::from(is_unstable), "{a}");
    }
}
