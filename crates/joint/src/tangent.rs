//! The derivative of the joint's force from the record of the hot loop, for tangent vectors.
//!
//! With `N` the normal force of a node, `A k` and `c` its derivatives with respect to displacement and velocity, `C` the
//! coefficient of friction along the axes of the sliding frame and `s` the state of friction, the force changes by
//!
//! ```text
//! dF = -(A k du_r + c du_r/dt) (C + e_r) - N (dC/dV dV + dC/ds ds)
//! ```

use pulp::{Simd, WithSimd};

use super::Joint;
use super::contact_force::Group;
use super::dual::Dual;
use super::nodes::Nodes;
use super::normal::Separation;
use super::simd::{Eight, LANES, LanePosition, Vector, parts};
use squeakscope_dynamics::{Differentiable, System, vectorised};

/// Number of derivatives per node for a friction law with this number of inputs: of the negative force (N) along the three
/// axes of the sliding frame with respect to radial displacement, approach velocity and the inputs of the law, and of the
/// rates of its state with respect to its inputs.
pub(crate) const fn slopes_len(inputs: usize) -> usize {
    3 * (2 + inputs) + if inputs == 6 { 18 } else { 0 }
}

/// Records the derivatives of the nodes of adjacent vectors.
#[inline(always)]
pub(super) fn keep_slopes<S: Simd, const K: usize, const N: usize>(
    record: &mut [[f64; LANES]],
    first: usize,
    normal: &Dual<S, K, 2>,
    [coefficient, rate]: &[[Dual<S, K, N>; 3]; 2],
) {
    let len = const { slopes_len(N) };
    // The loop over the vectors is the inner one: it is small enough to be unrolled.
    let mut store = |number: usize, slope: Vector<S, K>| {
        for k in 0..K {
            let place = LanePosition::of::<S>(first + k);
            let record = &mut record[place.block * len..][..len];
            slope.one(k).store(&mut record[number], place.part);
        }
    };
    for (i, coefficient) in coefficient.iter().enumerate() {
        let row = i * (2 + N);
        let mut direction = coefficient.value;
        if i == 2 {
            direction = direction + direction.broadcast(1.0);
        }
        store(row, normal.slopes[0] * direction);
        store(row + 1, normal.slopes[1] * direction);
        for (j, slope) in coefficient.slopes.iter().enumerate() {
            store(row + 2 + j, normal.value * *slope);
        }
    }
    if N == 6 {
        let slopes = rate.iter().flat_map(|rate| rate.slopes);
        for (number, slope) in slopes.enumerate() {
            store(3 * (2 + N) + number, slope);
        }
    }
}

impl Joint {
    /// The product of the derivative with tangent vectors; without any, with those of the identity.
    fn tangents(&self, record: &mut [f64], vectors: Option<&[f64]>, width: usize, out: &mut [f64]) {
        let (kept, scratch) = record.split_at_mut(self.kept_len());
        // Whole vectors lie in a cache line.
        let start = scratch.as_ptr().align_offset(align_of::<Eight>());
        let sums = scratch[start..].as_chunks_mut().0;
        macro_rules! product {
            ($inputs:literal) => {
                self.arch.dispatch(TangentProduct::<$inputs> {
                    nodes: &self.nodes,
                    states: self.law.states(),
                    damped: !self.contact_damping.is_none(),
                    kept: kept.as_chunks().0,
                    vectors,
                    width,
                    sums: &mut sums[..MAX_VECTORS * self.modes()],
                    out,
                })
            };
        }
        match self.friction_inputs() {
            0 => product!(0),
            3 => product!(3),
            _ => product!(6),
        }
    }

    /// Length of the derivatives of the nodes in a record.
    fn kept_len(&self) -> usize {
        self.nodes.blocks.len() * LANES * slopes_len(self.friction_inputs())
    }

    /// Derivative of the negative force of a node along an axis of its sliding frame with respect to an input, in the order
    /// of [`slopes_len`].
    pub(crate) fn node_slope(&self, record: &[f64], node: usize, axis: usize, input: usize) -> f64 {
        let inputs = self.friction_inputs();
        let number = node / LANES * slopes_len(inputs) + axis * (2 + inputs) + input;
        record[number * LANES + node % LANES]
    }
}

impl Differentiable for Joint {
    /// Length of the node derivatives and the scratch of a product.
    fn record_len(&self) -> usize {
        let m = self.modes();
        self.kept_len() + LANES + m * MAX_VECTORS * LANES + 2 * m * m
    }

    /// The force is bit-identical to that without a record.
    ///
    /// Without a status, a node with a gap of exactly zero is recorded as separated.
    fn force_recorded(
        &self,
        status: Option<&[u8]>,
        _t: f64,
        z: &[f64],
        out: &mut [f64],
        record: &mut [f64],
    ) {
        let contact = status.map_or(self.lift_off(), Separation::Fixed);
        let kept = record[..self.kept_len()].as_chunks_mut().0;
        self.force_by(contact, Some(kept), z, out);
    }

    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let m = self.modes();
        if 2 * width <= 3 * m || width < LANES || self.friction_states() > 0 {
            return self.tangents(record, Some(vectors), width, out);
        }
        // The derivative with respect to all coordinates and velocities costs less.
        let (record, matrix) = record.split_at_mut(self.record_len() - 2 * m * m);
        self.tangents(record, None, 2 * m, matrix);
        vectorised(
            #[inline(always)]
            || {
                for first in (0..width).step_by(LANES) {
                    // The last columns overlap with those before.
                    let first = first.min(width - LANES);
                    for (row, out) in matrix.chunks_exact(2 * m).zip(out.chunks_exact_mut(width)) {
                        let mut sums = [0.0; LANES];
                        for (factor, vector) in row.iter().zip(vectors[first..].chunks(width)) {
                            for (sum, x) in sums.iter_mut().zip(&vector[..LANES]) {
                                *sum += factor * x;
                            }
                        }
                        out[first..][..LANES].copy_from_slice(&sums);
                    }
                }
            },
        );
    }
}

/// Largest number of tangent vectors in a pass over the nodes.
const MAX_VECTORS: usize = 3;

/// Product of the derivative with tangent vectors. `N` is the number of inputs of the friction law.
struct TangentProduct<'a, const N: usize> {
    nodes: &'a Nodes,
    /// Number of states of the friction law per node.
    states: usize,
    /// Whether the contact is damped.
    damped: bool,
    kept: &'a [[f64; LANES]],
    /// `(2m + states) x width`; `None` for the identity.
    vectors: Option<&'a [f64]>,
    width: usize,
    /// Scratch, `m` times [`MAX_VECTORS`].
    sums: &'a mut [[f64; LANES]],
    /// Output: the change of the force and of the rates, `(m + states) x width`.
    out: &'a mut [f64],
}

/// Changes of radial displacement, approach velocity and slip velocity at the nodes in `L` tangent vectors.
type Motions<S, const K: usize, const L: usize> =
    ([Vector<S, K>; L], [Vector<S, K>; L], [[Vector<S, K>; 3]; L]);

impl<const N: usize> WithSimd for TangentProduct<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut first = 0;
        while first < self.width {
            let left = self.width - first;
            first += if left == 1 {
                self.pass::<S, 1>(simd, first)
            } else if left == 2 || self.vectors.is_none() {
                // Without sums over the modes fewer vectors, which fit in registers, are faster.
                self.pass::<S, 2>(simd, first)
            } else {
                self.pass::<S, MAX_VECTORS>(simd, first)
            };
        }
    }
}

impl<const N: usize> TangentProduct<'_, N> {
    /// The loop over all nodes for `L` adjacent tangent vectors, the number of which it returns: each row that is read
    /// serves all of them, and each number of a tangent vector all nodes of a group.
    #[inline(always)]
    fn pass<S: Simd, const L: usize>(&mut self, simd: S, first: usize) -> usize {
        self.sums.fill([0.0; LANES]);
        let vectors = self.nodes.blocks.len() * parts::<S>();
        let mut done = 0;
        // As many vectors of nodes as have sums in registers: two for AVX-512, one for others.
        if const { S::F64_LANES == LANES } {
            while done + 2 <= vectors {
                self.group::<S, 2, L>(simd, done, first);
                done += 2;
            }
        }
        while done < vectors {
            self.group::<S, 1, L>(simd, done, first);
            done += 1;
        }
        let sums = &self.sums.as_chunks::<L>().0[..self.nodes.modes];
        for (out, sums) in self.out.chunks_exact_mut(self.width).zip(sums) {
            for (out, sum) in out[first..].iter_mut().zip(sums) {
                *out = -Vector::load(simd, sum, 0).sum();
            }
        }
        L
    }

    /// Loads a derivative of the nodes of `K` adjacent vectors.
    #[inline(always)]
    fn slope<S: Simd, const K: usize>(
        &self,
        simd: S,
        vector: usize,
        number: usize,
    ) -> Vector<S, K> {
        let len = const { slopes_len(N) };
        Vector::from_parts(
            simd,
            #[inline(always)]
            |k| {
                let place = LanePosition::of::<S>(vector + k);
                let kept = &self.kept[place.block * len..][..len];
                Vector::load(simd, &kept[number], place.part)
            },
        )
    }

    /// Changes at the nodes of a group in adjacent tangent vectors: sums over the modes.
    #[inline(always)]
    fn motions<S: Simd, const K: usize, const L: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
        first: usize,
        vectors: &[f64],
    ) -> Motions<S, K, L> {
        let (m, width) = (self.nodes.modes, self.width);
        let zero = Vector::splat(simd, 0.0);
        let (mut u_r, mut rate, mut slip) = ([zero; L], [zero; L], [[zero; 3]; L]);
        let (dq, dv) = vectors[..2 * m * width].split_at(m * width);
        let of_mode = |numbers: &[f64], i: usize| -> [f64; L] {
            numbers[i * width + first..].as_chunks().0[0]
        };
        for i in 0..m {
            let ([s, t, r], dq) = (group.rows(simd, i), of_mode(dq, i));
            for l in 0..L {
                u_r[l] = r.mul_add(Vector::splat(simd, dq[l]), u_r[l]);
            }
            if N == 0 && !self.damped {
                continue;
            }
            let dv = of_mode(dv, i);
            for l in 0..L {
                let v = Vector::splat(simd, dv[l]);
                slip[l][2] = r.mul_add(v, slip[l][2]);
                if N > 0 {
                    slip[l][0] = s.mul_add(v, slip[l][0]);
                    slip[l][1] = t.mul_add(v, slip[l][1]);
                }
            }
        }
        for l in 0..L {
            rate[l] = slip[l][2];
        }
        if N > 0 {
            for (i, rows) in group.convected(simd).enumerate() {
                let dq = of_mode(dq, i);
                for l in 0..L {
                    let dq = Vector::splat(simd, dq[l]);
                    for (slip, row) in slip[l].iter_mut().zip(rows) {
                        *slip = row.mul_add(dq, *slip);
                    }
                }
            }
        }
        (u_r, rate, slip)
    }

    /// Changes at the nodes of a group in adjacent unit vectors: rows of the modes.
    #[inline(always)]
    fn unit_motions<S: Simd, const K: usize, const L: usize>(
        &self,
        simd: S,
        group: &Group<'_, K>,
        first: usize,
    ) -> Motions<S, K, L> {
        let m = self.nodes.modes;
        let zero = Vector::splat(simd, 0.0);
        let (mut u_r, mut rate, mut slip) = ([zero; L], [zero; L], [[zero; 3]; L]);
        for l in 0..L {
            let component = first + l;
            if component < m {
                u_r[l] = group.rows(simd, component)[2];
                if N > 0
                    && let Some(rows) = group.convected(simd).nth(component)
                {
                    slip[l] = rows;
                }
            } else if component < 2 * m {
                slip[l] = group.rows(simd, component - m);
                rate[l] = slip[l][2];
            }
        }
        (u_r, rate, slip)
    }

    /// Adds the nodes of `K` adjacent vectors.
    #[expect(
        clippy::needless_range_loop,
        reason = "the index is the second one of arrays by tangent vectors"
    )]
    #[inline(always)]
    fn group<S: Simd, const K: usize, const L: usize>(
        &mut self,
        simd: S,
        vector: usize,
        first: usize,
    ) {
        let m = self.nodes.modes;
        let group = Group::<K>::new::<S>(self.nodes, vector);
        let zero = Vector::splat(simd, 0.0);
        let (u_r, rate, slip): Motions<S, K, L> = match self.vectors {
            Some(vectors) => self.motions(simd, &group, first, vectors),
            None => self.unit_motions(simd, &group, first),
        };
        let slips = self.vectors.is_some() || first + L > m || !self.nodes.convected.is_empty();
        let mut forces = [[zero; 3]; L];
        for axis in if N == 0 { 2 } else { 0 }..3 {
            let row = axis * (2 + N);
            let by_u = self.slope(simd, vector, row);
            for l in 0..L {
                forces[l][axis] = by_u * u_r[l];
            }
            if self.damped {
                let by_rate = self.slope::<S, K>(simd, vector, row + 1);
                for l in 0..L {
                    forces[l][axis] = by_rate.mul_add(rate[l], forces[l][axis]);
                }
            }
            if N > 0 && slips {
                for j in 0..3 {
                    let by_slip = self.slope::<S, K>(simd, vector, row + 2 + j);
                    for l in 0..L {
                        forces[l][axis] = by_slip.mul_add(slip[l][j], forces[l][axis]);
                    }
                }
            }
        }
        if N == 6 {
            for (l, force) in forces.iter_mut().enumerate() {
                self.add_states(simd, &group, first + l, slip[l], force);
            }
        }
        let sums = self.sums.as_chunks_mut::<L>().0;
        for (i, sums) in sums[..m].iter_mut().enumerate() {
            let rows = group.rows(simd, i);
            for l in 0..L {
                if N > 0 {
                    Group::project::<S, true>(simd, rows, forces[l], &mut sums[l]);
                } else {
                    Group::project::<S, false>(simd, rows, forces[l], &mut sums[l]);
                }
            }
        }
    }

    /// Adds the effect of the states of friction in a tangent vector to the negative change of the force, and writes the
    /// change of their rates.
    #[inline(always)]
    fn add_states<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        group: &Group<'_, K>,
        vector: usize,
        slip: [Vector<S, K>; 3],
        force: &mut [Vector<S, K>; 3],
    ) {
        let (m, states) = (self.nodes.modes, self.states);
        let zero = Vector::splat(simd, 0.0);
        let mut inputs = [zero; 6];
        inputs[..3].copy_from_slice(&slip);
        for axis in 0..states {
            let of_node = |node: usize| {
                let component = 2 * m + node * states + axis;
                match self.vectors {
                    Some(vectors) => vectors[component * self.width + vector],
                    None => f64::from(u8::from(component == vector)),
                }
            };
            inputs[3 + axis] = group.gather(simd, self.nodes.count, of_node);
        }
        for (axis, force) in force.iter_mut().enumerate() {
            for (j, input) in inputs.into_iter().enumerate().skip(3) {
                let by_state = self.slope::<S, K>(simd, group.first, axis * (2 + N) + 2 + j);
                *force = by_state.mul_add(input, *force);
            }
        }
        for axis in 0..states {
            let mut rate = zero;
            for (j, input) in inputs.into_iter().enumerate() {
                let number = 3 * (2 + N) + axis * N + j;
                rate = self.slope(simd, group.first, number).mul_add(input, rate);
            }
            group.scatter(rate, self.nodes.count, |node, rate| {
                let row = m + node * states + axis;
                self.out[row * self.width + vector] = rate;
            });
        }
    }
}
