//! Eq. (6) and (8): the generalised forces of contact and friction. This is the hot loop.
//!
//! The friction law is matched once, outside the loop over the nodes, and the loop is compiled for each law
//! and for the widest available SIMD vectors. Disabled effects have no cost: without friction, for example,
//! no velocity is computed. The loop is also compiled for each [`KernelVariant`]: force, record, and all outputs
//! without and with the optional terms (contact damping and `Omega x u`). The separation rule is matched once
//! per group of nodes, where its cost is not measurable.
//!
//! Each combination takes time to compile. Custom laws, and machines without SIMD, have only the variants with
//! all outputs.
//!
//! Groups of [`VECTORS_PER_GROUP`] vectors of nodes pass through three stages: motion of the nodes, force on the
//! nodes, and projection of the force onto the modes. The first and the last stage are sums of products,
//! limited by the arithmetic throughput. The second stage is limited by latency: a chain from the squared
//! velocities through a root, exponentials and a quotient to the force. The motion of the next group is
//! therefore computed before the projection of the current one, which depends on this chain.

use std::marker::PhantomData;
use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::damping::ContactDamping;
use super::friction_kernel::FrictionKernel;
use super::model::MAX_MODES;
use super::node_slopes::{KEPT, NodeSlopes};
use super::nodes::{Block, Nodes, Rows, View};
use super::separation::Separation;
use super::simd::{Eight, LANES, LanePosition, Vector, parts};

/// Number of adjacent vectors of nodes in a group. More vectors hide more latency, but exceed the number of
/// registers; if the nodes do not fit in the first-level cache, two are the fastest.
pub(super) const VECTORS_PER_GROUP: usize = 2;

/// Number of modes in the paper, for which the sums are allocated statically.
pub(crate) const PAPER_MODES: usize = 11;

/// Input and output of the kernel.
pub(crate) struct KernelInput<'a> {
    /// Separation rule.
    pub contact: Separation<'a>,
    /// Output: derivatives at the nodes, if required.
    pub record: Option<&'a mut [[f64; LANES]]>,
    /// Whether the power is required.
    pub audited: bool,
    /// State of the joint, of which the kernel reads modal coordinates, modal velocities and the states of friction.
    pub z: &'a [f64],
    /// Output: generalised forces minus those of steady sliding, `m`, and the rates of the states of friction.
    pub out: &'a mut [f64],
}

impl KernelInput<'_> {
    /// Reborrows the fields, which lets the compiler keep them in registers.
    #[inline(always)]
    fn reborrow(&mut self) -> KernelInput<'_> {
        KernelInput {
            contact: self.contact,
            record: self.record.as_deref_mut(),
            audited: self.audited,
            z: self.z,
            out: self.out,
        }
    }
}

/// Compile-time variant of the kernel: outputs in addition to the force.
pub(crate) trait KernelVariant {
    /// The variant on a machine without SIMD.
    type Scalar: KernelVariant;

    /// Whether the kernel evaluates contact damping and `Omega x u`.
    const OPTIONAL_TERMS: bool = false;

    /// The record, if the variant writes one.
    fn record<'q>(query: &'q mut KernelInput<'_>) -> Option<&'q mut [[f64; LANES]]>;

    /// Whether the power is computed.
    #[inline(always)]
    fn audited(_query: &KernelInput<'_>) -> bool {
        false
    }
}

/// Force only.
pub(crate) struct Force;

/// Force and record.
pub(crate) struct Record;

/// Force, with power and record if required; with or without the optional terms.
pub(crate) struct AsRequired<const OPTIONAL_TERMS: bool>;

impl KernelVariant for Force {
    type Scalar = AsRequired<false>;

    #[inline(always)]
    fn record<'q>(_query: &'q mut KernelInput<'_>) -> Option<&'q mut [[f64; LANES]]> {
        None
    }
}

impl KernelVariant for Record {
    type Scalar = AsRequired<false>;

    #[inline(always)]
    fn record<'q>(query: &'q mut KernelInput<'_>) -> Option<&'q mut [[f64; LANES]]> {
        Some(query.record.as_deref_mut().expect("a record is kept"))
    }
}

impl<const OPTIONAL_TERMS: bool> KernelVariant for AsRequired<OPTIONAL_TERMS> {
    type Scalar = Self;

    const OPTIONAL_TERMS: bool = OPTIONAL_TERMS;

    #[inline(always)]
    fn record<'q>(query: &'q mut KernelInput<'_>) -> Option<&'q mut [[f64; LANES]]> {
        query.record.as_deref_mut()
    }

    #[inline(always)]
    fn audited(query: &KernelInput<'_>) -> bool {
        query.audited
    }
}

/// The kernel: one pass over all nodes.
pub(crate) struct ContactForceKernel<'p, 'a, L, T> {
    pub nodes: &'p Nodes,
    pub law: L,
    pub task: PhantomData<T>,
    pub damping: ContactDamping,
    /// Generalised forces of steady sliding, `m`.
    pub steady: &'p [f64],
    pub query: &'p mut KernelInput<'a>,
}

/// Results of the kernel in addition to the forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct KernelOutput {
    /// Power of the deviation of friction from steady sliding, and of contact damping, W; zero if not
    /// required.
    pub power: f64,
}

/// Adjacent vectors of nodes.
pub(super) struct Group<'a, const K: usize> {
    /// Index of the first vector.
    pub(super) first: usize,
    places: [LanePosition; K],
    blocks: [&'a Block; K],
    /// Rows of all modes.
    rows: [&'a [Rows]; K],
}

impl<'a, const K: usize> Group<'a, K> {
    #[inline(always)]
    pub(super) fn new<S: Simd>(nodes: View<'a>, first: usize) -> Self {
        let place = LanePosition::of::<S>(first);
        let mut group = Self {
            first,
            places: [place; K],
            blocks: [&nodes.blocks[place.block]; K],
            rows: [&[]; K],
        };
        for k in 0..K {
            let place = LanePosition::of::<S>(first + k);
            group.places[k] = place;
            group.blocks[k] = &nodes.blocks[place.block];
            group.rows[k] = &nodes.rows[place.block * nodes.modes..][..nodes.modes];
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

    /// Loads a row of mode `i`.
    #[inline(always)]
    pub(super) fn row<S: Simd>(
        &self,
        simd: S,
        i: usize,
        of: impl Fn(&Rows) -> &Eight,
    ) -> Vector<S, K> {
        Vector::from_parts(
            simd,
            #[inline(always)]
            |k| of(&self.rows[k][i]).part(simd, self.places[k].part),
        )
    }
}

/// Motion of the nodes: radial displacement relative to steady sliding, m, and slip velocity in the sliding
/// frame, m/s.
#[derive(Clone, Copy)]
pub(super) struct Motion<S: Simd, const K: usize> {
    pub(super) u_r: Vector<S, K>,
    pub(super) slip: [Vector<S, K>; 3],
    /// Approach velocity `du_r/dt`, m/s; with optional terms only.
    pub(super) rate: Vector<S, K>,
    /// Slip velocity without `Omega x u`, m/s; with optional terms only.
    pub(super) unconvected: [Vector<S, K>; 3],
}

/// Negative force on the nodes in the sliding frame, N.
pub(super) type Resistance<S, const K: usize> = [Vector<S, K>; 3];

impl<L: FrictionKernel, T: KernelVariant> WithSimd for ContactForceKernel<'_, '_, L, T> {
    type Output = KernelOutput;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> KernelOutput {
        if const { S::F64_LANES == 1 } {
            return without_simd(ContactForceKernel {
                nodes: self.nodes,
                law: self.law,
                task: PhantomData::<T::Scalar>,
                damping: self.damping,
                steady: self.steady,
                query: self.query,
            });
        }
        self.evaluate(simd)
    }
}

/// The kernel on a machine without SIMD; compiled once for the variants that share it.
#[inline(never)]
fn without_simd<L: FrictionKernel, T: KernelVariant>(
    kernel: ContactForceKernel<'_, '_, L, T>,
) -> KernelOutput {
    kernel.evaluate(pulp::Scalar::new())
}

impl<L: FrictionKernel, T: KernelVariant> ContactForceKernel<'_, '_, L, T> {
    /// Eq. (8): the generalised force of mode `i` is `sum over nodes of (-mu N V_vec/V - N e_r) . Phi_i
    /// Delta A`, N/sqrt(kg).
    #[inline(always)]
    fn evaluate<S: Simd>(self, simd: S) -> KernelOutput {
        let mut query = self.query.reborrow();
        let steady = self.steady;
        let mut own = ContactForceKernel::<L, T> {
            nodes: self.nodes,
            law: self.law,
            task: self.task,
            damping: self.damping,
            steady,
            query: &mut query,
        };
        let nodes = self.nodes.view();
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
        // All vectors of a small patch at once hide the latency of each other.
        let left = match (const { parts::<S>() }, vectors.len()) {
            (1, 3) => own.pass::<S, 3>(simd, nodes, vectors, sums, &mut power),
            (1, 4) => own.pass::<S, 4>(simd, nodes, vectors, sums, &mut power),
            _ => own.pass::<S, VECTORS_PER_GROUP>(simd, nodes, vectors, sums, &mut power),
        };
        // Otherwise a block fills whole groups.
        if const { parts::<S>() < VECTORS_PER_GROUP } {
            own.pass::<S, 1>(simd, nodes, left, sums, &mut power);
        }
        for ((out, sum), steady) in query.out.iter_mut().zip(sums).zip(steady) {
            *out = -sum.part(simd, 0).sum() - steady;
        }
        KernelOutput { power: power.sum() }
    }

    /// The loop over vectors of nodes, `K` at a time; returns the remaining vectors. `sums` contains one
    /// sum per mode, in as many lanes as a vector has.
    #[inline(always)]
    fn pass<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        nodes: View<'_>,
        mut vectors: Range<usize>,
        sums: &mut [Eight],
        power: &mut Vector<S>,
    ) -> Range<usize> {
        if vectors.len() < K {
            return vectors;
        }
        let mut group = Group::<K>::new::<S>(nodes, vectors.start);
        let mut motion = self.motion(simd, &group);
        loop {
            let resistance = self.resistance(simd, &group, motion, power);
            vectors.start += K;
            if vectors.len() < K {
                project::<S, L, K>(simd, &group, resistance, sums);
                return vectors;
            }
            let next = Group::<K>::new::<S>(nodes, vectors.start);
            motion = self.motion(simd, &next);
            project::<S, L, K>(simd, &group, resistance, sums);
            group = next;
        }
    }

    /// Eq. (4) and (7) in the sliding frames.
    #[inline(always)]
    pub(super) fn motion<S: Simd, const K: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
    ) -> Motion<S, K> {
        let modes = group.modes();
        let (q, v) = self.query.z[..2 * modes].split_at(modes);
        let zero = Vector::splat(simd, 0.0);
        let mut u_r = zero;
        if !L::HAS_FRICTION {
            for (i, &q) in q.iter().enumerate() {
                let r = group.row(simd, i, |row| &row.r);
                u_r = r.mul_add(Vector::splat(simd, q), u_r);
            }
            return Motion {
                u_r,
                slip: [zero; 3],
                rate: self.rate(simd, group),
                unconvected: [zero; 3],
            };
        }
        let steady_speed = group.load(simd, |block| &block.speed);
        let (mut along, mut across, mut outward) = (steady_speed, zero, zero);
        for i in 0..modes {
            let r = group.row(simd, i, |row| &row.r);
            u_r = r.mul_add(Vector::splat(simd, q[i]), u_r);
            let v = Vector::splat(simd, v[i]);
            along = group.row(simd, i, |row| &row.s).mul_add(v, along);
            across = group.row(simd, i, |row| &row.t).mul_add(v, across);
            if self.law.radial() {
                outward = r.mul_add(v, outward);
            }
        }
        let mut motion = Motion {
            u_r,
            slip: [along, across, outward],
            rate: zero,
            unconvected: [zero; 3],
        };
        if T::OPTIONAL_TERMS {
            motion.rate = self.rate(simd, group);
            motion.unconvected = motion.slip;
            let convected = self.convected(simd, group);
            let axes = if self.law.radial() { 3 } else { 2 };
            for (slip, part) in motion.slip[..axes].iter_mut().zip(convected) {
                *slip = *slip + part;
            }
        }
        motion
    }

    /// Approach velocity `du_r/dt` for contact damping; zero without damping.
    #[inline(always)]
    fn rate<S: Simd, const K: usize>(&self, simd: S, group: &Group<'_, K>) -> Vector<S, K> {
        let mut rate = Vector::splat(simd, 0.0);
        if T::OPTIONAL_TERMS && !self.damping.is_none() {
            for (i, &v) in self.query.z[group.modes()..][..group.modes()]
                .iter()
                .enumerate()
            {
                let r = group.row(simd, i, |row| &row.r);
                rate = r.mul_add(Vector::splat(simd, v), rate);
            }
        }
        rate
    }

    /// The term `Omega x u` of the slip velocity.
    #[inline(always)]
    fn convected<S: Simd, const K: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
    ) -> [Vector<S, K>; 3] {
        let mut sums = [Vector::splat(simd, 0.0); 3];
        let mut rows: [&[Rows]; K] = [&[]; K];
        for (rows, place) in rows.iter_mut().zip(group.places) {
            *rows = self.nodes.convected_rows(place.block);
        }
        for (i, &q) in self.query.z[..rows[0].len()].iter().enumerate() {
            let q = Vector::splat(simd, q);
            for (axis, sum) in sums.iter_mut().enumerate() {
                let row = Vector::from_parts(
                    simd,
                    #[inline(always)]
                    |k| rows[k][i].part(simd, group.places[k].part)[axis],
                );
                *sum = row.mul_add(q, *sum);
            }
        }
        sums
    }

    /// The normal force and its derivative with respect to `u_r`, per node. The derivative is zero unless the
    /// record needs it.
    ///
    /// Eq. (2): `N = max(0, p_n + k_c u_r)`, with `u_r` (m) from steady sliding.
    #[inline(always)]
    fn normal<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        group: &Group<'_, K>,
        motion: &Motion<S, K>,
        power: &mut Vector<S>,
    ) -> [Vector<S, K>; 2] {
        let stiffness = group.load(simd, |block| &block.stiffness);
        let gap = stiffness.mul_add(motion.u_r, group.load(simd, |block| &block.pre_stress));
        let area = group.load(simd, |block| &block.area);
        let contact = self.query.contact;
        let mut stress = contact.stress(group.first, gap);
        let mut pressing = Vector::splat(simd, 0.0);
        if T::OPTIONAL_TERMS {
            let at = [gap, stress, stiffness, motion.rate];
            let damped = self.damping.stress(contact, group.first, at);
            let dashpot = damped.normal - stress;
            stress = damped.normal;
            pressing = damped.stiffness * area;
            if let Some(record) = T::record(self.query)
                && !self.damping.is_none()
            {
                let kept = &mut record[self.nodes.blocks.len() * KEPT..];
                let viscosity = damped.viscosity * area;
                for k in 0..K {
                    let place = group.places[k];
                    viscosity.one(k).store(&mut kept[place.block], place.part);
                }
            }
            if T::audited(self.query) {
                let lost = dashpot * area * motion.rate;
                for k in 0..K {
                    *power = *power - lost.one(k);
                }
            }
        }
        let normal = stress * area;
        if !T::OPTIONAL_TERMS && T::record(self.query).is_some() {
            pressing = contact.pressing(group.first, gap, stiffness * area);
        }
        [normal, pressing]
    }

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
        motion: Motion<S, K>,
        power: &mut Vector<S>,
    ) -> Resistance<S, K> {
        let zero = Vector::splat(simd, 0.0);
        let [normal, pressing] = self.normal(simd, group, &motion, power);
        if !L::HAS_FRICTION {
            if let Some(record) = T::record(self.query) {
                if T::OPTIONAL_TERMS {
                    NodeSlopes::frictionless(simd, pressing).keep(KEPT, record, group.first)
                } else {
                    NodeSlopes::keep_stiffness(pressing, record, group.first)
                }
            }
            return [zero, zero, normal];
        }
        let [along, across, outward] = motion.slip;
        let mut square = across.mul_add(across, along * along);
        if self.law.radial() {
            square = outward.mul_add(outward, square);
        }
        // A tiny lower bound permits the division in mu(V)/V.
        let speed = square.at_least(1e-280).sqrt();
        let drag = if let Some(record) = T::record(self.query) {
            let (ratio, slope) = self.law.ratio_and_slope(speed);
            let drag = normal * ratio;
            let inverse = speed.broadcast(1.0) / speed;
            let slopes = NodeSlopes {
                stiffness: pressing,
                coefficient: ratio * speed,
                drag,
                bend: normal * slope,
                direction: [along * inverse, across * inverse, outward * inverse],
            };
            // The optional terms use all derivatives.
            let count = if self.law.radial() || T::OPTIONAL_TERMS {
                KEPT
            } else {
                KEPT - 1
            };
            slopes.keep(count, record, group.first);
            drag
        } else {
            normal * self.law.ratio(speed)
        };
        if T::audited(self.query) {
            let steady_friction = group.load(simd, |block| &block.steady_friction);
            let [own_along, own_across, own_outward] = match T::OPTIONAL_TERMS {
                true => motion.unconvected,
                false => motion.slip,
            };
            let steady_speed = group.load(simd, |block| &block.speed);
            let vibration = own_along - steady_speed;
            let mut lost = drag.mul_add(along, steady_friction) * vibration;
            lost = (drag * across).mul_add(own_across, lost);
            lost = (drag * outward).mul_add(own_outward, lost);
            for k in 0..K {
                *power = *power - lost.one(k);
            }
        }
        let mut radial = normal;
        if self.law.radial() {
            radial = drag.mul_add(outward, normal);
        }
        [drag * along, drag * across, radial]
    }
}

/// Projects the forces of a group onto the modes and adds them to the sums.
#[inline(always)]
pub(super) fn project<S: Simd, L: FrictionKernel, const K: usize>(
    simd: S,
    group: &Group<'_, K>,
    [along, across, outward]: Resistance<S, K>,
    sums: &mut [Eight],
) {
    // With an index bound that is common to all rows, which removes bounds checks.
    let sums = &mut sums[..group.modes()];
    #[expect(clippy::needless_range_loop, reason = "the rows have as many")]
    for i in 0..group.modes() {
        let mut sum = sums[i].part(simd, 0);
        for k in 0..K {
            let [s, t, r] = group.rows[k][i].part(simd, group.places[k].part);
            if L::HAS_FRICTION {
                sum = s.mul_add(along.one(k), sum);
                sum = t.mul_add(across.one(k), sum);
            }
            sum = r.mul_add(outward.one(k), sum);
        }
        sum.store(&mut sums[i].0, 0);
    }
}

/// The kernel for the contact status from the gap functions.
pub(crate) struct SeparatedNodes<'a> {
    pub nodes: &'a Nodes,
    pub q: &'a [f64],
    /// Output: one bit per node, eight nodes per byte; a set bit is a separated node.
    pub status: &'a mut [u8],
}

impl WithSimd for SeparatedNodes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for ((block, rows), bits) in self.nodes.iter().zip(self.status.iter_mut()) {
            *bits = 0;
            for part in 0..parts::<S>() {
                let gap = block.gap(simd, rows, part, self.q);
                *bits |= gap.negative_bits() << (part * S::F64_LANES);
            }
        }
    }
}
