//! A second motion on the steps of a first one.

use super::*;
use crate::dynamics::DynamicsError;
use crate::systems::{ImpactOscillator, Lorenz};

/// Far below the tolerances, far above the rounding of the states.
const APART: f64 = 1e-7;

#[test]
fn a_neighbour_is_where_the_tangent_vector_points_however_coarse_the_steps() {
    let sys = Lorenz::CLASSICAL;
    for method in all_methods(1e-5, 0.1, 0.01) {
        let mut motion = Integrator::new(method, &sys)
            .unwrap()
            .with_tangents(&sys, 1, 1)
            .unwrap();
        motion.start(&sys, 0.0, &[1.0, -2.0, 17.0]).unwrap();
        motion.land(&sys, 3.0).unwrap();
        let direction = [0.6, 0.0, -0.8];
        motion.follow_vectors(&direction).unwrap();
        let there = motion.state().to_vec();
        let z: Vec<f64> = (0..3).map(|k| there[k] + APART * direction[k]).collect();
        motion.add_neighbour(&sys, &z).unwrap();
        assert_eq!(motion.neighbour_since(), Some(3.0));
        let (mut first, mut second) = ([0.0; 3], [0.0; 3]);
        for k in 1..=400 {
            // Every few samples the motion lands, which takes a step back.
            let t = 3.0 + 0.01 * f64::from(k);
            motion.sample(&sys, t, &mut first).unwrap();
            motion.sample_neighbour(&sys, t, &mut second).unwrap();
            if k % 7 == 0 {
                motion.land(&sys, t).unwrap();
            }
        }
        motion.land(&sys, 7.0).unwrap();
        let vector = motion.tangent_vectors().unwrap().to_vec();
        motion.sample_neighbour(&sys, 7.0, &mut second).unwrap();
        let state = motion.state();
        let expected: Vec<f64> = (0..3).map(|k| state[k] + APART * vector[k]).collect();
        let length = APART * vector.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        // The flow bends by a millionth, and a unit of rounding is 1e-5 of the distance.
        let off = distance(&second, &expected) / length;
        // Vectors beside implicit steps follow the flow, and not the steps.
        let allowed = if motion.is_implicit() { 1e-3 } else { 1e-4 };
        assert!(off < allowed, "{method:?}: {off:e}");
    }
}

#[test]
fn a_neighbour_stops_at_its_own_events() {
    let sys = ImpactOscillator {
        omega: 1.0,
        damping: 0.02,
        drive: 1.0,
        drive_omega: 2.8,
        wall: 0.0,
        restitution: 0.8,
    };
    let z0: &[f64] = &[0.3, 1.0];
    for method in all_methods(1e-9, 0.1, 0.002) {
        let start = |z: &[f64]| {
            let motion = Integrator::new(method, &sys).unwrap();
            let mut motion = motion.with_events(&sys).unwrap();
            motion.start(&sys, 0.0, z).unwrap();
            motion
        };
        let mut beside: Vec<f64> = z0.to_vec();
        beside[0] += 1e-3;
        let mut both = start(z0);
        both.add_neighbour(&sys, &beside).unwrap();
        let mut alone = start(&beside);
        let mut first = start(z0);
        let (mut a, mut b, mut c) = (z0.to_vec(), z0.to_vec(), z0.to_vec());
        for k in 1..2000 {
            let t = 0.01 * f64::from(k);
            both.sample_neighbour(&sys, t, &mut a).unwrap();
            alone.sample(&sys, t, &mut b).unwrap();
            assert!(distance(&a, &b) < 1e-6, "{method:?} at {t}: {a:?} {b:?}");
            // The first motion does not notice.
            both.sample(&sys, t, &mut b).unwrap();
            first.sample(&sys, t, &mut c).unwrap();
            assert_eq!(b, c);
        }
        assert_eq!(both.tally(), first.tally());
        assert!(alone.tally().crossings > 0);
    }
}

#[test]
fn a_neighbour_that_is_not_looked_at_keeps_up() {
    let sys = Lorenz::CLASSICAL;
    let method = all_methods(1e-6, 0.1, 0.01)[0];
    let motion = |look: bool| {
        let mut motion = Integrator::new(method, &sys).unwrap();
        motion.start(&sys, 0.0, &[1.0, -2.0, 17.0]).unwrap();
        motion
            .add_neighbour(&sys, &[1.0, -2.0, 17.0 + APART])
            .unwrap();
        let mut z = [0.0; 3];
        for k in 1..500 {
            let t = 0.02 * f64::from(k);
            motion.sample(&sys, t, &mut z).unwrap();
            if look || k == 499 {
                motion.sample_neighbour(&sys, t, &mut z).unwrap();
            }
        }
        z
    };
    assert_eq!(motion(true), motion(false));
}

#[test]
fn a_neighbour_goes_when_the_motion_goes_back_before_it() {
    let sys = Lorenz::CLASSICAL;
    for method in all_methods(1e-6, 0.1, 0.01) {
        let mut motion = Integrator::new(method, &sys).unwrap();
        motion.start(&sys, 0.0, &[1.0, -2.0, 17.0]).unwrap();
        let mut z = [0.0; 3];
        motion.sample(&sys, 1.0, &mut z).unwrap();
        let there = motion.state().to_vec();
        motion.add_neighbour(&sys, &there).unwrap();
        let since = motion.neighbour_since().unwrap();
        assert!(since >= 1.0);
        motion.land(&sys, 1.0).unwrap();
        let none = if since > 1.0 { None } else { Some(1.0) };
        assert_eq!(motion.neighbour_since(), none, "{method:?}");
        if none.is_none() {
            let missing = motion.sample_neighbour(&sys, 1.0, &mut z);
            assert!(matches!(missing, Err(DynamicsError::Lacks { .. })));
        }
    }
}
