//! Contact damping and `Omega x u`: derivatives, work and impacts.

use super::*;

/// Models with each term and with both, with separation and slip.
fn models() -> Vec<Model> {
    let dampings = [
        ContactDamping::None,
        ContactDamping::KelvinVoigt { time: 2e-7 },
        ContactDamping::HuntCrossley { dissipation: 5.0 },
        // Strong enough to end the force of closed nodes.
        ContactDamping::KelvinVoigt { time: 5e-5 },
        ContactDamping::HuntCrossley { dissipation: 200.0 },
    ];
    let mut models = Vec::new();
    for friction in frictions() {
        for contact_damping in dampings {
            for convection in [None, Some([900.0, -300.0, 500.0])] {
                for unilateral in [true, false] {
                    models.push(Model {
                        contact_damping,
                        convection,
                        unilateral,
                        ..scattered(19, 6, friction.clone())
                    });
                }
            }
        }
    }
    models
}

#[test]
fn products_are_the_derivative_of_the_force() {
    for model in models() {
        let joint = Joint::new(&model);
        let m = joint.modes();
        let z = state(&joint, 23);
        let mut record = vec![0.0; joint.record_len()];
        let jacobian = jacobian(&joint, &z);
        let rate = |z: &[f64]| {
            let mut rate = vec![0.0; joint.dim()];
            joint.rhs(0.0, z, &mut rate);
            rate
        };
        for j in 0..2 * m {
            // Small relative to the distances to separation.
            let step = if j < m { 1e-13 } else { 1e-8 };
            let moved = |by: f64| {
                let mut z = z.clone();
                z[j] += by;
                rate(&z)
            };
            let [after, before] = [moved(step), moved(-step)];
            let column = || (m..2 * m).map(|i| jacobian[i * 2 * m + j]);
            let size = column().fold(0.0, |a: f64, b| a.max(b.abs()));
            for (i, got) in column().enumerate() {
                let want = (after[m + i] - before[m + i]) / (2.0 * step);
                assert!(
                    (got - want).abs() < 1e-4 * size,
                    "{:?} {:?}: {got} {want}",
                    model.contact_damping,
                    model.convection
                );
            }
        }
        // The product for tangent vectors agrees with the matrix.
        let vectors: Vec<f64> = (0..2 * m).map(|k| (k as f64).sin()).collect();
        let mut out = vec![0.0; m];
        let mut force = vec![0.0; m];
        joint.force_recorded(None, 0.0, &z, &mut force, &mut record);
        joint.product(None, &mut record, &vectors, 1, &mut out);
        for i in 0..m {
            let row = &jacobian[(m + i) * 2 * m..][..2 * m];
            let mut want: f64 = row.iter().zip(&vectors).map(|(a, b)| a * b).sum();
            // The force excludes modal stiffness and damping.
            want += joint.omega()[i].powi(2) * vectors[i];
            want += 2.0 * joint.damping()[i] * joint.omega()[i] * vectors[m + i];
            assert!((out[i] - want).abs() < 1e-9 * want.abs().max(1e6), "{i}");
        }
    }
}

/// The change of energy is the work of friction, contact damping and modal damping; contact damping never supplies
/// energy.
#[test]
fn energy_changes_by_the_work() {
    for model in models() {
        let joint = Joint::new(&model);
        let m = joint.modes();
        let z = state(&joint, 29);
        let power = joint.power(&z);
        let mut rate = vec![0.0; joint.dim()];
        joint.rhs(0.0, &z, &mut rate);
        let step = 1e-13;
        let moved = |by: f64| {
            let z: Vec<f64> = z.iter().zip(&rate).map(|(z, r)| z + by * r).collect();
            joint.energy(&z).total()
        };
        let change = (moved(step) - moved(-step)) / (2.0 * step);
        let total = power.friction + power.contact_damping + power.damping;
        let size = [power.friction, power.contact, power.contact_damping]
            .into_iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!((change - total).abs() < 1e-4 * size, "{change} {total}");
        let damped = !model.contact_damping.is_none();
        if model.unilateral {
            assert_eq!(power.contact_damping < 0.0, damped, "{m} modes");
        }
    }
}

/// Optional terms do not change the equilibrium.
#[test]
fn equilibrium_is_unchanged() {
    for friction in frictions() {
        let plain = Joint::new(&scattered(19, 6, friction.clone()));
        for model in models().iter().filter(|model| model.friction == friction) {
            assert_eq!(Joint::new(model).equilibrium(), plain.equilibrium());
        }
    }
}

/// Impact of one mode on one node: coefficient of restitution of Hunt and Crossley, `1 - 2 chi v / 3` for slow
/// impacts, and of a spring with a dashpot, `exp(-zeta omega t)` with `t` the time at which the force ends
/// (T. Schwager, T. Poeschel, Granular Matter 9 (2007) 465).
#[test]
fn impacts_have_the_restitution_of_the_laws() {
    let speed = 1e-3;
    // Half a period is 31 us.
    let stiffness: f64 = 1e10;
    let model = |contact_damping| Model {
        positions: vec![[0.0, 0.0, 1e-2]],
        normals: vec![[0.0, 0.0, 1.0]],
        areas: vec![1.0],
        pre_stress: vec![1e-9],
        stiffness: vec![stiffness],
        shapes: vec![[0.0, 0.0, 1.0]],
        omega: vec![1e-3],
        damping: Vec::new(),
        sliding_velocity: vec![[0.0; 3]],
        probe: vec![1.0],
        friction: Friction::None,
        unilateral: true,
        contact_damping,
        convection: None,
    };
    let leaves = |damping| {
        let joint = Joint::new(&model(damping));
        let (mut x, mut v) = (0.0, speed);
        let step = 1e-9;
        let acceleration = |x: f64, v: f64| {
            let mut force = [0.0];
            joint.force(0.0, &[x, v], &mut force);
            force[0]
        };
        while x >= 0.0 {
            // Midpoint rule.
            let (half_x, half_v) = (x + 0.5 * step * v, v + 0.5 * step * acceleration(x, v));
            x += step * half_v;
            v += step * acceleration(half_x, half_v);
        }
        -v / speed
    };
    assert!((leaves(ContactDamping::None) - 1.0).abs() < 1e-4);
    for dissipation in [5.0, 20.0] {
        let e = leaves(ContactDamping::HuntCrossley { dissipation });
        // Within the next order in chi v.
        let x = dissipation * speed;
        let want = 1.0 - 2.0 / 3.0 * x;
        assert!((e - want).abs() < 0.6 * x * x + 1e-4, "{e} {want}");
    }
    for zeta in [0.05_f64, 0.3] {
        let time = 2.0 * zeta / stiffness.sqrt();
        let e = leaves(ContactDamping::KelvinVoigt { time });
        // In units of the undamped angular frequency.
        let frequency = (1.0 - zeta * zeta).sqrt();
        let lag = (2.0 * zeta * frequency).atan2(frequency.powi(2) - zeta * zeta);
        let want = (-zeta * (std::f64::consts::PI - lag) / frequency).exp();
        assert!((e - want).abs() < 1e-4, "{e} {want}");
    }
}
