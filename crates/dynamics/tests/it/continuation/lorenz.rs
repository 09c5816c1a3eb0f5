//! The Lorenz system: from the subcritical Hopf point to the homoclinic orbit, and its symmetry breaking.

use super::systems::Smooth;
use super::*;
use crate::known::Lorenz;
use squeakscope_dynamics::System;
use squeakscope_dynamics::equilibrium::Linearised;

const SIGMA: f64 = 10.0;
const BETA: f64 = 8.0 / 3.0;

/// The family over rho.
fn family() -> Smooth<impl Fn(f64) -> Box<dyn System>> {
    Smooth {
        build: |rho| {
            Box::new(Lorenz {
                rho,
                ..Lorenz::CLASSICAL
            }) as Box<dyn System>
        },
        drive: None,
    }
}

/// The orbit born at rho = 24.7368 is unstable, exists below it, and its period grows without limit towards the homoclinic
/// orbit at rho = 13.926 (C. Sparrow, The Lorenz Equations, Springer 1982).
#[test]
fn the_orbit_of_the_subcritical_hopf_point_approaches_the_homoclinic_orbit() {
    let family = family();
    // The Hopf point of an equilibrium off the origin.
    let rho = SIGMA * (SIGMA + BETA + 3.0) / (SIGMA - BETA - 1.0);
    assert!((rho - 24.736_842_1).abs() < 1e-7);
    let x = (BETA * (rho - 1.0)).sqrt();
    let omega = (BETA * (SIGMA + rho)).sqrt();
    let system = family.member(rho).unwrap().system;
    let linearised = Linearised::new(&*system, &[x, x, rho - 1.0]).unwrap();
    let modes = linearised.modes().unwrap();
    let mode = modes.iter().find(|mode| mode.oscillates()).unwrap();
    assert!(mode.value.re.abs() < 1e-10 && (mode.value.im / omega - 1.0).abs() < 1e-10);
    // Near the origin the motion is slow, and only the maximum step resolves the contraction.
    let options = precise([13.926_64, 30.0], 0.02);
    let start = hopf_orbit(&family, (rho, &linearised, mode), 0.3, &options).unwrap();
    assert!(start.orbit.parameter < rho);
    let branch = follow(&family, start, &options);
    let last = branch.points.last().unwrap();
    eprintln!(
        "{} points, last rho {} period {}, {:?}, {:?}",
        branch.points.len(),
        last.parameter,
        last.period_s,
        branch.ends,
        branch.newton_iterations
    );
    assert!(matches!(branch.ends[1], Some(BranchEnd::ParameterBound)));
    assert!(last.period_s > 5.0, "{}", last.period_s);
    assert!(branch.bifurcations.is_empty(), "{:?}", branch.bifurcations);
    for orbit in &branch.points {
        assert_eq!(orbit.unstable_multipliers, 1, "{}", orbit.parameter);
        // The error of the multipliers is relative to the largest one.
        let error = orbit.trivial_multiplier_error.unwrap();
        assert!(error < 1e-6 * orbit.multipliers[0].magnitude(), "{error:e}");
        // The product of all multipliers is that of the constant divergence. A smaller one is lost in rounding errors.
        let sum: f64 = orbit.multipliers.iter().map(|m| m.ln_magnitude).sum();
        let exact = -(SIGMA + BETA + 1.0) * orbit.period_s;
        let is_small = sum.max(exact) < -20.0;
        assert!(
            (sum / exact - 1.0).abs() < 1e-7 || is_small,
            "{sum} {exact}"
        );
    }
    let periods = branch.points.windows(2);
    assert!(
        periods
            .into_iter()
            .all(|pair| pair[1].period_s > pair[0].period_s)
    );
    // Back to the Hopf point.
    let back = follow(
        &family,
        branch.points[branch.points.len() / 2].clone(),
        &options,
    );
    let end = back
        .ends
        .iter()
        .flatten()
        .find_map(|end| match end {
            BranchEnd::Hopf {
                parameter,
                frequency_hz,
            } => Some((*parameter, *frequency_hz)),
            _ => None,
        })
        .unwrap_or_else(|| panic!("{:?}", back.ends));
    eprintln!("Hopf error {:e}", end.0 - rho);
    assert!((end.0 - rho).abs() < 1e-5, "{end:?}");
    assert!((end.1 * std::f64::consts::TAU / omega - 1.0).abs() < 1e-5);
}

/// For large rho the attractor is a symmetric orbit. It breaks its symmetry as rho decreases through 312.97 (Sparrow 1982).
#[test]
fn the_symmetric_orbit_at_large_rho_breaks_its_symmetry() {
    let family = family();
    let options = precise([300.0, 330.0], 0.05);
    let orbit = settle(&family, 325.0, &[1.0, 2.0, 325.0], 40.0, &options);
    // Distance between the mirrored state and the state half a period later.
    let asymmetry = |orbit: &PeriodicOrbit| {
        let samples = sample_orbit(&family, orbit, 2, &options);
        let [start, half] = [&samples[0].1, &samples[1].1];
        (start[0] + half[0])
            .hypot(start[1] + half[1])
            .hypot(start[2] - half[2])
    };
    assert!(asymmetry(&orbit) < 1e-6);
    let branch = follow(&family, orbit, &options);
    let found: Vec<_> = branch
        .bifurcations
        .iter()
        .map(|b| (b.kind, b.parameter))
        .collect();
    eprintln!("{found:?} {:?} {} points", branch.ends, branch.points.len());
    let breaking = of_kind(&branch, BifurcationKind::BranchPoint);
    assert_eq!(breaking.len(), 1, "{found:?}");
    assert!((breaking[0].parameter - 312.97).abs() < 0.1);
    eprintln!("accuracy {:e}", breaking[0].accuracy);
    // Supercritical: below, the stable orbits have no symmetry.
    let [near, far] =
        [312.6, 312.0].map(|rho| settle(&family, rho, &[1.0, 2.0, rho], 80.0, &options));
    let [at_near, at_far] = [&near, &far].map(asymmetry);
    eprintln!("asymmetry {at_near} and {at_far}");
    assert!(near.stable && far.stable);
    assert!((far.period_s * breaking[0].frequency_hz - 1.0).abs() < 0.02);
    assert!(at_near > 1.0 && at_far > 1.0, "{at_near} {at_far}");
}
