//! Contact forces of single nodes, Eq. (1) and (2), for display, the energy audit and the Jacobian. The hot
//! loop in `contact_force` evaluates several nodes at once.

use super::Joint;
use super::friction::FrictionLaw;
use super::nodes::radial;
use super::simd::{Eight, LANES};
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

/// Motion of eight nodes in their sliding frames.
struct BlockMotion {
    /// Radial displacement, m, and its rate, m/s.
    u_r: [f64; LANES],
    rate: [f64; LANES],
    /// Slip velocity along each axis, Eq. (4), m/s.
    slip: [[f64; LANES]; 3],
}

/// Slip speed below which a node whose friction has a state is classified as sticking, m/s.
const DYNAMIC_STICK_SPEED: f64 = 1e-3;

impl Joint {
    /// Returns forces and velocities of node `k` at modal coordinates `q`, velocities `v` and states of friction
    /// ([`Joint::parts`]).
    pub fn node_action(&self, k: usize, q: &[f64], v: &[f64], states: &[f64]) -> NodeAction {
        self.action_in(k, &self.block_motion(k / LANES, q, v), states)
    }

    /// Contact forces on all nodes at a state `z`.
    pub fn node_forces(&self, z: &[f64]) -> NodeForces {
        let [q, v, states] = self.parts(z);
        let mut forces = NodeForces::default();
        for (block, frames) in self.nodes.frames.chunks(LANES).enumerate() {
            let motion = self.block_motion(block, q, v);
            for (k, [along, across, outward]) in (block * LANES..).zip(frames) {
                let action = self.action_in(k, &motion, states);
                let [s, t, r] = action.friction;
                let tangential = add_scaled(scale(*along, s), t, *across);
                forces.normal.push(action.normal);
                forces.speed.push(action.speed);
                forces.friction.push(add_scaled(tangential, r, *outward));
            }
        }
        forces
    }

    /// Forces and velocities of node `k` of a block with this motion.
    fn action_in(&self, k: usize, motion: &BlockMotion, states: &[f64]) -> NodeAction {
        let mut action = self.pressed(k, motion);
        let (seen, normal) = (self.friction_velocity(&action), action.normal);
        action.friction = match self.evolving() {
            Some(evolving) => {
                let response = evolving.law.response(seen, evolving.state_of(k, states));
                scale(response.coefficient, -normal)
            }
            None => self.law.law().map_or([0.0; 3], |law| {
                scale(seen, -normal * law.ratio(action.speed).value)
            }),
        };
        action
    }

    /// Slip velocity in the friction law, m/s.
    fn friction_velocity(&self, action: &NodeAction) -> [f64; 3] {
        let [s, t, r] = action.slip;
        if self.law.radial() {
            [s, t, r]
        } else {
            [s, t, 0.0]
        }
    }

    /// Motion of the nodes of a block at modal coordinates `q` and velocities `v`.
    fn block_motion(&self, block: usize, q: &[f64], v: &[f64]) -> BlockMotion {
        let m = self.nodes.modes;
        let rows = &self.nodes.rows[block * m..][..m];
        let mut motion = BlockMotion {
            u_r: [0.0; LANES],
            rate: [0.0; LANES],
            slip: [self.nodes.blocks[block].speed.0, [0.0; LANES], [0.0; LANES]],
        };
        let add = |sums: &mut [f64; LANES], row: &Eight, factor: f64| {
            for (sum, value) in sums.iter_mut().zip(&row.0) {
                *sum += value * factor;
            }
        };
        for (row, (&q, &v)) in rows.iter().zip(q.iter().zip(v)) {
            add(&mut motion.u_r, &row.r, q);
            for (sums, row) in motion.slip.iter_mut().zip([&row.s, &row.t, &row.r]) {
                add(sums, row, v);
            }
        }
        motion.rate = motion.slip[2];
        for (row, &q) in self.nodes.convected_rows(block).iter().zip(q) {
            for (sums, row) in motion.slip.iter_mut().zip([&row.s, &row.t, &row.r]) {
                add(sums, row, q);
            }
        }
        motion
    }

    /// Action of the contact on node `k` of a block with this motion, without friction.
    fn pressed(&self, k: usize, motion: &BlockMotion) -> NodeAction {
        let lane = k % LANES;
        let block = &self.nodes.blocks[k / LANES];
        let (u_r, rate) = (motion.u_r[lane], motion.rate[lane]);
        let slip = motion.slip.map(|axis| axis[lane]);
        let (area, stiffness) = (block.area.0[lane], block.stiffness.0[lane]);
        let gap = block.pre_stress.0[lane] + stiffness * u_r;
        let closed = !self.unilateral || gap > 0.0;
        let spring = if closed { gap } else { 0.0 };
        let unclamped = if closed {
            self.contact_damping.unclamped(gap, stiffness, rate)
        } else {
            0.0
        };
        // A contact pushes and never pulls, unless it is bonded.
        let pulls = self.unilateral && unclamped < 0.0;
        let stress = if pulls { 0.0 } else { unclamped };
        let (normal, dashpot) = (stress * area, (stress - spring) * area);
        let mut action = NodeAction {
            gap,
            normal,
            dashpot,
            slip,
            speed: 0.0,
            friction: [0.0; 3],
        };
        action.speed = norm(self.friction_velocity(&action));
        action
    }

    /// Slip speed below which node `k` is classified as sticking, m/s; zero without friction.
    ///
    /// The limit is the creep region of the friction curve (1 mm/s for a law with a state), and at most a tenth of
    /// the steady sliding speed, so that steady sliding on a curve with a wide creep region is not classified as
    /// sticking. At rest the limit is the whole creep region.
    pub fn stick_speed(&self, k: usize) -> f64 {
        let steady = self.nodes.blocks[k / LANES].speed.0[k % LANES];
        let creeps = match self.evolving() {
            Some(_) => DYNAMIC_STICK_SPEED,
            None => self.law.law().map_or(0.0, FrictionLaw::stick_speed),
        };
        match steady > 0.0 {
            true => creeps.min(0.1 * steady),
            false => creeps,
        }
    }

    /// Eq. (18): the indicators `s_k = p_n + k_c u_r` (Pa) of all nodes at modal coordinates `q`, written to
    /// `gaps` (one per node). A node separates when its indicator falls through zero. The printed equation
    /// clamps the indicator at zero, which would hide the crossing; the clamp is omitted.
    pub fn gaps(&self, q: &[f64], gaps: &mut [f64]) {
        for (nodes, (block, rows)) in gaps.chunks_mut(LANES).zip(self.nodes.iter()) {
            for (lane, (gap, u_r)) in nodes.iter_mut().zip(radial(rows, q)).enumerate() {
                *gap = block.pre_stress.0[lane] + block.stiffness.0[lane] * u_r;
            }
        }
    }
}
