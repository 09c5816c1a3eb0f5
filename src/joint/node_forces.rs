//! Contact forces of all nodes at an instant, for pictures of the patch.

use pulp::{Simd, WithSimd};

use super::friction::{FrictionLaw, VectorLaw};
use super::simd::{LANES, Vector, parts};
use super::system::ActiveLaw;
use super::vector::{add_scaled, scale};
use super::{Friction, Joint};

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

/// Replaces the slip speeds of eight nodes by the ratios of a law.
struct Ratios<'a, L> {
    law: &'a L,
    speeds: &'a mut [f64; LANES],
}

impl<L: VectorLaw> WithSimd for Ratios<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..parts::<S>() {
            let speed = Vector::<S>::load(simd, self.speeds, part);
            // As in the hot loop, a tiny lower bound permits the division in mu(V)/V.
            let ratio = self.law.ratio_vector(speed.at_least(1e-140));
            ratio.store(self.speeds, part);
        }
    }
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
            let mut ratios = [1.0; LANES];
            let first = block * LANES;
            for (lane, speed) in ratios.iter_mut().take(frames.len()).enumerate() {
                let action = self.pressed(first + lane, &motion);
                *speed = action.speed;
                forces.normal.push(action.normal);
                forces.speed.push(action.speed);
                forces.friction.push(self.friction_velocity(&action));
            }
            let is_ratio = self.replace_by_ratios(&mut ratios);
            for (lane, [along, across, outward]) in frames.iter().enumerate() {
                let k = first + lane;
                let [s, t, r] = if is_ratio {
                    scale(forces.friction[k], -forces.normal[k] * ratios[lane])
                } else {
                    self.node_action(k, q, v, states).friction
                };
                let tangential = add_scaled(scale(*along, s), t, *across);
                forces.friction[k] = add_scaled(tangential, r, *outward);
            }
        }
        forces
    }

    /// Replaces the slip speeds of eight nodes by the ratios `mu(V)/V` of the friction law; `false` if it has states,
    /// or there is none.
    fn replace_by_ratios(&self, speeds: &mut [f64; LANES]) -> bool {
        match &self.law {
            ActiveLaw::Known(Friction::None | Friction::Dynamic { .. }) => return false,
            ActiveLaw::Known(Friction::Stribeck { law, .. }) => {
                self.arch.dispatch(Ratios { law, speeds });
            }
            ActiveLaw::Known(Friction::Constant { law, .. }) => {
                self.arch.dispatch(Ratios { law, speeds });
            }
            ActiveLaw::Known(Friction::Table { law, .. }) => {
                let law = &law.as_ref();
                self.arch.dispatch(Ratios { law, speeds });
            }
            ActiveLaw::Custom { law, .. } => FrictionLaw::ratios(law.as_ref(), speeds),
        }
        true
    }
}
