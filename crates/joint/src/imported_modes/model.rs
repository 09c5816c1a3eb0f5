//! The contact model of imported modes.

use super::ImportedModes;
use crate::vector::{any_normal, cross, dot, unit};
use crate::{JointSpec, Model};

impl ImportedModes {
    /// Builds the contact model with the load, rotation, friction and damping of a joint, for a load along
    /// `direction`. Without a probe in the file, the probe is that of the central node in the sliding direction of
    /// `probe_rotation` (rad/s).
    pub(crate) fn model(
        &self,
        spec: &JointSpec,
        direction: [f64; 3],
        probe_rotation: [f64; 3],
    ) -> Model {
        let velocity = |x: [f64; 3]| cross(spec.rotation, x);
        let probe = self.probe.clone().unwrap_or_else(|| {
            let alignment = |k: &usize| dot(self.normals[*k], direction);
            let nodes = 0..self.nodes();
            let centre = nodes.max_by(|a, b| alignment(a).total_cmp(&alignment(b)));
            let centre = centre.unwrap_or_default();
            let along = unit(cross(probe_rotation, self.positions[centre]))
                .unwrap_or_else(|| any_normal(self.normals[centre]));
            let rows = &self.shapes[centre * self.modes()..][..self.modes()];
            rows.iter().map(|shape| dot(*shape, along)).collect()
        });
        let factor = spec.contact.stiffness_factor;
        Model {
            positions: self.positions.clone(),
            normals: self.normals.clone(),
            areas: self.areas.clone(),
            pre_stress: self.pre_stress.clone(),
            stiffness: self.stiffness.iter().map(|k| factor * k).collect(),
            shapes: self.shapes.clone(),
            omega: self.omega.clone(),
            damping: spec.damping.clone(),
            sliding_velocity: self.positions.iter().map(|x| velocity(*x)).collect(),
            friction: spec.friction.clone(),
            unilateral: spec.contact.unilateral,
            contact_damping: spec.contact.damping,
            convection: spec.convection.then_some(spec.rotation),
            probe,
        }
    }
}
