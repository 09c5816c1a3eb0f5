//! Hand-written force kernels for a single setting: motion of the nodes, force on them, projection onto the modes.

use pulp::{Simd, WithSimd};

use crate::joint::contact_force::{Group, PAPER_MODES, VECTORS_PER_GROUP};
use crate::joint::friction::VectorLaw;
use crate::joint::node_slopes::KEPT;
use crate::joint::nodes::{Nodes, View};
use crate::joint::simd::{Eight, LANES, LanePosition, Vector, parts};
use crate::joint::{Constant, Stribeck};

/// A kernel for one setting with `M` components of the motion of a node and `F` of the force on it.
pub(super) trait Setting<const M: usize, const F: usize> {
    fn motion<S: Simd, const K: usize>(&self, simd: S, group: &Group<'_, K>) -> [Vector<S, K>; M];

    fn resistance<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        group: &Group<'_, K>,
        motion: [Vector<S, K>; M],
    ) -> [Vector<S, K>; F];

    fn push<S: Simd, const K: usize>(
        simd: S,
        group: &Group<'_, K>,
        resistance: [Vector<S, K>; F],
        sums: &mut [Eight],
    );
}

/// The loop over the nodes, in the order of the hot loop.
pub(super) struct Pass<'a, T, const M: usize, const F: usize> {
    pub nodes: &'a Nodes,
    pub steady: &'a [f64],
    pub setting: T,
    pub out: &'a mut [f64],
}

impl<T: Setting<M, F>, const M: usize, const F: usize> WithSimd for Pass<'_, T, M, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut sums = [Eight::ZERO; PAPER_MODES];
        let nodes = self.nodes.view();
        let sums = &mut sums[..nodes.modes];
        let vectors = nodes.blocks.len() * parts::<S>();
        let together = vectors - vectors % VECTORS_PER_GROUP;
        self.run::<S, VECTORS_PER_GROUP>(simd, nodes, 0..together, sums);
        if together < vectors {
            self.run::<S, 1>(simd, nodes, together..vectors, sums);
        }
        for ((out, sum), steady) in self.out.iter_mut().zip(sums).zip(self.steady) {
            *out = -sum.part(simd, 0).sum() - steady;
        }
    }
}

impl<T: Setting<M, F>, const M: usize, const F: usize> Pass<'_, T, M, F> {
    #[inline(always)]
    fn run<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        nodes: View<'_>,
        vectors: std::ops::Range<usize>,
        sums: &mut [Eight],
    ) {
        let mut first = vectors.start;
        let mut group = Group::<K>::new::<S>(nodes, first);
        let mut motion = self.setting.motion(simd, &group);
        loop {
            let resistance = self.setting.resistance(simd, &group, motion);
            first += K;
            if first >= vectors.end {
                T::push(simd, &group, resistance, sums);
                return;
            }
            let next = Group::<K>::new::<S>(nodes, first);
            motion = self.setting.motion(simd, &next);
            T::push(simd, &group, resistance, sums);
            group = next;
        }
    }
}

/// The state: modal coordinates and velocities.
#[derive(Clone, Copy)]
pub(super) struct State<'a> {
    pub q: &'a [f64],
    pub v: &'a [f64],
}

impl State<'_> {
    /// Radial displacement.
    #[inline(always)]
    fn radial<S: Simd, const K: usize>(self, simd: S, group: &Group<'_, K>) -> [Vector<S, K>; 1] {
        let mut u_r = Vector::splat(simd, 0.0);
        for (i, &q) in self.q[..group.modes()].iter().enumerate() {
            let r = group.row(simd, i, |row| &row.r);
            u_r = r.mul_add(Vector::splat(simd, q), u_r);
        }
        [u_r]
    }

    /// Radial displacement and tangential slip velocity.
    #[inline(always)]
    fn tangential<S: Simd, const K: usize>(
        self,
        simd: S,
        group: &Group<'_, K>,
    ) -> [Vector<S, K>; 3] {
        let (q, v) = (&self.q[..group.modes()], &self.v[..group.modes()]);
        let (mut u_r, mut across) = (Vector::splat(simd, 0.0), Vector::splat(simd, 0.0));
        let mut along = group.load(simd, |block| &block.speed);
        for i in 0..group.modes() {
            let r = group.row(simd, i, |row| &row.r);
            u_r = r.mul_add(Vector::splat(simd, q[i]), u_r);
            let v = Vector::splat(simd, v[i]);
            along = group.row(simd, i, |row| &row.s).mul_add(v, along);
            across = group.row(simd, i, |row| &row.t).mul_add(v, across);
        }
        [u_r, along, across]
    }

    /// Radial displacement and all components of the slip velocity.
    #[inline(always)]
    fn whole<S: Simd, const K: usize>(self, simd: S, group: &Group<'_, K>) -> [Vector<S, K>; 4] {
        let (q, v) = (&self.q[..group.modes()], &self.v[..group.modes()]);
        let zero = Vector::splat(simd, 0.0);
        let (mut u_r, mut across, mut outward) = (zero, zero, zero);
        let mut along = group.load(simd, |block| &block.speed);
        for i in 0..group.modes() {
            let r = group.row(simd, i, |row| &row.r);
            u_r = r.mul_add(Vector::splat(simd, q[i]), u_r);
            let v = Vector::splat(simd, v[i]);
            along = group.row(simd, i, |row| &row.s).mul_add(v, along);
            across = group.row(simd, i, |row| &row.t).mul_add(v, across);
            outward = r.mul_add(v, outward);
        }
        [u_r, along, across, outward]
    }
}

/// Adds a radial force to the sums.
#[inline(always)]
fn push_radial<S: Simd, const K: usize>(
    simd: S,
    group: &Group<'_, K>,
    [outward]: [Vector<S, K>; 1],
    sums: &mut [Eight],
) {
    let sums = &mut sums[..group.modes()];
    #[expect(clippy::needless_range_loop, reason = "the rows have as many")]
    for i in 0..group.modes() {
        let mut sum = sums[i].part(simd, 0);
        let r = group.row(simd, i, |row| &row.r);
        for k in 0..K {
            sum = r.one(k).mul_add(outward.one(k), sum);
        }
        sum.store(&mut sums[i].0, 0);
    }
}

/// Adds a force in any direction to the sums.
#[inline(always)]
fn push_whole<S: Simd, const K: usize>(
    simd: S,
    group: &Group<'_, K>,
    [along, across, outward]: [Vector<S, K>; 3],
    sums: &mut [Eight],
) {
    let sums = &mut sums[..group.modes()];
    #[expect(clippy::needless_range_loop, reason = "the rows have as many")]
    for i in 0..group.modes() {
        let mut sum = sums[i].part(simd, 0);
        let s = group.row(simd, i, |row| &row.s);
        let t = group.row(simd, i, |row| &row.t);
        let r = group.row(simd, i, |row| &row.r);
        for k in 0..K {
            sum = s.one(k).mul_add(along.one(k), sum);
            sum = t.one(k).mul_add(across.one(k), sum);
            sum = r.one(k).mul_add(outward.one(k), sum);
        }
        sum.store(&mut sums[i].0, 0);
    }
}

/// The gap function `p_n + k_c u_r`, Pa.
#[inline(always)]
fn gap<S: Simd, const K: usize>(simd: S, group: &Group<'_, K>, u_r: Vector<S, K>) -> Vector<S, K> {
    let stiffness = group.load(simd, |block| &block.stiffness);
    stiffness.mul_add(u_r, group.load(simd, |block| &block.pre_stress))
}

/// The stiffness `A k` of closed nodes, N/m.
#[inline(always)]
fn pressing<S: Simd, const K: usize>(
    simd: S,
    group: &Group<'_, K>,
    gap: Vector<S, K>,
) -> Vector<S, K> {
    (group.load(simd, |block| &block.stiffness) * group.load(simd, |block| &block.area))
        .where_positive(gap)
}

/// Stores numbers of the nodes of a group.
#[inline(always)]
fn keep<S: Simd, const K: usize, const N: usize>(
    record: &mut [[f64; LANES]],
    first: usize,
    numbers: [Vector<S, K>; N],
) {
    for k in 0..K {
        let place = LanePosition::of::<S>(first + k);
        let kept = &mut record[place.block * KEPT..][..KEPT];
        for (kept, number) in kept.iter_mut().zip(numbers) {
            number.one(k).store(kept, place.part);
        }
    }
}

/// A speed from its square, with a tiny lower bound.
#[inline(always)]
fn root<S: Simd, const K: usize>(square: Vector<S, K>) -> Vector<S, K> {
    square.at_least(1e-280).sqrt()
}

/// Defines a setting: name and parameters, motion, projection, and force on the nodes.
macro_rules! setting {
    (
        $name:ident($($field:ident: $type:ty),*),
        $motion:ident -> $m:literal, $push:ident -> $f:literal,
        |$simd:ident, $group:ident, [$($moved:ident),* $(,)?]| $force:block
    ) => {
        pub(super) struct $name<'a>(pub State<'a>, $(pub $type),*);

        impl Setting<$m, $f> for $name<'_> {
            #[inline(always)]
            fn motion<S: Simd, const K: usize>(
                &self,
                simd: S,
                group: &Group<'_, K>,
            ) -> [Vector<S, K>; $m] {
                self.0.$motion(simd, group)
            }

            #[inline(always)]
            fn resistance<S: Simd, const K: usize>(
                &mut self,
                $simd: S,
                $group: &Group<'_, K>,
                [$($moved),*]: [Vector<S, K>; $m],
            ) -> [Vector<S, K>; $f] {
                let $name(_, $($field),*) = self;
                $force
            }

            #[inline(always)]
            fn push<S: Simd, const K: usize>(
                simd: S,
                group: &Group<'_, K>,
                resistance: [Vector<S, K>; $f],
                sums: &mut [Eight],
            ) {
                $push(simd, group, resistance, sums);
            }
        }
    };
}

setting!(Spring(), radial -> 1, push_radial -> 1, |simd, group, [u_r]| {
    [gap(simd, group, u_r).at_least(0.0) * group.load(simd, |block| &block.area)]
});

setting!(BondedSpring(), radial -> 1, push_radial -> 1, |simd, group, [u_r]| {
    [gap(simd, group, u_r) * group.load(simd, |block| &block.area)]
});

setting!(
    TangentialConstant(law: Constant), tangential -> 3, push_whole -> 3,
    |simd, group, [u_r, along, across]| {
        let stress = gap(simd, group, u_r).at_least(0.0);
        let normal = stress * group.load(simd, |block| &block.area);
        let speed = root(across.mul_add(across, along * along));
        let drag = normal * law.ratio_vector(speed);
        [drag * along, drag * across, normal]
    }
);

setting!(
    WholeConstant(law: Constant), whole -> 4, push_whole -> 3,
    |simd, group, [u_r, along, across, outward]| {
        let stress = gap(simd, group, u_r).at_least(0.0);
        let normal = stress * group.load(simd, |block| &block.area);
        let speed = root(outward.mul_add(outward, across.mul_add(across, along * along)));
        let drag = normal * law.ratio_vector(speed);
        [drag * along, drag * across, drag.mul_add(outward, normal)]
    }
);

setting!(
    TangentialStribeck(law: Stribeck), tangential -> 3, push_whole -> 3,
    |simd, group, [u_r, along, across]| {
        let stress = gap(simd, group, u_r).at_least(0.0);
        let normal = stress * group.load(simd, |block| &block.area);
        let speed = root(across.mul_add(across, along * along));
        let drag = normal * law.ratio_vector(speed);
        [drag * along, drag * across, normal]
    }
);

setting!(
    WholeStribeck(law: Stribeck), whole -> 4, push_whole -> 3,
    |simd, group, [u_r, along, across, outward]| {
        let stress = gap(simd, group, u_r).at_least(0.0);
        let normal = stress * group.load(simd, |block| &block.area);
        let speed = root(outward.mul_add(outward, across.mul_add(across, along * along)));
        let drag = normal * law.ratio_vector(speed);
        [drag * along, drag * across, drag.mul_add(outward, normal)]
    }
);

setting!(
    BondedStribeck(law: Stribeck), whole -> 4, push_whole -> 3,
    |simd, group, [u_r, along, across, outward]| {
        let normal = gap(simd, group, u_r) * group.load(simd, |block| &block.area);
        let speed = root(outward.mul_add(outward, across.mul_add(across, along * along)));
        let drag = normal * law.ratio_vector(speed);
        [drag * along, drag * across, drag.mul_add(outward, normal)]
    }
);

setting!(
    RecordedSpring(record: &'a mut [[f64; LANES]]), radial -> 1, push_radial -> 1,
    |simd, group, [u_r]| {
        let gap = gap(simd, group, u_r);
        keep(record, group.first, [pressing(simd, group, gap)]);
        [gap.at_least(0.0) * group.load(simd, |block| &block.area)]
    }
);

setting!(
    RecordedConstant(law: Constant, record: &'a mut [[f64; LANES]]),
    tangential -> 3, push_whole -> 3,
    |simd, group, [u_r, along, across]| {
        let gap = gap(simd, group, u_r);
        let normal = gap.at_least(0.0) * group.load(simd, |block| &block.area);
        let speed = root(across.mul_add(across, along * along));
        let (ratio, slope) = law.ratio_and_slope_vector(speed);
        let (drag, inverse) = (normal * ratio, speed.broadcast(1.0) / speed);
        let stiffness = pressing(simd, group, gap);
        let (h_s, h_t) = (along * inverse, across * inverse);
        keep(record, group.first, [stiffness, ratio * speed, drag, normal * slope, h_s, h_t]);
        [drag * along, drag * across, normal]
    }
);

setting!(
    RecordedTangential(law: Stribeck, record: &'a mut [[f64; LANES]]),
    tangential -> 3, push_whole -> 3,
    |simd, group, [u_r, along, across]| {
        let gap = gap(simd, group, u_r);
        let normal = gap.at_least(0.0) * group.load(simd, |block| &block.area);
        let speed = root(across.mul_add(across, along * along));
        let (ratio, slope) = law.ratio_and_slope_vector(speed);
        let (drag, inverse) = (normal * ratio, speed.broadcast(1.0) / speed);
        let stiffness = pressing(simd, group, gap);
        let (h_s, h_t) = (along * inverse, across * inverse);
        keep(record, group.first, [stiffness, ratio * speed, drag, normal * slope, h_s, h_t]);
        [drag * along, drag * across, normal]
    }
);

setting!(
    RecordedWhole(law: Stribeck, record: &'a mut [[f64; LANES]]),
    whole -> 4, push_whole -> 3,
    |simd, group, [u_r, along, across, outward]| {
        let gap = gap(simd, group, u_r);
        let normal = gap.at_least(0.0) * group.load(simd, |block| &block.area);
        let speed = root(outward.mul_add(outward, across.mul_add(across, along * along)));
        let (ratio, slope) = law.ratio_and_slope_vector(speed);
        let (drag, inverse) = (normal * ratio, speed.broadcast(1.0) / speed);
        let stiffness = pressing(simd, group, gap);
        let (h_s, h_t, h_r) = (along * inverse, across * inverse, outward * inverse);
        let numbers = [stiffness, ratio * speed, drag, normal * slope, h_s, h_t, h_r];
        keep(record, group.first, numbers);
        [drag * along, drag * across, drag.mul_add(outward, normal)]
    }
);

setting!(
    RecordedBonded(law: Stribeck, record: &'a mut [[f64; LANES]]),
    whole -> 4, push_whole -> 3,
    |simd, group, [u_r, along, across, outward]| {
        let area = group.load(simd, |block| &block.area);
        let normal = gap(simd, group, u_r) * area;
        let stiffness = group.load(simd, |block| &block.stiffness) * area;
        let speed = root(outward.mul_add(outward, across.mul_add(across, along * along)));
        let (ratio, slope) = law.ratio_and_slope_vector(speed);
        let (drag, inverse) = (normal * ratio, speed.broadcast(1.0) / speed);
        let (h_s, h_t, h_r) = (along * inverse, across * inverse, outward * inverse);
        let numbers = [stiffness, ratio * speed, drag, normal * slope, h_s, h_t, h_r];
        keep(record, group.first, numbers);
        [drag * along, drag * across, drag.mul_add(outward, normal)]
    }
);
