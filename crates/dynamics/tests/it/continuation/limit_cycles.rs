//! Limit cycles: van der Pol, and normal forms with exact orbits, multipliers and bifurcations.

use std::f64::consts::TAU;

use super::systems::{Smooth, autonomous};
use super::*;
use squeakscope_dynamics::System;
use squeakscope_dynamics::equilibrium::Linearised;

fn van_der_pol() -> Smooth<impl Fn(f64) -> Box<dyn System>> {
    autonomous(
        2,
        |mu, w, out| {
            out[0] = w[1];
            out[1] = mu * (1.0 - w[0] * w[0]) * w[1] - w[0];
        },
        |mu, w, out| {
            out.copy_from_slice(&[
                0.0,
                1.0,
                -2.0 * mu * w[0] * w[1] - 1.0,
                mu * (1.0 - w[0] * w[0]),
            ]);
        },
    )
}

/// Periods, amplitudes and multipliers of the van der Pol oscillator, computed with DOP853 at 1e-13; the multiplier is the
/// exponential of the integral of the trace.
const VAN_DER_POL: [(f64, f64, f64, f64); 4] = [
    (0.1, 6.287_111_272_3, 2.000_103_979_9, 0.533_069_259),
    (1.0, 6.663_286_859_3, 2.008_619_860_9, 8.596_950_64e-4),
    (5.0, 11.612_230_667_7, 2.021_508_061_6, 7.7386e-38),
    (10.0, 19.078_369_566_9, 2.014_285_360_9, f64::NAN),
];

#[test]
fn van_der_pol_has_the_published_periods_and_multipliers() {
    let family = van_der_pol();
    for (mu, period, amplitude, multiplier) in VAN_DER_POL {
        let options = precise([0.05, 12.0], 0.5);
        let orbit = settle(&family, mu, &[2.0, 0.0], 100.0 / mu.min(1.0), &options);
        let error = (orbit.period_s - period).abs();
        eprintln!(
            "mu {mu}: period error {error:.1e}, amplitude {:.1e}, multipliers {:?}, trivial {:?}, {} segments",
            orbit.amplitude - amplitude,
            orbit.multipliers,
            orbit.trivial_multiplier_error,
            orbit.segments.len()
        );
        assert!(error < 1e-8, "{mu}: {error:e}");
        // The range is that of samples.
        assert!((orbit.amplitude / amplitude - 1.0).abs() < 1e-3);
        assert!(orbit.trivial_multiplier_error.unwrap() < 1e-8);
        assert!(orbit.stable);
        let smallest = orbit.multipliers[1];
        assert!(smallest.is_real());
        // A smaller one is lost in rounding errors.
        if multiplier < 1e-9 {
            assert!(smallest.magnitude() < 1e-12);
        } else if multiplier.is_finite() {
            let logarithm = multiplier.ln();
            let error = (smallest.ln_magnitude - logarithm).abs() / logarithm.abs();
            assert!(error < 1e-6, "{mu}: {} {logarithm}", smallest.ln_magnitude);
        }
    }
}

#[test]
fn bounds_and_steps_out_of_order_are_refused() {
    let family = van_der_pol();
    let search = ReturnSearch {
        settle_s: 100.0,
        max_period_s: 100.0,
        tolerance: 0.02,
    };
    let refused = |options: ContinuationOptions| {
        let orbit = settled_orbit(&family, 1.0, &[2.0, 0.0], &search, &options);
        orbit.expect_err("refused").to_string()
    };
    for bounds in [[2.0, 0.5], [0.5, f64::NAN]] {
        let fault = refused(precise(bounds, 0.5));
        assert!(fault.contains("the parameter's bounds"), "{fault}");
    }
    for [initial, min, max] in [[0.1, 1e-6, 0.05], [1e-7, 1e-6, 0.05], [0.01, 0.0, 0.05]] {
        let steps = StepLimits { initial, min, max };
        let fault = refused(ContinuationOptions {
            steps,
            ..precise([0.05, 12.0], 0.5)
        });
        assert!(fault.contains("the first step along the branch"), "{fault}");
    }
}

/// The multiplier over mu from 0.1 to 10 on one branch: the integral of the trace by quadrature along the orbit.
#[test]
fn van_der_pol_follows_its_branch_to_multipliers_of_any_size() {
    let family = van_der_pol();
    let options = precise([0.1, 10.0], 0.5);
    let orbit = settle(&family, 0.1, &[2.0, 0.0], 200.0, &options);
    let branch = follow(&family, orbit, &options);
    eprintln!(
        "{} points, {:?}, ends {:?}",
        branch.points.len(),
        branch.newton_iterations,
        branch.ends
    );
    assert_eq!(branch.ends[1], Some(BranchEnd::ParameterBound));
    assert!(branch.bifurcations.is_empty() && branch.unresolved.is_empty());
    let last = branch.points.last().unwrap();
    assert!((last.parameter - 10.0).abs() < 1e-12);
    assert!((last.period_s - VAN_DER_POL[3].1).abs() < 1e-8);
    for orbit in &branch.points {
        let count = 4000;
        let samples = sample_orbit(&family, orbit, count, &options);
        // The trapezoidal rule converges fast for a periodic function, but the slopes are steep.
        let sum: f64 = samples
            .iter()
            .map(|(_, state)| orbit.parameter * (1.0 - state[0].powi(2)))
            .sum();
        let logarithm = sum * orbit.period_s / count as f64;
        let found = orbit.multipliers[1].ln_magnitude;
        let error = (found - logarithm).abs() / logarithm.abs();
        // A smaller one is lost in rounding errors.
        let is_small = found.max(logarithm) < -20.0;
        assert!(
            error < 1e-7 || is_small,
            "{}: {found} {logarithm}",
            orbit.parameter
        );
    }
}

/// `r' = r F`, `theta' = 1 + r cos(theta) / 2` with `F = 1/4 - a^2 - (r^2 - 2)^2`: the cycles form a closed curve over `a`,
/// with folds at -1/2 and 1/2.
#[test]
fn a_closed_branch_is_followed_once() {
    let parts = |a: f64, z: &[f64]| {
        let excess = z[0] * z[0] + z[1] * z[1] - 2.0;
        [0.25 - a * a - excess * excess, excess, 1.0 + 0.5 * z[0]]
    };
    let family = autonomous(
        2,
        move |a, z, out| {
            let [growth, _, turn] = parts(a, z);
            out[0] = z[0] * growth - z[1] * turn;
            out[1] = z[1] * growth + z[0] * turn;
        },
        move |a, z, out| {
            let [growth, excess, turn] = parts(a, z);
            let slope = [0, 1].map(|k| -4.0 * excess * z[k]);
            out[0] = growth + z[0] * slope[0] - 0.5 * z[1];
            out[1] = z[0] * slope[1] - turn;
            out[2] = z[1] * slope[0] + turn + 0.5 * z[0];
            out[3] = growth + z[1] * slope[1];
        },
    );
    for start in [0.0, 0.49, 0.499] {
        let options = precise([-1.0, 1.0], 0.1);
        let orbit = settle(&family, start, &[1.6, 0.0], 200.0, &options);
        let branch = follow(&family, orbit, &options);
        assert!(
            branch.ends.contains(&Some(BranchEnd::Closed)),
            "{:?}",
            branch.ends
        );
        let mut folds: Vec<f64> = of_kind(&branch, BifurcationKind::Fold)
            .iter()
            .map(|fold| fold.parameter)
            .collect();
        folds.sort_by(f64::total_cmp);
        let [low, high] = folds[..] else {
            panic!("{folds:?}");
        };
        assert!(
            (low + 0.5).abs() < 1e-8 && (high - 0.5).abs() < 1e-8,
            "{folds:?}"
        );
    }
}

/// `z' = (mu + i) z - |z|^2 z` in a rotated and stretched frame: amplitude `sqrt(mu)`, period `2 pi`, multiplier
/// `exp(-4 pi mu)`.
#[test]
fn the_hopf_normal_form_is_exact_from_its_birth_on() {
    let family = autonomous(
        2,
        |mu, w, out| {
            let r2 = w[0] * w[0] + w[1] * w[1];
            out[0] = mu * w[0] - w[1] - r2 * w[0];
            out[1] = w[0] + mu * w[1] - r2 * w[1];
        },
        |mu, w, out| {
            let r2 = w[0] * w[0] + w[1] * w[1];
            out[0] = mu - r2 - 2.0 * w[0] * w[0];
            out[1] = -1.0 - 2.0 * w[0] * w[1];
            out[2] = 1.0 - 2.0 * w[0] * w[1];
            out[3] = mu - r2 - 2.0 * w[1] * w[1];
        },
    );
    let linearised = Linearised::new(&*family.member(0.0).unwrap().system, &[0.0; 2]).unwrap();
    let modes = linearised.modes().unwrap();
    let options = precise([-0.5, 1.0], 0.5);
    let start = hopf_orbit(&family, (0.0, &linearised, &modes[0]), 0.01, &options).unwrap();
    assert!((start.orbit.parameter - 1e-4).abs() < 1e-9, "{start:?}");
    let branch = follow(&family, start.clone(), &options);
    assert_eq!(branch.ends, [None, Some(BranchEnd::ParameterBound)]);
    assert!(branch.points.len() > 5);
    let mut worst = [0.0_f64; 3];
    for orbit in &branch.points {
        let mu = orbit.parameter;
        let radius = orbit.state[0].hypot(orbit.state[1]);
        let exact = -2.0 * mu * TAU;
        worst[0] = worst[0].max((radius - mu.sqrt()).abs() / mu.sqrt());
        worst[1] = worst[1].max((orbit.period_s - TAU).abs());
        worst[2] = worst[2].max((orbit.multipliers[1].ln_magnitude - exact).abs());
        assert!(orbit.stable, "{orbit:?}");
    }
    eprintln!("{} points, worst {worst:?}", branch.points.len());
    assert!(
        worst[0] < 1e-8 && worst[1] < 1e-8 && worst[2] < 1e-6,
        "{worst:?}"
    );
    // Back to the birth.
    let back = follow(&family, branch.points.last().unwrap().clone(), &options);
    let Some(BranchEnd::Hopf {
        parameter,
        frequency_hz,
    }) = back.ends[0]
    else {
        panic!("{:?}", back.ends);
    };
    assert!(parameter.abs() < 1e-8, "{parameter:e}");
    assert!((frequency_hz * TAU - 1.0).abs() < 1e-8);
}

/// `r' = mu r + r^3 - r^5`: a subcritical Hopf bifurcation and a fold at exactly `mu = -1/4`, `r^2 = 1/2`.
#[test]
fn a_fold_of_cycles_is_passed_and_located() {
    let family = autonomous(
        2,
        |mu, w, out| {
            let r2 = w[0] * w[0] + w[1] * w[1];
            let growth = mu + r2 - r2 * r2;
            out[0] = growth * w[0] - 3.0 * w[1];
            out[1] = growth * w[1] + 3.0 * w[0];
        },
        |mu, w, out| {
            let r2 = w[0] * w[0] + w[1] * w[1];
            let growth = mu + r2 - r2 * r2;
            let slope = 2.0 - 4.0 * r2;
            out[0] = growth + slope * w[0] * w[0];
            out[1] = -3.0 + slope * w[0] * w[1];
            out[2] = 3.0 + slope * w[0] * w[1];
            out[3] = growth + slope * w[1] * w[1];
        },
    );
    let options = precise([-1.0, 1.0], 0.2);
    let orbit = settle(&family, 0.5, &[1.0, 0.0], 50.0, &options);
    assert!(orbit.stable);
    let branch = follow(&family, orbit, &options);
    let folds = of_kind(&branch, BifurcationKind::Fold);
    assert_eq!(folds.len(), 1, "{:?}", branch.bifurcations);
    let fold = folds[0];
    eprintln!(
        "fold {:e} accuracy {:e}, curvature {:?}, {} points",
        fold.parameter + 0.25,
        fold.accuracy,
        fold.fold_curvature,
        branch.points.len()
    );
    assert!((fold.parameter + 0.25).abs() < 1e-9);
    let r2: f64 = fold.orbit.state.iter().map(|x| x * x).sum();
    assert!((r2 - 0.5).abs() < 1e-4);
    assert!(fold.fold_curvature.unwrap() > 0.0, "orbits exist above");
    assert_eq!(branch.bifurcations.len(), 1);
    assert!(branch.unresolved.is_empty());
    let Some(BranchEnd::Hopf { parameter, .. }) = branch.ends[0] else {
        panic!("{:?}", branch.ends);
    };
    assert!(parameter.abs() < 1e-6, "{parameter:e}");
    // Unstable orbits between the Hopf point and the fold.
    for orbit in branch.points.iter().filter(|orbit| orbit.amplitude < 0.69) {
        assert_eq!(orbit.unstable_multipliers, 1, "{orbit:?}");
    }
}

/// A doubled orbit that is found from a settled motion ends where it is born: beyond, the branch would repeat itself.
#[test]
fn a_doubled_branch_ends_at_the_orbit_of_half_its_period() {
    let family = Smooth {
        build: |c| Box::new(crate::known::Roessler { a: 0.2, b: 0.2, c }) as Box<dyn System>,
        drive: None,
    };
    let options = precise([2.2, 3.6], 0.2);
    let single = settle(&family, 2.5, &[2.0, 2.0, 0.1], 300.0, &options);
    let single = follow(&family, single, &options);
    let [birth] = of_kind(&single, BifurcationKind::PeriodDoubling)[..] else {
        panic!("{:?}", single.bifurcations);
    };
    let double = settle(&family, 3.4, &[2.0, 2.0, 0.1], 300.0, &options);
    let double = follow(&family, double, &options);
    let Some(BranchEnd::PeriodHalved { parameter }) = double.ends[0] else {
        panic!("{:?}", double.ends);
    };
    assert!((parameter - birth.parameter).abs() < 1e-6, "{parameter}");
    assert!(of_kind(&double, BifurcationKind::Fold).is_empty());
    assert!(double.points.is_sorted_by(|a, b| a.parameter < b.parameter));
    assert!(double.unresolved.is_empty(), "{:?}", double.unresolved);
}

/// The first period doubling of Rossler's system with a = b = 0.2 and the branch that is born there.
#[test]
fn period_doubling_of_roessler_is_located_and_switched_to() {
    let family = Smooth {
        build: |c| Box::new(crate::known::Roessler { a: 0.2, b: 0.2, c }) as Box<dyn System>,
        drive: None,
    };
    let options = precise([2.2, 4.3], 0.2);
    let orbit = settle(&family, 2.5, &[2.0, 2.0, 0.1], 300.0, &options);
    assert!(orbit.stable);
    let branch = follow(&family, orbit, &options);
    let doublings = of_kind(&branch, BifurcationKind::PeriodDoubling);
    assert_eq!(doublings.len(), 1, "{:?}", branch.bifurcations);
    let first = doublings[0];
    eprintln!("first {} accuracy {:e}", first.parameter, first.accuracy);
    assert_eq!(first.unstable_change, 1);
    assert!(first.crossing_rate.unwrap() > 0.0);
    let start = doubled_orbit(&family, first, 0.02, &options).unwrap();
    let ratio = start.orbit.period_s * first.frequency_hz;
    assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
    let doubled = follow(&family, start, &options);
    // Supercritical: the doubled orbit is stable where the single one is not.
    assert!(doubled.points[0].stable && doubled.points[0].parameter > first.parameter);
    let next = of_kind(&doubled, BifurcationKind::PeriodDoubling);
    eprintln!(
        "second {:?} ends {:?}",
        next.iter().map(|b| b.parameter).collect::<Vec<_>>(),
        doubled.ends
    );
    assert!(!next.is_empty());
    // Both are confirmed by simulations on either side: the period doubles.
    for (at, factor) in [(first.parameter, 1.0), (next[0].parameter, 2.0)] {
        for (offset, times) in [(-0.02, factor), (0.02, 2.0 * factor)] {
            let c = at + offset;
            // Close to a period doubling the new orbit nearly returns after the old period.
            let search = ReturnSearch {
                settle_s: 4000.0,
                max_period_s: 100.0,
                tolerance: 1e-3,
            };
            let state = [2.0, 2.0, 0.1];
            let settled = settled_orbit(&family, c, &state, &search, &options).unwrap();
            let ratio = settled.period_s * first.frequency_hz;
            assert!((ratio / times - 1.0).abs() < 0.1, "{c}: {ratio}");
            assert!(settled.stable);
        }
    }
}
