//! The hot loop against Eq. (8) in plain scalars: every law and effect, every number of nodes that leaves
//! another tail, on every machine that this one can be.

use super::*;
use crate::dynamics::Switching;
use crate::joint::lanes::machines;

/// A model in which every third node does not slide, so that its slip is zero where nothing moves.
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

/// The joint as it is built in, and by a law of one's own that says the same.
fn built(model: &Model) -> Vec<Joint> {
    let mut joints = vec![Joint::new(model).with_audit()];
    let radial = model.friction.radial();
    let own: Option<Arc<dyn FrictionLaw>> = match model.friction {
        Friction::None => None,
        Friction::Constant { law, .. } => Some(Arc::new(law)),
        Friction::Stribeck { law, .. } => Some(Arc::new(law)),
    };
    joints.extend(own.map(|law| Joint::with_friction(model, law, radial).with_audit()));
    joints
}

/// Half of the nodes open and all moving; nothing moving; and all as it is in steady sliding.
fn states(joint: &Joint) -> [Vec<f64>; 3] {
    let m = joint.modes();
    let moving = state(joint, 17);
    let mut held = moving.clone();
    held[m..].fill(0.0);
    let steady = vec![0.0; moving.len()];
    [moving, held, steady]
}

/// Power of friction's deviation from steady sliding, and how large what it sums is, node by node.
fn friction_power(joint: &Joint, z: &[f64]) -> (f64, f64) {
    let m = joint.modes();
    let rest = vec![0.0; m];
    let (mut power, mut size) = (0.0, 0.0);
    for k in 0..joint.contact_nodes() {
        let action = joint.node_action(k, &z[..m], &z[m..2 * m]);
        let steady = joint.node_action(k, &rest, &rest);
        // The vibration alone: with no displacement there is no `Omega x u`.
        let moving = joint.node_action(k, &rest, &z[m..2 * m]);
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

    // With a record, and with the status held, to the last bit.
    let (mut again, mut record) = (vec![1.0; m + 1], vec![0.0; joint.record_len()]);
    joint.force_recorded(None, 0.0, z, &mut again, &mut record);
    assert_eq!(got, again, "{case}: recorded");
    let mut status = vec![0; joint.status_len()];
    joint.status_of(0.0, z, &mut status);
    joint.force_in(&status, 0.0, z, &mut again);
    assert_eq!(got, again, "{case}: held");
}

#[test]
fn the_hot_loop_is_the_scalar_loop() {
    for nodes in 1..=70 {
        let modes = [11, 4, 13][nodes % 3];
        for friction in frictions() {
            for unilateral in [true, false] {
                let mut model = model(nodes, modes, friction, unilateral);
                // With damping of the contact, with `Omega x u` (much faster than it is), with both.
                let extras = (nodes + usize::from(unilateral)) % 6;
                model.contact_damping = [
                    ContactDamping::None,
                    ContactDamping::KelvinVoigt { time: 2e-6 },
                    ContactDamping::HuntCrossley { dissipation: 5.0 },
                ][extras % 3];
                model.convection = (extras > 2).then_some([900.0, -300.0, 500.0]);
                for mut joint in built(&model) {
                    for machine in machines() {
                        joint.arch = machine;
                        for (kind, z) in states(&joint).iter().enumerate() {
                            let case = format!(
                                "{nodes} nodes, {friction:?}, extras {extras}, {machine:?}, state {kind}"
                            );
                            assert_scalar(&model, &joint, z, &case);
                        }
                    }
                }
            }
        }
    }
}
