//! Eq. (6) and (8): the generalised forces of contact and friction. The hot loop.
//!
//! The law of friction is matched once, outside the loop over the nodes; the loop is then compiled
//! for that very law and for the widest vectors of the machine. An absent effect costs nothing:
//! without friction no velocity is formed. It is compiled for each [`Task`], too: a record, the power, and what
//! few scenes ask for, damping of the contact and the part `Omega x u` of the slip velocity. How nodes lift
//! off is met once for some nodes, where it does not show.
//!
//! The nodes go through three stages, [`TOGETHER`] vectors of them side by side: how they move, what
//! force acts on them, and what this force does to the modes. The first and the last are sums of
//! products, which are limited by how many of them the machine can do; the second is a long chain,
//! from the squares of the velocities by a root, exponentials and a quotient to the force, during
//! which the machine would wait. So the motion of the next nodes is worked out in between: it comes
//! before the force on the modes, which waits for the chain.

use std::marker::PhantomData;
use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::damping::ContactDamping;
use super::extras::{convected, viscosities};
use super::lanes::{Eight, LANES, Place, Vector, parts};
use super::law::Law;
use super::lift_off::LiftOff;
use super::model::MOST_MODES;
use super::nodes::{Block, Nodes, Rows, View};
use super::record::{KEPT, NodeSlopes};

/// Vectors of nodes side by side. More of them wait less, but need more registers than there are;
/// where the nodes do not fit the first cache, two are the fastest.
pub(super) const TOGETHER: usize = 2;

/// Number of modes in the paper: room for them is made without asking.
pub(crate) const PAPER_MODES: usize = 11;

/// What is asked of a pass over the nodes.
pub(crate) struct Query<'a> {
    /// Which nodes press.
    pub contact: LiftOff<'a>,
    /// Gets what is kept for the derivative, where that is wanted.
    pub record: Option<&'a mut [[f64; LANES]]>,
    /// Whether the power is wanted.
    pub audited: bool,
    /// Modal coordinates and velocities.
    pub q: &'a [f64],
    pub v: &'a [f64],
    /// Gets the generalised forces less those of steady sliding, `m`.
    pub force: &'a mut [f64],
}

impl Query<'_> {
    /// The same once more, where a pass has it at hand.
    #[inline(always)]
    fn again(&mut self) -> Query<'_> {
        Query {
            contact: self.contact,
            record: self.record.as_deref_mut(),
            audited: self.audited,
            q: self.q,
            v: self.v,
            force: self.force,
        }
    }
}

/// What a pass is compiled to do beside the force: the rest is not even asked for among the nodes.
pub(crate) trait Task {
    /// Whether there is damping of the contact or `Omega x u`.
    const EXTRAS: bool = false;

    /// Where the record goes, if one is kept.
    #[inline(always)]
    fn record<'q>(_query: &'q mut Query<'_>) -> Option<&'q mut [[f64; LANES]]> {
        None
    }

    /// Whether the power is wanted.
    #[inline(always)]
    fn audited(_query: &Query<'_>) -> bool {
        false
    }
}

/// The force alone.
pub(crate) struct Force;

/// The force and the record.
pub(crate) struct Record;

/// The force and its power, and the record where it is wanted.
pub(crate) struct Audit;

/// The extras, and whatever is wanted.
pub(crate) struct Extras;

impl Task for Force {}

impl Task for Record {
    #[inline(always)]
    fn record<'q>(query: &'q mut Query<'_>) -> Option<&'q mut [[f64; LANES]]> {
        Some(query.record.as_deref_mut().expect("a record is kept"))
    }
}

impl Task for Audit {
    #[inline(always)]
    fn record<'q>(query: &'q mut Query<'_>) -> Option<&'q mut [[f64; LANES]]> {
        query.record.as_deref_mut()
    }

    #[inline(always)]
    fn audited(_query: &Query<'_>) -> bool {
        true
    }
}

impl Task for Extras {
    const EXTRAS: bool = true;

    #[inline(always)]
    fn record<'q>(query: &'q mut Query<'_>) -> Option<&'q mut [[f64; LANES]]> {
        query.record.as_deref_mut()
    }

    #[inline(always)]
    fn audited(query: &Query<'_>) -> bool {
        query.audited
    }
}

/// One pass over the nodes.
pub(crate) struct Traction<'p, 'a, L, T> {
    pub nodes: &'p Nodes,
    pub law: L,
    pub task: PhantomData<T>,
    pub damping: ContactDamping,
    /// Generalised forces of steady sliding, `m`.
    pub steady: &'p [f64],
    pub query: &'p mut Query<'a>,
}

/// What the pass found beside the forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Passed {
    /// Power of friction's deviation from steady sliding, and of damping of the contact, on the vibration,
    /// W; zero where it is not wanted.
    pub power: f64,
}

/// Some vectors of nodes, side by side.
pub(super) struct Group<'a, const K: usize> {
    /// Number of the first vector.
    pub(super) first: usize,
    places: [Place; K],
    blocks: [&'a Block; K],
    /// The rows of all modes.
    rows: [&'a [Rows]; K],
}

impl<'a, const K: usize> Group<'a, K> {
    #[inline(always)]
    pub(super) fn new<S: Simd>(nodes: View<'a>, first: usize) -> Self {
        let place = Place::of::<S>(first);
        let mut group = Self {
            first,
            places: [place; K],
            blocks: [&nodes.blocks[place.block]; K],
            rows: [&[]; K],
        };
        for k in 0..K {
            let place = Place::of::<S>(first + k);
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

    /// Something that blocks have.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, of: impl Fn(&Block) -> &Eight) -> Vector<S, K> {
        Vector::beside(
            simd,
            #[inline(always)]
            |k| of(self.blocks[k]).part(simd, self.places[k].part),
        )
    }

    /// A row of mode `i`.
    #[inline(always)]
    pub(super) fn row<S: Simd>(
        &self,
        simd: S,
        i: usize,
        of: impl Fn(&Rows) -> &Eight,
    ) -> Vector<S, K> {
        Vector::beside(
            simd,
            #[inline(always)]
            |k| of(&self.rows[k][i]).part(simd, self.places[k].part),
        )
    }
}

/// How nodes move: radial displacement from steady sliding, m, and slip velocity in the sliding
/// frame, m/s.
#[derive(Clone, Copy)]
struct Motion<S: Simd, const K: usize> {
    u_r: Vector<S, K>,
    slip: [Vector<S, K>; 3],
    /// Of the extras: the velocity `du_r/dt`, m/s.
    rate: Vector<S, K>,
    /// Of the extras: the slip velocity without `Omega x u`, m/s.
    unconvected: [Vector<S, K>; 3],
}

/// What nodes resist with, N: the force on them, turned round, in the sliding frame.
type Resistance<S, const K: usize> = [Vector<S, K>; 3];

impl<L: Law, T: Task> WithSimd for Traction<'_, '_, L, T> {
    type Output = Passed;

    /// Eq. (8): the generalised force of mode `i` is `sum over nodes of
    /// (-mu N V_vec/V - N e_r) . Phi_i Delta A`, N/sqrt(kg).
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Passed {
        let mut query = self.query.again();
        let steady = self.steady;
        let mut own = Traction::<L, T> {
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
            many = [Eight::ZERO; MOST_MODES];
            &mut many[..modes]
        };
        let mut power = Vector::splat(simd, 0.0);
        let vectors = 0..nodes.blocks.len() * parts::<S>();
        let left = own.pass::<S, TOGETHER>(simd, nodes, vectors, sums, &mut power);
        own.pass::<S, 1>(simd, nodes, left, sums, &mut power);
        for ((out, sum), steady) in query.force.iter_mut().zip(sums).zip(steady) {
            *out = -sum.part(simd, 0).sum() - steady;
        }
        Passed { power: power.sum() }
    }
}

impl<L: Law, T: Task> Traction<'_, '_, L, T> {
    /// The loop over vectors of nodes, `K` at a time; those that are left over are given back. The
    /// sums are one a mode, in as many lanes as a vector has.
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
                push::<S, L, K>(simd, &group, resistance, sums);
                return vectors;
            }
            let next = Group::<K>::new::<S>(nodes, vectors.start);
            motion = self.motion(simd, &next);
            push::<S, L, K>(simd, &group, resistance, sums);
            group = next;
        }
    }

    /// Eq. (4) and (7) in the sliding frames.
    #[inline(always)]
    fn motion<S: Simd, const K: usize>(&self, simd: S, group: &Group<'_, K>) -> Motion<S, K> {
        let modes = group.modes();
        let (q, v) = (&self.query.q[..modes], &self.query.v[..modes]);
        let zero = Vector::splat(simd, 0.0);
        let mut u_r = zero;
        if !L::SLIDES {
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
            if L::RADIAL {
                outward = r.mul_add(v, outward);
            }
        }
        let mut motion = Motion {
            u_r,
            slip: [along, across, outward],
            rate: zero,
            unconvected: [zero; 3],
        };
        if T::EXTRAS {
            motion.rate = self.rate(simd, group);
            motion.unconvected = motion.slip;
            let convected = self.convected(simd, group);
            let axes = if L::RADIAL { 3 } else { 2 };
            for (slip, part) in motion.slip[..axes].iter_mut().zip(convected) {
                *slip = *slip + part;
            }
        }
        motion
    }

    /// The velocity `du_r/dt`, for damping of the contact; zero where there is none.
    #[inline(always)]
    fn rate<S: Simd, const K: usize>(&self, simd: S, group: &Group<'_, K>) -> Vector<S, K> {
        let mut rate = Vector::splat(simd, 0.0);
        if T::EXTRAS && !self.damping.is_none() {
            for (i, &v) in self.query.v[..group.modes()].iter().enumerate() {
                let r = group.row(simd, i, |row| &row.r);
                rate = r.mul_add(Vector::splat(simd, v), rate);
            }
        }
        rate
    }

    /// What of the slip velocity is `Omega x u`.
    #[inline(always)]
    fn convected<S: Simd, const K: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
    ) -> [Vector<S, K>; 3] {
        let mut sums = [Vector::splat(simd, 0.0); 3];
        let mut rows: [&[Rows]; K] = [&[]; K];
        for (rows, place) in rows.iter_mut().zip(group.places) {
            *rows = convected(self.nodes, place.block);
        }
        for (i, &q) in self.query.q[..rows[0].len()].iter().enumerate() {
            let q = Vector::splat(simd, q);
            for (axis, sum) in sums.iter_mut().enumerate() {
                let row = Vector::beside(
                    simd,
                    #[inline(always)]
                    |k| rows[k][i].part(simd, group.places[k].part)[axis],
                );
                *sum = row.mul_add(q, *sum);
            }
        }
        sums
    }

    /// Eq. (1): the normal force on the ball is `-N e_r`, per area.
    ///
    /// Eq. (2): `N = max(0, p_n + k_c u_r)`, with `u_r` (m) from steady sliding.
    ///
    /// Eq. (3): the friction force is `-mu(V) N V_vec / V`, per area.
    ///
    /// Eq. (6): the virtual work of both, summed over the nodes with their areas `Delta A` (m^2).
    #[allow(
        clippy::too_many_lines,
        reason = "divided in two, it took more instructions than `off_is_free` allows"
    )]
    #[inline(always)]
    fn resistance<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        group: &Group<'_, K>,
        motion: Motion<S, K>,
        power: &mut Vector<S>,
    ) -> Resistance<S, K> {
        let zero = Vector::splat(simd, 0.0);
        let stiffness = group.load(simd, |block| &block.stiffness);
        let gap = stiffness.mul_add(motion.u_r, group.load(simd, |block| &block.pre_stress));
        let area = group.load(simd, |block| &block.area);
        let contact = self.query.contact;
        let mut stress = contact.stress(group.first, gap);
        let mut pressing = zero;
        if T::EXTRAS {
            let at = [gap, stress, stiffness, motion.rate];
            let dashpot = self.damping.dashpot(contact, group.first, at);
            stress = stress + dashpot.stress;
            pressing = dashpot.stiffness * area;
            if let Some(record) = T::record(self.query)
                && !self.damping.is_none()
            {
                let kept = &mut record[viscosities(self.nodes.blocks.len())..];
                let viscosity = dashpot.viscosity * area;
                for k in 0..K {
                    let place = group.places[k];
                    viscosity.one(k).store(&mut kept[place.block], place.part);
                }
            }
            if T::audited(self.query) {
                let lost = dashpot.stress * area * motion.rate;
                for k in 0..K {
                    *power = *power - lost.one(k);
                }
            }
        }
        let normal = stress * area;
        if !T::EXTRAS && T::record(self.query).is_some() {
            pressing = contact.pressing(group.first, gap, stiffness * area);
        }
        if !L::SLIDES {
            if let Some(record) = T::record(self.query) {
                match T::EXTRAS {
                    false => NodeSlopes::keep_stiffness(pressing, record, group.first),
                    true => {
                        NodeSlopes::frictionless(simd, pressing).keep(KEPT, record, group.first)
                    }
                }
            }
            return [zero, zero, normal];
        }
        let [along, across, outward] = motion.slip;
        let mut square = across.mul_add(across, along * along);
        if L::RADIAL {
            square = outward.mul_add(outward, square);
        }
        // A hair above zero, so that mu(V)/V can be formed by a division.
        let speed = square.at_least(1e-280).sqrt();
        let drag = if let Some(record) = T::record(self.query) {
            let (ratio, slope) = self.law.ratio_and_slope(speed);
            let drag = normal * ratio;
            let inverse = speed.same(1.0) / speed;
            let slopes = NodeSlopes {
                stiffness: pressing,
                coefficient: ratio * speed,
                drag,
                bend: normal * slope,
                direction: [along * inverse, across * inverse, outward * inverse],
            };
            // The extras read all of it.
            let count = if L::RADIAL || T::EXTRAS {
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
            let [own_along, own_across, own_outward] = match T::EXTRAS {
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
        if L::RADIAL {
            radial = drag.mul_add(outward, normal);
        }
        [drag * along, drag * across, radial]
    }
}

/// Adds to the sums, one a mode, what the nodes of a group do.
#[inline(always)]
fn push<S: Simd, L: Law, const K: usize>(
    simd: S,
    group: &Group<'_, K>,
    [along, across, outward]: Resistance<S, K>,
    sums: &mut [Eight],
) {
    // By numbers, of which the compiler sees that all rows have them.
    let sums = &mut sums[..group.modes()];
    #[expect(clippy::needless_range_loop, reason = "the rows have as many")]
    for i in 0..group.modes() {
        let mut sum = sums[i].part(simd, 0);
        for k in 0..K {
            let [s, t, r] = group.rows[k][i].part(simd, group.places[k].part);
            if L::SLIDES {
                sum = s.mul_add(along.one(k), sum);
                sum = t.mul_add(across.one(k), sum);
            }
            sum = r.mul_add(outward.one(k), sum);
        }
        sum.store(&mut sums[i].0, 0);
    }
}

/// A pass over the normal gaps only: which nodes are open.
pub(crate) struct OpenNodes<'a> {
    pub nodes: &'a Nodes,
    pub q: &'a [f64],
    /// Gets one bit a node, eight nodes a byte; a set bit means open.
    pub open: &'a mut [u8],
}

impl WithSimd for OpenNodes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for ((block, rows), bits) in self.nodes.iter().zip(self.open.iter_mut()) {
            *bits = 0;
            for part in 0..parts::<S>() {
                let gap = block.gap(simd, rows, part, self.q);
                *bits |= gap.negative_bits() << (part * S::F64_LANES);
            }
        }
    }
}
