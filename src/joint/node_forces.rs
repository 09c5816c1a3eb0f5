//! Contact forces of all nodes at an instant, for pictures of the patch.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::contact_force::{AsRequired, ContactForceKernel, Group, KernelInput};
use super::friction_kernel::{Curve, Custom, FrictionKernel, Frictionless};
use super::simd::{Eight, LANES, LanePosition, Vector, parts};
use super::system::ActiveLaw;
use super::vector::{add_scaled, scale};
use super::{Friction, Joint};

/// Contact forces on all nodes at an instant. Each vector has one entry per node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeForces {
    /// Normal force `N Delta A`, N; zero for a separated node, and negative for a bonded one that is pulled.
    pub normal: Vec<f64>,
    /// Magnitude of the slip velocity in the friction law, m/s; zero without friction.
    pub speed: Vec<f64>,
    /// Friction force on the ball, Eq. (3), N, in Cartesian components.
    pub friction: Vec<[f64; 3]>,
}

/// Forces on eight nodes, in their sliding frames.
#[derive(Clone, Copy)]
struct BlockForces {
    normal: Eight,
    speed: Eight,
    friction: [Eight; 3],
}

/// The kernel that evaluates the forces on all nodes.
struct NodeForceKernel<'p, 'a, L> {
    kernel: ContactForceKernel<'p, 'a, L, AsRequired<true>>,
    /// Output, one per block.
    blocks: &'p mut [BlockForces],
}

impl<L: FrictionKernel> WithSimd for NodeForceKernel<'_, '_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let nodes = self.kernel.nodes.view();
        let law = &self.kernel.law;
        let contact = self.kernel.query.contact;
        for vector in 0..self.blocks.len() * parts::<S>() {
            let group = Group::<1>::new::<S>(nodes, vector);
            let motion = self.kernel.motion(simd, &group);
            let stiffness = group.load(simd, |block| &block.stiffness);
            let pre_stress = group.load(simd, |block| &block.pre_stress);
            let gap = stiffness.mul_add(motion.u_r, pre_stress);
            let spring = contact.stress(vector, gap);
            let at = [gap, spring, stiffness, motion.rate];
            let damped = self.kernel.damping.stress(contact, vector, at);
            let normal = damped.normal * group.load(simd, |block| &block.area);
            let LanePosition { block, part } = LanePosition::of::<S>(vector);
            let out = &mut self.blocks[block];
            normal.store(&mut out.normal.0, part);
            if !L::HAS_FRICTION {
                continue;
            }
            let [along, across, mut outward] = motion.slip;
            if !law.radial() {
                outward = Vector::splat(simd, 0.0);
            }
            let square = across.mul_add(across, along * along);
            // As in the hot loop, a tiny lower bound permits the division in mu(V)/V.
            let speed = outward.mul_add(outward, square).at_least(1e-280).sqrt();
            speed.store(&mut out.speed.0, part);
            let drag = normal * law.ratio(speed);
            for (out, slip) in out.friction.iter_mut().zip([along, across, outward]) {
                (-(drag * slip)).store(&mut out.0, part);
            }
        }
    }
}

impl Joint {
    /// Returns the contact forces on all nodes at a state `z`.
    pub fn node_forces(&self, z: &[f64]) -> NodeForces {
        let zero = BlockForces {
            normal: Eight::ZERO,
            speed: Eight::ZERO,
            friction: [Eight::ZERO; 3],
        };
        let mut blocks = vec![zero; self.nodes.blocks.len()];
        match &self.law {
            ActiveLaw::Known(Friction::None) => self.evaluate(Frictionless, z, &mut blocks),
            ActiveLaw::Known(Friction::Constant { law, radial: true }) => {
                self.evaluate(Curve::<_, true>(*law), z, &mut blocks);
            }
            ActiveLaw::Known(Friction::Constant { law, radial: false }) => {
                self.evaluate(Curve::<_, false>(*law), z, &mut blocks);
            }
            ActiveLaw::Known(Friction::Stribeck { law, radial: true }) => {
                self.evaluate(Curve::<_, true>(*law), z, &mut blocks);
            }
            ActiveLaw::Known(Friction::Stribeck { law, radial: false }) => {
                self.evaluate(Curve::<_, false>(*law), z, &mut blocks);
            }
            ActiveLaw::Known(Friction::Table { law, radial: true }) => {
                self.evaluate(Curve::<_, true>(law.as_ref()), z, &mut blocks);
            }
            ActiveLaw::Known(Friction::Table { law, radial: false }) => {
                self.evaluate(Curve::<_, false>(law.as_ref()), z, &mut blocks);
            }
            ActiveLaw::Custom { law, radial } => {
                let (law, radial) = (law.as_ref(), *radial);
                self.evaluate(Custom { law, radial }, z, &mut blocks);
            }
            ActiveLaw::Known(Friction::Dynamic { .. }) => {
                let [q, v, states] = self.parts(z);
                for k in 0..self.contact_nodes() {
                    let action = self.node_action(k, q, v, states);
                    let (block, lane) = (&mut blocks[k / LANES], k % LANES);
                    block.normal.0[lane] = action.normal;
                    block.speed.0[lane] = action.speed;
                    for (out, friction) in block.friction.iter_mut().zip(action.friction) {
                        out.0[lane] = friction;
                    }
                }
            }
        }
        let count = self.contact_nodes();
        let mut forces = NodeForces {
            normal: Vec::with_capacity(count),
            speed: Vec::with_capacity(count),
            friction: Vec::with_capacity(count),
        };
        for (block, frames) in blocks.iter().zip(self.nodes.frames.chunks(LANES)) {
            forces
                .normal
                .extend_from_slice(&block.normal.0[..frames.len()]);
            forces
                .speed
                .extend_from_slice(&block.speed.0[..frames.len()]);
            let [s, t, r] = &block.friction;
            forces
                .friction
                .extend(frames.iter().enumerate().map(|(k, frame)| {
                    let tangential = add_scaled(scale(frame[0], s.0[k]), t.0[k], frame[1]);
                    add_scaled(tangential, r.0[k], frame[2])
                }));
        }
        forces
    }

    fn evaluate<L: FrictionKernel>(&self, law: L, z: &[f64], blocks: &mut [BlockForces]) {
        let mut query = KernelInput {
            contact: self.lift_off(),
            record: None,
            audited: false,
            z,
            out: &mut [],
        };
        self.arch.dispatch(NodeForceKernel {
            kernel: ContactForceKernel {
                nodes: &self.nodes,
                law,
                task: PhantomData::<AsRequired<true>>,
                damping: self.contact_damping,
                steady: &self.equilibrium().force,
                query: &mut query,
            },
            blocks,
        });
    }
}
