//! The hot loop compared with a scalar implementation of Eq. (8): every law and effect, every remainder of nodes,
//! every supported instruction set.

use super::*;
use squeakscope_dynamics::Switching;

/// A model in which every third node has no steady slip.
fn model(nodes: usize, modes: usize, friction: Friction, unilateral: bool) -> Model {
    let mut model = Model {
        unilateral,
        ..scattered(nodes, modes, friction)
    };
    for velocity in model.sliding_velocity.iter_mut().step_by(3) {
        *velocity = [0.0; 3];
    }
    model
}

/// The joint with the built-in law, and with an equivalent custom law.
fn built(model: &Model) -> Vec<Joint> {
    let mut joints = vec![Joint::new(model).with_audit()];
    let radial = model.friction.radial();
    let own: Option<Arc<dyn FrictionLaw>> = match model.friction.clone() {
        Friction::None | Friction::Dynamic { .. } => None,
        Friction::Stribeck { law, .. } => Some(Arc::new(law)),
        Friction::Table { law, .. } => Some(law),
        Friction::Custom { law, .. } => Some(law),
    };
    joints.extend(own.map(|law| Joint::with_friction(model, law, radial).with_audit()));
    joints
}

/// States: half of the nodes separated and all moving; no motion; steady sliding.
fn states(joint: &Joint) -> [Vec<f64>; 3] {
    let m = joint.modes();
    let moving = state(joint, 17);
    let mut held = moving.clone();
    held[m..].fill(0.0);
    let steady = vec![0.0; moving.len()];
    [moving, held, steady]
}

/// Power of the deviation of friction from steady sliding, and the sum of its absolute contributions.
fn friction_power(joint: &Joint, z: &[f64]) -> (f64, f64) {
    let m = joint.modes();
    let rest = vec![0.0; m];
    let (mut power, mut size) = (0.0, 0.0);
    for k in 0..joint.contact_nodes() {
        let action = joint.node_action(k, &z[..m], &z[m..2 * m], &[]);
        let steady = joint.node_action(k, &rest, &rest, &[]);
        // The vibration only: zero displacement excludes `Omega x u`.
        let moving = joint.node_action(k, &rest, &z[m..2 * m], &[]);
        for c in 0..3 {
            let vibration = moving.slip[c] - steady.slip[c];
            power += (action.friction[c] - steady.friction[c]) * vibration;
            size += (action.friction[c].abs() + steady.friction[c].abs()) * vibration.abs();
        }
        let rate = moving.slip[2] - steady.slip[2];
        power -= action.dashpot * rate;
        size += (action.dashpot * rate).abs();
    }
    (power, size)
}

fn assert_scalar(model: &Model, joint: &Joint, z: &[f64], case: &str) {
    let m = joint.modes();
    let (q, v) = (&z[..m], &z[m..2 * m]);
    let mut got = vec![0.0; m + 1];
    joint.force(0.0, z, &mut got);
    let (want, steady) = (equation_8(model, q, v), &joint.equilibrium().force);
    let size = want
        .iter()
        .chain(steady)
        .fold(0.0, |a: f64, b| a.max(b.abs()));
    for ((got, want), steady) in got.iter().zip(&want).zip(steady) {
        let want = want - steady;
        assert!((got - want).abs() <= 1e-12 * size, "{case}: {got} {want}");
    }
    let (power, size) = friction_power(joint, z);
    let lost = got[m] - joint.damping_power(v);
    assert!(
        (lost - power).abs() <= 1e-12 * size,
        "{case}: {lost} {power}"
    );

    // A record and a fixed status leave the force bit-identical.
    let (mut again, mut record) = (vec![1.0; m + 1], vec![0.0; joint.record_len()]);
    joint.force_recorded(None, 0.0, z, &mut again, &mut record);
    assert_eq!(got, again, "{case}: recorded");
    let mut status = vec![0; joint.status_len()];
    joint.status_of(0.0, z, &mut status);
    joint.force_in(&status, 0.0, z, &mut again);
    assert_eq!(got, again, "{case}: fixed status");
}

#[test]
fn hot_loop_and_scalar_loop_agree() {
    for nodes in 1..=70 {
        let modes = [11, 4, 13][nodes % 3];
        for friction in frictions() {
            for unilateral in [true, false] {
                let mut model = model(nodes, modes, friction.clone(), unilateral);
                // With contact damping, with `Omega x u` (exaggerated), with both.
                let optional = (nodes + usize::from(unilateral)) % 10;
                model.contact_damping = [
                    ContactDamping::None,
                    ContactDamping::KelvinVoigt { time: 2e-6 },
                    ContactDamping::HuntCrossley { dissipation: 5.0 },
                    ContactDamping::KelvinVoigt { time: 5e-5 },
                    ContactDamping::HuntCrossley { dissipation: 200.0 },
                ][optional % 5];
                model.convection = (optional > 4).then_some([900.0, -300.0, 500.0]);
                for mut joint in built(&model) {
                    for machine in machines() {
                        joint.arch = machine;
                        for (kind, z) in states(&joint).iter().enumerate() {
                            let case = format!(
                                "{nodes} nodes, {friction:?}, optional terms {optional}, {machine:?}, state {kind}"
                            );
                            assert_scalar(&model, &joint, z, &case);
                        }
                    }
                }
            }
        }
    }
}
