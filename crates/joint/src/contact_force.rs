//! Eq. (6) and (8): the generalised forces of contact and friction. This is the hot loop.
//!
//! The friction law is matched once, outside the loop over the nodes, and the loop is compiled for each law and for the
//! widest available SIMD vectors. It is also compiled with and without derivatives, and with and without the [extras] of
//! few joints. Disabled effects have no cost: without friction, for example, no velocity is computed. The separation
//! rule is matched once per group of nodes, where its cost is not measurable.
//!
//! Groups of [`VECTORS_PER_GROUP`] vectors of nodes pass through three stages: motion of the nodes, force on the
//! nodes, and projection of the force onto the modes. The first and the last stage are sums of products,
//! limited by the arithmetic throughput; the second is limited by latency.
//!
//! [extras]: NodeLaw

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::dual::Dual;
use super::friction::ContactLaw;
use super::model::MAX_MODES;
use super::nodes::{Block, Nodes, Rows};
use super::normal::{ContactDamping, Separation};
use super::simd::{Eight, LANES, LanePosition, Vector, parts};
use super::tangent::keep_slopes;

/// Number of adjacent vectors of nodes in a group. More vectors hide more latency, but exceed the number of
/// registers; if the nodes do not fit in the first-level cache, two are the fastest.
pub(super) const VECTORS_PER_GROUP: usize = 2;

/// Number of modes in the paper, for which the sums are allocated statically.
pub(crate) const PAPER_MODES: usize = 11;

/// Adjacent vectors of nodes.
pub(super) struct Group<'a, const K: usize> {
    /// Index of the first vector.
    pub(super) first: usize,
    places: [LanePosition; K],
    blocks: [&'a Block; K],
    /// Rows of all modes.
    rows: [&'a [Rows]; K],
    /// Rows of `Omega x Phi_i`; empty if the slip velocity excludes this term.
    convected: [&'a [Rows]; K],
}

impl<'a, const K: usize> Group<'a, K> {
    #[inline(always)]
    pub(super) fn new<S: Simd>(nodes: &'a Nodes, first: usize) -> Self {
        let place = LanePosition::of::<S>(first);
        let mut group = Self {
            first,
            places: [place; K],
            blocks: [&nodes.blocks[place.block]; K],
            rows: [&[]; K],
            convected: [&[]; K],
        };
        for k in 0..K {
            let place = LanePosition::of::<S>(first + k);
            group.places[k] = place;
            group.blocks[k] = &nodes.blocks[place.block];
            group.rows[k] = &nodes.rows[place.block * nodes.modes..][..nodes.modes];
            group.convected[k] = nodes.convected_rows(place.block);
        }
        group
    }

    /// Number of modes.
    #[inline(always)]
    pub(super) fn modes(&self) -> usize {
        self.rows[0].len()
    }

    /// Loads a quantity of the blocks.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, of: impl Fn(&Block) -> &Eight) -> Vector<S, K> {
        Vector::from_parts(
            simd,
            #[inline(always)]
            |k| of(self.blocks[k]).part(simd, self.places[k].part),
        )
    }

    /// Loads the rows of mode `i`.
    #[inline(always)]
    pub(super) fn rows<S: Simd>(&self, simd: S, i: usize) -> [Vector<S, K>; 3] {
        self.rows_of(simd, &self.rows, i)
    }

    #[inline(always)]
    fn rows_of<S: Simd>(&self, simd: S, rows: &[&[Rows]; K], i: usize) -> [Vector<S, K>; 3] {
        let mut all = [Vector::splat(simd, 0.0); 3];
        for (k, rows) in rows.iter().enumerate() {
            let [s, t, r] = rows[i].part(simd, self.places[k].part);
            all[0].set(k, s);
            all[1].set(k, t);
            all[2].set(k, r);
        }
        all
    }

    /// Loads the three rows of `Omega x Phi_i` for each mode; none if the slip velocity excludes this term.
    #[inline(always)]
    pub(super) fn convected<S: Simd>(
        &self,
        simd: S,
    ) -> impl Iterator<Item = [Vector<S, K>; 3]> + use<'_, 'a, S, K> {
        (0..self.convected[0].len()).map(
            #[inline(always)]
            move |i| self.rows_of(simd, &self.convected, i),
        )
    }

    /// Collects a number of each node of the group, zero for the padding.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(
        &self,
        simd: S,
        count: usize,
        of: impl Fn(usize) -> f64,
    ) -> Vector<S, K> {
        Vector::from_parts(
            simd,
            #[inline(always)]
            |k| {
                let first = (self.first + k) * S::F64_LANES;
                Vector::from_lanes(
                    simd,
                    #[inline(always)]
                    |lane| {
                        if first + lane < count {
                            of(first + lane)
                        } else {
                            0.0
                        }
                    },
                )
            },
        )
    }

    /// Gives the number of each node of the group without the padding to a function.
    #[inline(always)]
    pub(super) fn scatter<S: Simd>(
        &self,
        numbers: Vector<S, K>,
        count: usize,
        mut to: impl FnMut(usize, f64),
    ) {
        for k in 0..K {
            let first = (self.first + k) * S::F64_LANES;
            let lanes = numbers.one(k).lanes();
            for (lane, number) in lanes[..S::F64_LANES].iter().enumerate() {
                if first + lane < count {
                    to(first + lane, *number);
                }
            }
        }
    }

    /// Projects forces on the nodes of the group onto a mode with these rows and adds them to its sum.
    #[inline(always)]
    pub(super) fn project<S: Simd, const FRICTION: bool>(
        simd: S,
        [s, t, r]: [Vector<S, K>; 3],
        [along, across, outward]: [Vector<S, K>; 3],
        sum: &mut [f64; LANES],
    ) {
        let mut total = Vector::load(simd, sum, 0);
        for k in 0..K {
            if FRICTION {
                total = s.one(k).mul_add(along.one(k), total);
                total = t.one(k).mul_add(across.one(k), total);
            }
            total = r.one(k).mul_add(outward.one(k), total);
        }
        total.store(sum, 0);
    }
}

/// Motion of the nodes in the sliding frames.
#[derive(Clone, Copy)]
pub(super) struct Motion<S: Simd, const K: usize> {
    /// Radial displacement relative to steady sliding, m.
    u_r: Vector<S, K>,
    /// Slip velocity without `Omega x u`, m/s.
    velocity: [Vector<S, K>; 3],
    /// Slip velocity, m/s.
    pub(super) slip: [Vector<S, K>; 3],
}

/// Normal force of the nodes, N.
pub(super) struct Normal<S: Simd, const K: usize, const N: usize> {
    /// Gap function, Pa.
    pub(super) gap: Dual<S, K, N>,
    /// Force of the springs.
    pub(super) spring: Dual<S, K, N>,
    /// Force of springs and dashpots.
    pub(super) total: Dual<S, K, N>,
}

/// The laws of the contact at a state. The extras are contact damping, `Omega x u` and the power.
pub(crate) struct NodeLaw<'a, L, const EXTRAS: bool> {
    pub nodes: &'a Nodes,
    pub law: L,
    pub damping: ContactDamping,
    pub contact: Separation<'a>,
    /// Modal coordinates, modal velocities, and states of friction relative to those of steady sliding.
    pub parts: [&'a [f64]; 3],
    /// States of friction in steady sliding.
    pub steady_states: &'a [f64],
}

impl<L: ContactLaw, const EXTRAS: bool> NodeLaw<'_, L, EXTRAS> {
    /// Eq. (4) and (7) in the sliding frames.
    #[inline(always)]
    pub(super) fn motion<S: Simd, const K: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
    ) -> Motion<S, K> {
        let modes = group.modes();
        let [q, v, _] = self.parts;
        let (q, v) = (&q[..modes], &v[..modes]);
        let zero = Vector::splat(simd, 0.0);
        let mut u_r = zero;
        let mut velocity = [group.load(simd, |block| &block.speed), zero, zero];
        for i in 0..modes {
            let [s, t, r] = group.rows(simd, i);
            u_r = r.mul_add(Vector::splat(simd, q[i]), u_r);
            if L::HAS_FRICTION || EXTRAS {
                let [along, across, outward] = &mut velocity;
                let v = Vector::splat(simd, v[i]);
                *along = s.mul_add(v, *along);
                *across = t.mul_add(v, *across);
                if EXTRAS || self.law.radial() {
                    *outward = r.mul_add(v, *outward);
                }
            }
        }
        let mut slip = velocity;
        if EXTRAS {
            for (rows, q) in group.convected(simd).zip(q) {
                for (slip, row) in slip.iter_mut().zip(rows) {
                    *slip = row.mul_add(Vector::splat(simd, *q), *slip);
                }
            }
        }
        Motion {
            u_r,
            velocity,
            slip,
        }
    }

    /// Eq. (2): `N = max(0, p_n + k_c u_r)`, with `u_r` (m) from steady sliding, times the area. The inputs of the
    /// derivative are displacement and approach velocity.
    #[inline(always)]
    pub(super) fn normal<S: Simd, const K: usize, const N: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
        motion: &Motion<S, K>,
    ) -> Normal<S, K, N> {
        let stiffness = group.load(simd, |block| &block.stiffness);
        let pre_stress = group.load(simd, |block| &block.pre_stress);
        let area = group.load(simd, |block| &block.area);
        let gap = Dual::input(motion.u_r, 0).times_plus(stiffness, pre_stress);
        let spring = self.contact.stress(group.first, gap);
        let mut total = spring;
        if EXTRAS && !self.damping.is_none() {
            let rate = Dual::input(motion.velocity[2], 1);
            let unclamped = self.damping.unclamped(gap, stiffness, rate);
            total = self.contact.damped(group.first, gap, unclamped);
        }
        Normal {
            gap,
            spring: spring.times(area),
            total: total.times(area),
        }
    }

    /// The coefficient of friction along the axes of the sliding frame, with the opposite sign, and the rate of
    /// the state. The inputs of the derivative are the components of slip velocity and state.
    #[inline(always)]
    pub(super) fn friction<S: Simd, const K: usize, const N: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
        motion: &Motion<S, K>,
    ) -> [[Dual<S, K, N>; 3]; 2] {
        let zero = Dual::constant(Vector::splat(simd, 0.0));
        let (mut slip, mut state) = ([zero; 3], [zero; 3]);
        let axes = if self.law.radial() { 3 } else { 2 };
        for (i, slip) in slip[..axes].iter_mut().enumerate() {
            *slip = Dual::input(motion.slip[i], i);
        }
        let count = self.law.states();
        for (i, state) in state[..count].iter_mut().enumerate() {
            let of_node = |node: usize| {
                self.parts[2][node * count + i] + self.steady_states[node * count + i]
            };
            *state = Dual::input(group.gather(simd, self.nodes.count, of_node), 3 + i);
        }
        self.law.response(slip, state)
    }
}

/// The kernel: one pass over all nodes. `N` is the number of inputs of the friction law if the derivatives are required.
/// Returns the power (W) of the deviation of friction from steady sliding and of contact damping, if it is required.
pub(crate) struct ContactForceKernel<
    'a,
    L,
    const RECORDED: bool,
    const N: usize,
    const EXTRAS: bool,
> {
    pub node_law: NodeLaw<'a, L, EXTRAS>,
    /// Generalised forces and rates of steady sliding.
    pub steady: [&'a [f64]; 2],
    pub audited: bool,
    /// Output: generalised forces, `m`, and the rates of the states of friction, minus those of steady sliding.
    pub rates: &'a mut [f64],
    /// Output: derivatives at the nodes ([`keep_slopes`]), if required.
    pub record: Option<&'a mut [[f64; LANES]]>,
}

impl<L: ContactLaw, const RECORDED: bool, const N: usize, const EXTRAS: bool> WithSimd
    for ContactForceKernel<'_, L, RECORDED, N, EXTRAS>
{
    type Output = f64;

    /// Eq. (8): the generalised force of mode `i` is `sum over nodes of (-mu N V_vec/V - N e_r) . Phi_i
    /// Delta A`, N/sqrt(kg).
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> f64 {
        let nodes = self.node_law.nodes;
        let modes = nodes.modes;
        let mut few = [Eight::ZERO; PAPER_MODES];
        let mut many;
        let sums = if modes <= PAPER_MODES {
            &mut few[..modes]
        } else {
            many = [Eight::ZERO; MAX_MODES];
            &mut many[..modes]
        };
        let mut power = Vector::splat(simd, 0.0);
        let vectors = 0..nodes.blocks.len() * parts::<S>();
        let left = self.pass::<S, VECTORS_PER_GROUP>(simd, vectors, sums, &mut power);
        // Otherwise a block fills whole groups.
        if const { parts::<S>() < VECTORS_PER_GROUP } {
            self.pass::<S, 1>(simd, left, sums, &mut power);
        }
        let (forces, rates) = self.rates.split_at_mut(modes);
        for ((out, sum), steady) in forces.iter_mut().zip(sums).zip(self.steady[0]) {
            *out = -sum.part(simd, 0).sum() - steady;
        }
        for (out, steady) in rates.iter_mut().zip(self.steady[1]) {
            *out -= steady;
        }
        power.sum()
    }
}

impl<L: ContactLaw, const RECORDED: bool, const N: usize, const EXTRAS: bool>
    ContactForceKernel<'_, L, RECORDED, N, EXTRAS>
{
    /// The loop over vectors of nodes, `K` at a time; returns the remaining vectors. `sums` contains one
    /// sum per mode, in as many lanes as a vector has.
    #[inline(always)]
    fn pass<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        mut vectors: Range<usize>,
        sums: &mut [Eight],
        power: &mut Vector<S>,
    ) -> Range<usize> {
        let nodes = self.node_law.nodes;
        // With an index bound that is common to all rows, which removes bounds checks.
        let sums = &mut sums[..nodes.modes];
        while vectors.len() >= K {
            let group = Group::<K>::new::<S>(nodes, vectors.start);
            let motion = self.node_law.motion(simd, &group);
            let force = self.resistance(simd, &group, &motion, power);
            for (i, sum) in sums.iter_mut().enumerate() {
                let rows = group.rows(simd, i);
                if L::HAS_FRICTION {
                    Group::project::<S, true>(simd, rows, force, &mut sum.0);
                } else {
                    Group::project::<S, false>(simd, rows, force, &mut sum.0);
                }
            }
            vectors.start += K;
        }
        vectors
    }

    /// Negative force on the nodes in the sliding frame, N.
    ///
    /// Eq. (1): the normal force on the ball is `-N e_r`, per area.
    ///
    /// Eq. (3): the friction force is `-mu(V) N V_vec / V`, per area.
    ///
    /// Eq. (6): the virtual work of both, summed over the nodes with their areas `Delta A` (m^2).
    #[inline(always)]
    fn resistance<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        group: &Group<'_, K>,
        motion: &Motion<S, K>,
        power: &mut Vector<S>,
    ) -> [Vector<S, K>; 3] {
        let law = &self.node_law;
        let normal = law.normal::<S, K, 0>(simd, group, motion);
        let load = normal.total.value;
        let response = law.friction::<S, K, N>(simd, group, motion);
        let [coefficient, rate] = response;
        let zero = Vector::splat(simd, 0.0);
        let mut force = [zero, zero, load];
        if L::HAS_FRICTION {
            force[0] = load * coefficient[0].value;
            force[1] = load * coefficient[1].value;
            if law.law.radial() {
                force[2] = load.mul_add(coefficient[2].value, load);
            }
        }
        let count = law.law.states();
        let rates = &mut self.rates[law.nodes.modes..];
        for (i, rate) in rate[..count].iter().enumerate() {
            group.scatter(rate.value, law.nodes.count, |node, rate| {
                rates[node * count + i] = rate;
            });
        }
        if EXTRAS && self.audited {
            let steady_speed = group.load(simd, |block| &block.speed);
            let steady_friction = group.load(simd, |block| &block.steady_friction);
            let [along, across, outward] = motion.velocity;
            let mut lost = (force[0] + steady_friction) * (along - steady_speed);
            lost = force[1].mul_add(across, lost);
            lost = (force[2] - normal.spring.value).mul_add(outward, lost);
            for k in 0..K {
                *power = *power - lost.one(k);
            }
        }
        if RECORDED && let Some(record) = self.record.as_deref_mut() {
            let normal = law.normal::<S, K, 2>(simd, group, motion).total;
            keep_slopes(record, group.first, &normal, &response);
        }
        force
    }
}
