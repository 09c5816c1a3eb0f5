//! The contact patch as it is shown: its nodes need not be those that are simulated.
//!
//! Displacement and velocity are known everywhere on the patch, because they are sums of modes. Pictures and counts
//! are evaluated at `record.patch_nodes` nodes in rings, however few the simulation integrates over. Where only the
//! simulated nodes have a state of friction, or a file fixes them, they are shown.

use super::PipelineError;
use super::message::{NodeState, PatchGeometry, PatchSnapshot};
use crate::joint::{BallJoint, Joint};

/// The shown nodes under the present loading.
#[derive(Debug)]
pub(super) struct ShownPatch {
    /// Number of nodes in rings.
    count: usize,
    /// The joint with these nodes; `None` if the simulated nodes are shown.
    joint: Option<Joint>,
}

impl ShownPatch {
    /// A patch that shows `count` nodes.
    pub fn new(count: usize) -> Self {
        Self { count, joint: None }
    }

    /// Returns the shown nodes of a joint at a tilt (rad), after a change of its loading.
    ///
    /// # Errors
    /// If the joint cannot be assembled.
    pub fn set_loading(
        &mut self,
        ball: &BallJoint,
        tilt: f64,
    ) -> Result<PatchGeometry, PipelineError> {
        let in_rings = ball.model_in_rings(self.count, tilt)?;
        self.joint = in_rings.as_ref().map(Joint::new);
        let model = in_rings.map_or_else(|| ball.model(tilt), Ok)?;
        Ok(PatchGeometry {
            positions: model.positions,
            areas: model.areas,
            pre_stress: model.pre_stress,
            direction: ball.direction(tilt),
            radius: ball.patch_radius(),
        })
    }

    /// Status and forces of the shown nodes at a state `z` of the simulated joint.
    pub fn snapshot(&self, simulated: &Joint, time: f64, z: &[f64]) -> PatchSnapshot {
        let joint = self.joint.as_ref().unwrap_or(simulated);
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
}
