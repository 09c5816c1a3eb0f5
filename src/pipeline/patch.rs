//! The contact patch of a run: its pictures.

use super::message::{NodeState, PatchGeometry, PatchSnapshot};
use crate::joint::{BallJoint, Joint, Model};

/// The nodes of a model at a tilt (rad).
pub(super) fn patch_geometry(ball: &BallJoint, model: Model, tilt: f64) -> PatchGeometry {
    PatchGeometry {
        positions: model.positions,
        normals: model.normals,
        areas: model.areas,
        pre_stress: model.pre_stress,
        direction: ball.direction(tilt),
        radius: ball.patch_radius(),
    }
}

/// Status and forces of the nodes of a joint at a state `z`.
pub(super) fn patch_snapshot(joint: &Joint, time: f64, z: &[f64]) -> PatchSnapshot {
    let forces = joint.node_forces(z);
    let pairs = forces.normal.iter().zip(&forces.speed).enumerate();
    let states = pairs.map(|(k, (&normal, &speed))| {
        if normal <= 0.0 {
            NodeState::Separated
        } else if speed < joint.stick_speed(k) {
            NodeState::Stick
        } else {
            NodeState::Slip
        }
    });
    PatchSnapshot {
        time,
        states: states.collect(),
        normal_force: forces.normal,
        friction: forces.friction,
    }
}
