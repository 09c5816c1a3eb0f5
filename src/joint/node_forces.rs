//! Contact forces of all nodes at an instant, for pictures of the patch.

use super::Joint;
use super::simd::LANES;
use super::vector::{add_scaled, scale};

/// Contact forces on all nodes at an instant. Each vector has one entry per node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeForces {
    /// Normal force `N Delta A`, N; zero for a separated node, and negative for a bonded one that is pulled.
    pub normal: Vec<f64>,
    /// Magnitude of the slip velocity in the friction law, m/s.
    pub speed: Vec<f64>,
    /// Friction force on the ball, Eq. (3), N, in Cartesian components.
    pub friction: Vec<[f64; 3]>,
}

impl Joint {
    /// Returns the contact forces on all nodes at a state `z`.
    pub fn node_forces(&self, z: &[f64]) -> NodeForces {
        let [q, v, states] = self.parts(z);
        let count = self.contact_nodes();
        let mut forces = NodeForces {
            normal: Vec::with_capacity(count),
            speed: Vec::with_capacity(count),
            friction: Vec::with_capacity(count),
        };
        for (block, frames) in self.nodes.frames.chunks(LANES).enumerate() {
            let motion = self.block_motion(block, q, v);
            for (lane, frame) in frames.iter().enumerate() {
                let action = self.action(block * LANES + lane, &motion, states);
                forces.normal.push(action.normal);
                forces.speed.push(action.speed);
                let [s, t, r] = action.friction;
                let tangential = add_scaled(scale(frame[0], s), t, frame[1]);
                forces.friction.push(add_scaled(tangential, r, frame[2]));
            }
        }
        forces
    }
}
