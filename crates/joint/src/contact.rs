//! Contact forces of single nodes, Eq. (1) and (2), for display, the energy audit and the Jacobian. The hot
//! loop in `contact_force` evaluates several nodes at once.

use pulp::Scalar;

use super::Joint;
use super::contact_force::Group;
use super::friction::{ContactLaw, FrictionLaw, WithLaw};
use super::normal::Separation;
use super::simd::{LANES, Vector};
use super::vector::{add_scaled, norm, scale};

/// Action of the contact on a node at an instant: forces and velocities in its sliding frame `(e_s, e_t,
/// e_r)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeAction {
    /// Gap function `s = p_n + k_c u_r`, Pa; negative for a separated node.
    pub gap: f64,
    /// Normal force `N Delta A`, N.
    pub normal: f64,
    /// Contribution of contact damping to the normal force, N: the normal force minus that of the spring.
    pub dashpot: f64,
    /// Slip velocity, Eq. (4), m/s.
    pub slip: [f64; 3],
    /// Magnitude of the slip velocity in the friction law, m/s.
    pub speed: f64,
    /// Friction force, Eq. (3), N.
    pub friction: [f64; 3],
}

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

/// Slip speed below which a node whose friction has a state is classified as sticking, m/s.
const DYNAMIC_STICK_SPEED: f64 = 1e-3;

impl Joint {
    /// Returns forces and velocities of node `k` at modal coordinates `q`, velocities `v` and states of friction
    /// ([`Joint::parts`]).
    pub fn node_action(&self, k: usize, q: &[f64], v: &[f64], states: &[f64]) -> NodeAction {
        self.law.dispatch(Action {
            joint: self,
            separation: self.lift_off(),
            parts: [q, v, states],
            node: k,
        })
    }

    /// Contact forces on all nodes at a state `z`.
    pub fn node_forces(&self, z: &[f64]) -> NodeForces {
        let [q, v, states] = self.parts(z);
        let mut forces = NodeForces::default();
        for (k, [along, across, outward]) in self.nodes.frames.iter().enumerate() {
            let action = self.node_action(k, q, v, states);
            let [s, t, r] = action.friction;
            let tangential = add_scaled(scale(*along, s), t, *across);
            forces.normal.push(action.normal);
            forces.speed.push(action.speed);
            forces.friction.push(add_scaled(tangential, r, *outward));
        }
        forces
    }

    /// Slip speed below which node `k` is classified as sticking, m/s; zero without friction.
    ///
    /// The limit is the creep region of the friction curve (1 mm/s for a law with a state), and at most a tenth of
    /// the steady sliding speed, so that steady sliding on a curve with a wide creep region is not classified as
    /// sticking. At rest the limit is the whole creep region.
    pub fn stick_speed(&self, k: usize) -> f64 {
        let steady = self.nodes.blocks[k / LANES].speed.0[k % LANES];
        let creeps = match self.law.evolving() {
            Some(_) => DYNAMIC_STICK_SPEED,
            None => self.law.law().map_or(0.0, FrictionLaw::stick_speed),
        };
        if steady > 0.0 {
            creeps.min(0.1 * steady)
        } else {
            creeps
        }
    }
}

/// The laws of the hot loop at a single node.
struct Action<'a> {
    joint: &'a Joint,
    separation: Separation<'a>,
    parts: [&'a [f64]; 3],
    node: usize,
}

impl WithLaw for Action<'_> {
    type Output = NodeAction;

    fn with_law<L: ContactLaw, const N: usize>(self, law: L) -> NodeAction {
        let simd = Scalar::new();
        let node_law = self
            .joint
            .node_law::<L, true>(law, self.separation, self.parts);
        let group = Group::<1>::new::<Scalar>(&self.joint.nodes, self.node);
        let motion = node_law.motion(simd, &group);
        let normal = node_law.normal::<_, 1, 0>(simd, &group, &motion);
        let [coefficient, _] = node_law.friction::<_, 1, 0>(simd, &group, &motion);
        let [load, spring] = [normal.total, normal.spring].map(|force| force.value.sum());
        let slip = motion.slip.map(Vector::sum);
        let [s, t, r] = slip;
        NodeAction {
            gap: normal.gap.value.sum(),
            normal: load,
            dashpot: load - spring,
            slip,
            speed: norm([s, t, if node_law.law.radial() { r } else { 0.0 }]),
            friction: coefficient.map(|c| -load * c.value.sum()),
        }
    }
}
