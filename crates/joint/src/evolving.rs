//! The contact force with a friction law that has an internal state, and its derivative.
//!
//! The states are part of the state of the joint, relative to those of steady sliding, in the order of the nodes: so
//! `z = 0` is the equilibrium. The rate of steady sliding, which is zero within rounding, is subtracted, as for the
//! force.
//!
//! With `N` the normal force of a node, `A k` and `c` its derivatives with respect to displacement and velocity, and
//! `C` the coefficient of [`DynamicFriction`], the force changes by
//!
//! ```text
//! dF = -(A k du_r + c du_r/dt) (C + e_r) - N (dC/dV dV + dC/ds ds)
//! ```

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::contact_force::{
    AsRequired, ContactForceKernel, Group, KernelInput, KernelOutput, project,
};
use super::damping::ContactDamping;
use super::dynamic_friction::{DynamicFriction, StateSlopes};
use super::friction_kernel::SlipOnly;
use super::model::MAX_MODES;
use super::nodes::Nodes;
use super::simd::{Eight, LANES, Vector, parts};
use super::vector::{add_scaled, dot, scale};

/// A friction law with a state, and the nodes in steady sliding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evolving<'a> {
    pub law: &'a DynamicFriction,
    /// Whether friction includes the radial slip velocity.
    pub radial: bool,
    steady: &'a SteadyStates,
}

/// States of friction of all nodes in steady sliding; empty for a law without states.
#[derive(Clone, Debug, Default)]
pub(crate) struct SteadyStates {
    /// Number of nodes.
    count: usize,
    blocks: Vec<SteadyBlock>,
}

/// Eight nodes in steady sliding.
#[derive(Clone, Copy, Debug)]
struct SteadyBlock {
    state: [Eight; 3],
    /// Computed rate of the state, 1/s.
    rate: [Eight; 3],
}

/// Friction of eight nodes.
struct BlockResponse {
    /// Coefficient along the axes of the slip velocity.
    coefficient: [Eight; 3],
    /// Rate of the state, 1/s.
    rate: [Eight; 3],
}

/// Friction of eight nodes at a slip velocity (m/s) and a state, both by axes.
struct BlockFriction<'a> {
    law: &'a DynamicFriction,
    velocity: &'a [Eight; 3],
    state: &'a [Eight; 3],
}

impl WithSimd for BlockFriction<'_> {
    type Output = BlockResponse;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> BlockResponse {
        let mut found = BlockResponse {
            coefficient: [Eight::ZERO; 3],
            rate: [Eight::ZERO; 3],
        };
        match self.law {
            DynamicFriction::LuGre(law) => {
                for part in 0..parts::<S>() {
                    let load = |of: &[Eight; 3]| {
                        [&of[0], &of[1], &of[2]].map(|axis| axis.part(simd, part))
                    };
                    let [coefficient, rate] = law.responses(load(self.velocity), load(self.state));
                    for (out, c) in found.coefficient.iter_mut().zip(coefficient) {
                        c.store(&mut out.0, part);
                    }
                    for (out, rate) in found.rate.iter_mut().zip(rate) {
                        rate.store(&mut out.0, part);
                    }
                }
            }
            DynamicFriction::RateAndState(_) => {
                for lane in 0..LANES {
                    let [velocity, state] =
                        [self.velocity, self.state].map(|of| of.map(|axis| axis.0[lane]));
                    let response = self.law.response(velocity, state);
                    for (out, c) in found.coefficient.iter_mut().zip(response.coefficient) {
                        out.0[lane] = c;
                    }
                    for (out, rate) in found.rate.iter_mut().zip(response.rate) {
                        out.0[lane] = rate;
                    }
                }
            }
        }
        found
    }
}

impl SteadyStates {
    /// The states of a law on the nodes of a joint.
    pub fn new(law: &DynamicFriction, nodes: &Nodes) -> Self {
        let blocks = nodes.blocks.iter().map(|block| {
            let mut state = [Eight::ZERO; 3];
            for (lane, speed) in block.speed.0.into_iter().enumerate() {
                for (out, s) in state.iter_mut().zip(law.steady_state(speed)) {
                    out.0[lane] = s;
                }
            }
            // With the instructions of the hot loop: the rate of steady sliding is exactly zero there.
            let mut rate = pulp::Arch::new()
                .dispatch(BlockFriction {
                    law,
                    velocity: &[block.speed, Eight::ZERO, Eight::ZERO],
                    state: &state,
                })
                .rate;
            for (lane, speed) in block.speed.0.into_iter().enumerate() {
                // A contact at rest ages: there is no steady state.
                if speed <= 0.0 {
                    rate.iter_mut().for_each(|rate| rate.0[lane] = 0.0);
                }
            }
            SteadyBlock { state, rate }
        });
        Self {
            count: nodes.count,
            blocks: blocks.collect(),
        }
    }
}

impl<'a> Evolving<'a> {
    /// The law on the nodes of a joint, which slide steadily with these states.
    pub fn new(law: &'a DynamicFriction, radial: bool, steady: &'a SteadyStates) -> Self {
        Self {
            law,
            radial,
            steady,
        }
    }

    /// Number of states per node.
    pub fn states(self) -> usize {
        self.law.states(if self.radial { 3 } else { 2 })
    }

    /// Number of states of all nodes.
    pub fn len(self) -> usize {
        self.steady.count * self.states()
    }

    /// The state of a node in the axes of its sliding frame, from the states relative to steady sliding.
    pub fn state_of(self, node: usize, states: &[f64]) -> [f64; 3] {
        let mut state = self.steady_state(node);
        let own = &states[node * self.states()..][..self.states()];
        for (total, s) in state.iter_mut().zip(own) {
            *total += s;
        }
        state
    }

    /// The state of a node in steady sliding, in the axes of its sliding frame.
    fn steady_state(self, node: usize) -> [f64; 3] {
        let steady = &self.steady.blocks[node / LANES].state;
        steady.map(|axis| axis.0[node % LANES])
    }

    /// The coefficient in steady sliding along the first axis.
    pub fn steady_coefficient(self, node: usize, speed: f64) -> f64 {
        let response = self
            .law
            .response([speed, 0.0, 0.0], self.steady_state(node));
        response.coefficient[0]
    }

    /// The states relative to steady sliding of the same nodes under another loading, whose frames are `to`: bristles
    /// and the age of a contact do not jump with the loading. The frames of this loading are `from`.
    pub fn carried(self, other: Self, [from, to]: [&[[[f64; 3]; 3]]; 2], states: &mut [f64]) {
        for node in 0..self.steady.count {
            let mut state = self.state_of(node, states);
            if self.law.has_vector_state() {
                let axes = from[node];
                let mut cartesian = scale(axes[0], state[0]);
                cartesian = add_scaled(cartesian, state[1], axes[1]);
                cartesian = add_scaled(cartesian, state[2], axes[2]);
                state = to[node].map(|axis| dot(axis, cartesian));
            }
            let own = &mut states[node * self.states()..][..self.states()];
            for ((s, total), steady) in own.iter_mut().zip(state).zip(other.steady_state(node)) {
                *s = total - steady;
            }
        }
    }
}

/// Recorded derivatives of a node.
const RECORD: usize = 42;

/// Number of blocks of [`LANES`] numbers in the record of a number of nodes.
pub(crate) fn record_blocks(nodes: usize) -> usize {
    (nodes * RECORD).div_ceil(LANES)
}

/// Derivatives of the force of a node.
struct NodeRecord {
    /// Normal force, N, and its derivatives with respect to displacement (N/m) and velocity (N s/m).
    normal: [f64; 3],
    coefficient: [f64; 3],
    slopes: StateSlopes,
}

impl NodeRecord {
    fn write(&self, record: &mut [f64]) {
        let slopes = &self.slopes;
        let parts = [&self.normal, &self.coefficient].map(|part| &part[..]);
        let matrices = [
            &slopes.coefficient_by_velocity,
            &slopes.coefficient_by_state,
            &slopes.rate_by_velocity,
            &slopes.rate_by_state,
        ];
        let matrices = matrices.map(|matrix| matrix.as_flattened());
        let all = parts.iter().chain(&matrices).copied().flatten();
        for (out, number) in record.iter_mut().zip(all) {
            *out = *number;
        }
    }

    #[inline(always)]
    fn read(record: &[f64]) -> Self {
        let vector = |first: usize| [record[first], record[first + 1], record[first + 2]];
        let matrix = |first: usize| [vector(first), vector(first + 3), vector(first + 6)];
        Self {
            normal: vector(0),
            coefficient: vector(3),
            slopes: StateSlopes {
                coefficient_by_velocity: matrix(6),
                coefficient_by_state: matrix(15),
                rate_by_velocity: matrix(24),
                rate_by_state: matrix(33),
            },
        }
    }
}

/// The kernel: one pass over all nodes. The motion of the nodes and the projection of their forces are computed for
/// several nodes at once, the law for one at a time.
pub(crate) struct EvolvingKernel<'p, 'a> {
    pub nodes: &'p Nodes,
    pub evolving: Evolving<'p>,
    pub damping: ContactDamping,
    /// Generalised forces of steady sliding, `m`.
    pub steady: &'p [f64],
    pub query: KernelInput<'a>,
}

/// Motion and normal force of eight nodes.
struct BlockMotion {
    /// Index of the block.
    block: usize,
    slip: [Eight; 3],
    /// Slip velocity without `Omega x u`, m/s.
    unconvected: [Eight; 3],
    /// Normal force, N, and its derivatives with respect to displacement (N/m) and velocity (N s/m).
    normal: [Eight; 3],
    /// Power of contact damping, W.
    dashpot: Eight,
}

impl WithSimd for EvolvingKernel<'_, '_> {
    type Output = KernelOutput;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> KernelOutput {
        let nodes = self.nodes;
        let kernel = ContactForceKernel {
            nodes,
            law: SlipOnly {
                radial: self.evolving.radial,
            },
            task: PhantomData::<AsRequired<true>>,
            damping: self.damping,
            steady: self.steady,
            query: &mut self.query,
        };
        let mut sums = [Eight::ZERO; MAX_MODES];
        let sums = &mut sums[..nodes.modes];
        let mut power = 0.0;
        for block in 0..nodes.blocks.len() {
            let motion = block_motion(simd, &kernel, block);
            let mut force = [Eight::ZERO, Eight::ZERO, motion.normal[0]];
            self.evolving
                .block(simd, &motion, nodes.modes, kernel.query, &mut force);
            if kernel.query.audited {
                power += lost(&motion, &nodes.blocks[block], &force);
            }
            for part in 0..parts::<S>() {
                let group = Group::<1>::new::<S>(nodes.view(), block * parts::<S>() + part);
                let [along, across, outward] = &force;
                let force = [
                    along.part(simd, part),
                    across.part(simd, part),
                    outward.part(simd, part),
                ];
                project::<S, SlipOnly, 1>(simd, &group, force, sums);
            }
        }
        let outputs = kernel.query.out.iter_mut().zip(sums).zip(self.steady);
        for ((out, sum), steady) in outputs {
            *out = -sum.part(simd, 0).sum() - steady;
        }
        KernelOutput { power }
    }
}

/// Power of the deviation of friction from steady sliding, and of contact damping, W.
fn lost(motion: &BlockMotion, block: &super::nodes::Block, force: &[Eight; 3]) -> f64 {
    let [along, across, outward] = force;
    let own = &motion.unconvected;
    let powers = (0..LANES).map(|lane| {
        let vibration = own[0].0[lane] - block.speed.0[lane];
        let friction = (along.0[lane] + block.steady_friction.0[lane]) * vibration
            + across.0[lane] * own[1].0[lane]
            + (outward.0[lane] - motion.normal[0].0[lane]) * own[2].0[lane];
        motion.dashpot.0[lane] - friction
    });
    powers.sum()
}

#[inline(always)]
fn block_motion<S: Simd>(
    simd: S,
    kernel: &ContactForceKernel<'_, '_, SlipOnly, AsRequired<true>>,
    block: usize,
) -> BlockMotion {
    let contact = kernel.query.contact;
    let mut found = BlockMotion {
        block,
        slip: [Eight::ZERO; 3],
        unconvected: [Eight::ZERO; 3],
        normal: [Eight::ZERO; 3],
        dashpot: Eight::ZERO,
    };
    for part in 0..parts::<S>() {
        let vector = block * parts::<S>() + part;
        let group = Group::<1>::new::<S>(kernel.nodes.view(), vector);
        let motion = kernel.motion(simd, &group);
        let stiffness = group.load(simd, |block| &block.stiffness);
        let pre_stress = group.load(simd, |block| &block.pre_stress);
        let area = group.load(simd, |block| &block.area);
        let gap = stiffness.mul_add(motion.u_r, pre_stress);
        let spring = contact.stress(vector, gap);
        let damped = kernel
            .damping
            .stress(contact, vector, [gap, spring, stiffness, motion.rate]);
        let normal = [damped.normal, damped.stiffness, damped.viscosity];
        for (out, slip) in found.slip.iter_mut().zip(motion.slip) {
            slip.store(&mut out.0, part);
        }
        for (out, slip) in found.unconvected.iter_mut().zip(motion.unconvected) {
            slip.store(&mut out.0, part);
        }
        for (out, normal) in found.normal.iter_mut().zip(normal) {
            (normal * area).store(&mut out.0, part);
        }
        let dashpot = (spring - damped.normal) * area * motion.rate;
        dashpot.store(&mut found.dashpot.0, part);
    }
    found
}

impl Evolving<'_> {
    /// Adds the friction of a block to its force, and writes the rates of its states and its records.
    #[inline(always)]
    fn block<S: Simd>(
        self,
        simd: S,
        motion: &BlockMotion,
        modes: usize,
        query: &mut KernelInput<'_>,
        force: &mut [Eight; 3],
    ) {
        let steady = &self.steady.blocks[motion.block];
        let (count, first) = (self.states(), motion.block * LANES);
        let lanes = LANES.min(self.steady.count - first);
        let own = first * count..(first + lanes) * count;
        let mut velocity = motion.slip;
        if !self.radial {
            velocity[2] = Eight::ZERO;
        }
        let mut state = steady.state;
        let states = &query.z[2 * modes..][own.clone()];
        for (lane, relative) in states.chunks_exact(count).enumerate() {
            for (total, s) in state.iter_mut().zip(relative) {
                total.0[lane] += s;
            }
        }
        let friction = BlockFriction {
            law: self.law,
            velocity: &velocity,
            state: &state,
        };
        let response = friction.with_simd(simd);
        for (force, coefficient) in force.iter_mut().zip(&response.coefficient) {
            for part in 0..parts::<S>() {
                let normal = motion.normal[0].part(simd, part);
                let sum = normal.mul_add(coefficient.part(simd, part), force.part(simd, part));
                sum.store(&mut force.0, part);
            }
        }
        for (lane, rates) in query.out[modes..][own].chunks_exact_mut(count).enumerate() {
            for (axis, out) in rates.iter_mut().enumerate() {
                *out = response.rate[axis].0[lane] - steady.rate[axis].0[lane];
            }
        }
        let Some(record) = &mut query.record else {
            return;
        };
        let records = record.as_flattened_mut()[first * RECORD..].chunks_exact_mut(RECORD);
        for (lane, record) in records.take(lanes).enumerate() {
            let of = |axes: &[Eight; 3]| axes.map(|axis| axis.0[lane]);
            NodeRecord {
                normal: of(&motion.normal),
                coefficient: of(&response.coefficient),
                slopes: self.law.slopes(of(&velocity), of(&state)),
            }
            .write(record);
        }
    }
}

/// Product of the derivative with tangent vectors, one after another.
pub(crate) struct EvolvingProduct<'a> {
    pub nodes: &'a Nodes,
    pub evolving: Evolving<'a>,
    pub kept: &'a [[f64; LANES]],
    /// `(2m + states) x width`.
    pub vectors: &'a [f64],
    pub width: usize,
    /// Output: the change of force and rates, `(m + states) x width`.
    pub out: &'a mut [f64],
}

impl WithSimd for EvolvingProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for vector in 0..self.width {
            self.one(simd, vector);
        }
    }
}

impl EvolvingProduct<'_> {
    #[inline(always)]
    fn one<S: Simd>(&mut self, simd: S, vector: usize) {
        let (nodes, width) = (self.nodes, self.width);
        let m = nodes.modes;
        let mut motion = [[0.0; MAX_MODES]; 2];
        for (half, motion) in motion.iter_mut().enumerate() {
            for (i, x) in motion[..m].iter_mut().enumerate() {
                *x = self.vectors[(half * m + i) * width + vector];
            }
        }
        let [dq, dv] = [&motion[0][..m], &motion[1][..m]];
        let mut sums = [Eight::ZERO; MAX_MODES];
        for (block, (_, rows)) in nodes.iter().enumerate() {
            // Changes of radial displacement, approach velocity and slip velocity.
            let mut change = [Eight::ZERO; 5];
            for part in 0..parts::<S>() {
                let mut sums = [Vector::splat(simd, 0.0); 5];
                for (row, (dq, dv)) in rows.iter().zip(dq.iter().zip(dv)) {
                    let [s, t, r] = row.part(simd, part);
                    let [dq, dv] = [Vector::splat(simd, *dq), Vector::splat(simd, *dv)];
                    sums[0] = r.mul_add(dq, sums[0]);
                    sums[1] = r.mul_add(dv, sums[1]);
                    sums[2] = s.mul_add(dv, sums[2]);
                    sums[3] = t.mul_add(dv, sums[3]);
                }
                sums[4] = sums[1];
                for (row, dq) in nodes.convected_rows(block).iter().zip(dq) {
                    let dq = Vector::splat(simd, *dq);
                    for (sum, row) in sums[2..].iter_mut().zip(row.part(simd, part)) {
                        *sum = row.mul_add(dq, *sum);
                    }
                }
                for (change, sum) in change.iter_mut().zip(sums) {
                    sum.store(&mut change.0, part);
                }
            }
            let mut force = [Eight::ZERO; 3];
            for lane in 0..LANES.min(nodes.count - block * LANES) {
                let change = change.map(|change| change.0[lane]);
                let node = block * LANES + lane;
                let of_node = self.node(node, vector, change);
                for (force, of_node) in force.iter_mut().zip(of_node) {
                    force.0[lane] = of_node;
                }
            }
            for part in 0..parts::<S>() {
                let force = [&force[0], &force[1], &force[2]].map(|force| force.part(simd, part));
                for (sum, row) in sums.iter_mut().zip(rows) {
                    let [s, t, r] = row.part(simd, part);
                    let mut total = sum.part(simd, 0);
                    total = s.mul_add(force[0], total);
                    total = t.mul_add(force[1], total);
                    r.mul_add(force[2], total).store(&mut sum.0, 0);
                }
            }
        }
        for (i, sum) in sums[..m].iter().enumerate() {
            self.out[i * width + vector] = -sum.part(simd, 0).sum();
        }
    }

    /// Negative change of the force of a node for changes of radial displacement, approach velocity and slip
    /// velocity; writes the change of the rate of its state.
    #[inline(always)]
    fn node(&mut self, node: usize, vector: usize, change: [f64; 5]) -> [f64; 3] {
        let (m, width, count) = (self.nodes.modes, self.width, self.evolving.states());
        let record = NodeRecord::read(&self.kept.as_flattened()[node * RECORD..][..RECORD]);
        let [du, approach, along, across, outward] = change;
        let slip = [
            along,
            across,
            if self.evolving.radial { outward } else { 0.0 },
        ];
        let mut state = [0.0; 3];
        for (axis, s) in state[..count].iter_mut().enumerate() {
            *s = self.vectors[(2 * m + node * count + axis) * width + vector];
        }
        let slopes = &record.slopes;
        let product = |by_velocity: &[[f64; 3]; 3], by_state: &[[f64; 3]; 3], axis: usize| {
            dot(by_velocity[axis], slip) + dot(by_state[axis], state)
        };
        for axis in 0..count {
            self.out[(m + node * count + axis) * width + vector] =
                product(&slopes.rate_by_velocity, &slopes.rate_by_state, axis);
        }
        let [normal, stiffness, viscosity] = record.normal;
        let pressed = stiffness * du + viscosity * approach;
        let mut force = [0.0, 0.0, pressed];
        for (axis, force) in force.iter_mut().enumerate() {
            *force += pressed * record.coefficient[axis]
                + normal
                    * product(
                        &slopes.coefficient_by_velocity,
                        &slopes.coefficient_by_state,
                        axis,
                    );
        }
        force
    }
}
