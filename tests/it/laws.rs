//! The joint's laws on a system whose motion is known exactly: a mass on a moving belt.

use squeakscope::dynamics::{Accuracy, Integrator, Method};
use squeakscope::joint::{Friction, Joint, Model};

/// Mass, spring and normal load of one on a belt at 0.2 (project's reference numbers: slip time
/// 3.9026054, stick time 5, amplitude 0.5385165 for friction that falls at once from 1 to 0.5).
/// `sharpness` (s/m) says how fast Eq. (5) falls; its creep region is a hundred times steeper.
fn belt(sharpness: f64) -> Joint {
    Joint::new(&Model {
        positions: vec![[0.0, 0.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0]],
        areas: vec![1.0],
        pre_stress: vec![1.0],
        stiffness: vec![1.0],
        shapes: vec![[1.0, 0.0, 0.0]],
        omega: vec![1.0],
        damping: vec![],
        sliding_velocity: vec![[-0.2, 0.0, 0.0]],
        friction: Friction::Stribeck {
            mu_s: 1.0,
            mu_d: 0.5,
            creep: 100.0 * sharpness,
            stribeck: sharpness,
            radial: true,
        },
        unilateral: true,
        probe: vec![1.0],
    })
}

struct Cycle {
    period: f64,
    amplitude: f64,
    stuck: f64,
}

/// The settled stick-slip cycle, started on the belt.
fn cycle(sharpness: f64) -> Cycle {
    let joint = belt(sharpness);
    let method = Method::Lawson54 { accuracy: Accuracy::relative(1e-7), max_step: 0.01 };
    let mut integrator = Integrator::new(method, &joint).unwrap();
    integrator.start(&joint, 0.0, &[0.0, 0.2]).unwrap();
    let dt = 1e-3;
    let mut z = [0.0; 2];
    let (mut low, mut high, mut stuck) = (f64::MAX, f64::MIN, 0.0);
    let mut crossings = Vec::new();
    let mut before = 0.0;
    for k in 1..=30_000 {
        let t = f64::from(k) * dt;
        integrator.sample(&joint, t, &mut z).unwrap();
        // From the second crossing on it has settled: one stick erases all memory.
        if before < 0.0 && z[0] >= 0.0 {
            crossings.push(t - dt * z[0] / (z[0] - before));
        }
        if crossings.len() == 2 {
            low = low.min(z[0]);
            high = high.max(z[0]);
            stuck += if (z[1] - 0.2).abs() < joint.stick_speed().max(1e-3) { dt } else { 0.0 };
        }
        before = z[0];
    }
    assert!(crossings.len() >= 3, "{} cycles", crossings.len());
    Cycle { period: crossings[2] - crossings[1], amplitude: 0.5 * (high - low), stuck }
}

/// The smoothed law approaches the sharp one's cycle at first order in the creep speed.
#[test]
fn stick_slip_of_a_mass_on_a_belt() {
    let (blunt, sharp) = (cycle(300.0), cycle(1200.0));
    let errors = |c: &Cycle| [c.period / 8.902_605_4 - 1.0, c.amplitude / 0.538_516_5 - 1.0];
    for (blunt, sharp) in errors(&blunt).into_iter().zip(errors(&sharp)) {
        assert!(sharp.abs() < 0.01, "{sharp}");
        assert!(sharp.abs() < 0.5 * blunt.abs(), "{blunt} {sharp}");
    }
    assert!((sharp.stuck - 5.0).abs() < 0.1, "{}", sharp.stuck);
}
