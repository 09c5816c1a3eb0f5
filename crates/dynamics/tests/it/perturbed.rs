//! A perturbed trajectory on the steps of the reference trajectory.

use super::*;
use crate::known::Lorenz;
use squeakscope_dynamics::DynamicsError;
use squeakscope_joint::systems::ImpactOscillator;

/// Initial distance: far below the tolerances, far above the rounding of the states.
const INITIAL_DISTANCE: f64 = 1e-7;

#[test]
fn a_perturbed_trajectory_follows_the_tangent_vector_at_coarse_steps() {
    let sys = Lorenz::CLASSICAL;
    for method in all_methods(1e-5, 0.1, 0.01) {
        let mut motion = Integrator::new(method, sys)
            .unwrap()
            .with_tangents(1, 1)
            .unwrap();
        motion.start(0.0, &[1.0, -2.0, 17.0]).unwrap();
        motion.integrate_to(3.0).unwrap();
        let direction = [0.6, 0.0, -0.8];
        motion.set_tangent_vectors(&direction).unwrap();
        let there = motion.state().to_vec();
        let z: Vec<f64> = (0..3)
            .map(|k| there[k] + INITIAL_DISTANCE * direction[k])
            .collect();
        motion.add_perturbed(&z).unwrap();
        assert_eq!(motion.perturbed_since(), Some(3.0));
        let (mut reference, mut nearby) = ([0.0; 3], [0.0; 3]);
        for k in 1..=400 {
            // Every seventh sample a step end is requested, which reverts a step.
            let t = 3.0 + 0.01 * f64::from(k);
            motion.sample(t, &mut reference).unwrap();
            motion.sample_perturbed(t, &mut nearby).unwrap();
            if k % 7 == 0 {
                motion.integrate_to(t).unwrap();
            }
        }
        motion.integrate_to(7.0).unwrap();
        let vector = motion.tangent_vectors().unwrap().to_vec();
        motion.sample_perturbed(7.0, &mut nearby).unwrap();
        let state = motion.state();
        let expected: Vec<f64> = (0..3)
            .map(|k| state[k] + INITIAL_DISTANCE * vector[k])
            .collect();
        let length = INITIAL_DISTANCE * vector.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        // The nonlinearity of the flow is of order 1e-6, and one unit of rounding is 1e-5 of the
        // distance.
        let deviation = distance(&nearby, &expected) / length;
        assert!(deviation < 1e-4, "{method:?}: {deviation:e}");
    }
}

#[test]
fn a_perturbed_trajectory_locates_its_own_events() {
    let sys = ImpactOscillator {
        omega: 1.0,
        damping: 0.02,
        drive: 1.0,
        drive_omega: 2.8,
        drive_phase: 0.0,
        wall: 0.0,
        restitution: 0.8,
    };
    let z0: &[f64] = &[0.3, 1.0];
    for method in all_methods(1e-9, 0.1, 0.002) {
        let start = |z: &[f64]| {
            let motion = Integrator::new(method, sys).unwrap();
            let mut motion = motion.with_events().unwrap();
            motion.start(0.0, z).unwrap();
            motion
        };
        let mut perturbed: Vec<f64> = z0.to_vec();
        perturbed[0] += 1e-3;
        let mut pair = start(z0);
        pair.add_perturbed(&perturbed).unwrap();
        let mut perturbed_alone = start(&perturbed);
        let mut reference = start(z0);
        let (mut a, mut b, mut c) = (z0.to_vec(), z0.to_vec(), z0.to_vec());
        for k in 1..2000 {
            let t = 0.01 * f64::from(k);
            pair.sample_perturbed(t, &mut a).unwrap();
            perturbed_alone.sample(t, &mut b).unwrap();
            assert!(distance(&a, &b) < 1e-6, "{method:?} at {t}: {a:?} {b:?}");
            // The reference trajectory must not be affected.
            pair.sample(t, &mut b).unwrap();
            reference.sample(t, &mut c).unwrap();
            assert_eq!(b, c);
        }
        assert_eq!(pair.stats(), reference.stats());
        assert!(perturbed_alone.stats().crossings > 0);
    }
}

#[test]
fn a_perturbed_trajectory_advances_without_being_sampled() {
    let sys = Lorenz::CLASSICAL;
    let method = all_methods(1e-6, 0.1, 0.01)[0];
    let motion = |sampled: bool| {
        let mut motion = Integrator::new(method, sys).unwrap();
        motion.start(0.0, &[1.0, -2.0, 17.0]).unwrap();
        motion
            .add_perturbed(&[1.0, -2.0, 17.0 + INITIAL_DISTANCE])
            .unwrap();
        let mut z = [0.0; 3];
        for k in 1..500 {
            let t = 0.02 * f64::from(k);
            motion.sample(t, &mut z).unwrap();
            if sampled || k == 499 {
                motion.sample_perturbed(t, &mut z).unwrap();
            }
        }
        z
    };
    assert_eq!(motion(true), motion(false));
}

#[test]
fn a_perturbed_trajectory_is_dropped_when_time_is_reverted_before_its_start() {
    let sys = Lorenz::CLASSICAL;
    for method in all_methods(1e-6, 0.1, 0.01) {
        let mut motion = Integrator::new(method, sys).unwrap();
        motion.start(0.0, &[1.0, -2.0, 17.0]).unwrap();
        let mut z = [0.0; 3];
        motion.sample(1.0, &mut z).unwrap();
        let there = motion.state().to_vec();
        motion.add_perturbed(&there).unwrap();
        let since = motion.perturbed_since().unwrap();
        assert!(since >= 1.0);
        motion.integrate_to(1.0).unwrap();
        let none = if since > 1.0 { None } else { Some(1.0) };
        assert_eq!(motion.perturbed_since(), none, "{method:?}");
        if none.is_none() {
            let missing = motion.sample_perturbed(1.0, &mut z);
            assert!(matches!(
                missing,
                Err(DynamicsError::MissingCapability { .. })
            ));
        }
    }
}
