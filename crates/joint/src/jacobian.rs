//! The Jacobian of the force from the record of the hot loop: as a matrix-free product, or assembled and
//! multiplied.
//!
//! With the symbols of [`NodeSlopes`], the derivatives of the force on mode `i` are
//!
//! ```text
//! df_i/dq_j = -sum over nodes of A k (mu w_i + Phi_i.e_r) (Phi_j.e_r),      w_i = Phi_i . h
//! df_i/dv_j = -sum over nodes of N g Phi_i . Phi_j + N (dmu/dV - mu/V) w_i w_j
//! ```
//!
//! The second matrix is symmetric. `Phi` contains the components in which friction acts. Optional terms: with contact
//! damping the velocity `du_r/dt` changes the normal force by `c` (N s/m), and friction with it; with the convective part
//! of the slip velocity, the displacement changes that by the rows `W_i` of `Omega x Phi_i`:
//!
//! ```text
//! df_i/dv_j += -sum over nodes of c (mu w_i + Phi_i.e_r) (Phi_j.e_r)
//! df_i/dq_j += -sum over nodes of N g Phi_i . W_j + N (dmu/dV - mu/V) w_i (h . W_j)
//! ```

use pulp::{Simd, WithSimd};

use super::contact_force::{Group, PAPER_MODES};
use super::node_slopes::{KEPT, NodeSlopes};
use super::nodes::{Nodes, Rows, View};
use super::simd::{LANES, Vector, parts};
use super::{Joint, MAX_MODES};
use squeakscope_dynamics::{Differentiable, System};

impl Joint {
    /// Writes the Jacobian `dF/dz` of the state `[q | dq/dt | s]` (without the work of the audit) at `z` to
    /// `jacobian`, row-major, with [`System::tangent_dim`] rows and columns: `2m` for a friction law without states.
    /// `record` is scratch of length [`Differentiable::record_len`].
    ///
    /// The derivative is discontinuous at the separation of a node; at a gap of exactly zero the value of the
    /// separated side is used.
    pub fn jacobian(&self, z: &[f64], record: &mut [f64], jacobian: &mut [f64]) {
        let m = self.modes();
        let dim = self.tangent_dim();
        // The force is not needed; the Jacobian overwrites it.
        self.force_recorded(None, 0.0, z, &mut jacobian[..self.dim() - m], record);
        let (upper, lower) = jacobian[..dim * dim].split_at_mut(m * dim);
        match self.friction_states() {
            0 => lower.copy_from_slice(self.assembled(record)),
            _ => {
                let mut identity = vec![0.0; dim * dim];
                identity.iter_mut().step_by(dim + 1).for_each(|x| *x = 1.0);
                self.product(None, record, &identity, dim, lower);
            }
        }
        upper.fill(0.0);
        for i in 0..m {
            upper[i * dim + m + i] = 1.0;
            let omega = self.omega()[i];
            lower[i * dim + i] -= omega * omega;
            if let Some(zeta) = self.damping().get(i) {
                lower[i * dim + m + i] -= 2.0 * zeta * omega;
            }
        }
    }
}

/// Matrix-free product of the derivative with tangent vectors.
/// `AXES`: number of components of the node frame in which friction acts, see [`Law`](super::friction_kernel::Law).
/// `M`: number of modes if it is that of the paper, else [`MAX_MODES`].
pub(crate) struct MatrixFreeProduct<'a, const AXES: usize, const M: usize> {
    pub nodes: &'a Nodes,
    pub kept: &'a [[f64; LANES]],
    /// `2m x width`.
    pub vectors: &'a [f64],
    pub width: usize,
    /// Scratch, at least `m x 3`.
    pub sums: &'a mut [[f64; LANES]],
    /// Output: the change of the force, `m x width`.
    pub out: &'a mut [f64],
}

impl<const AXES: usize, const M: usize> WithSimd for MatrixFreeProduct<'_, AXES, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if const { S::F64_LANES == 1 } {
            return without_simd(MatrixFreeProduct::<AXES, MAX_MODES> {
                nodes: self.nodes,
                kept: self.kept,
                vectors: self.vectors,
                width: self.width,
                sums: self.sums,
                out: self.out,
            });
        }
        self.evaluate(simd);
    }
}

/// The product on a machine without SIMD.
#[inline(never)]
fn without_simd<const AXES: usize>(product: MatrixFreeProduct<'_, AXES, MAX_MODES>) {
    product.evaluate(pulp::Scalar::new());
}

impl<const AXES: usize, const M: usize> MatrixFreeProduct<'_, AXES, M> {
    /// Number of modes.
    #[inline(always)]
    fn modes(&self) -> usize {
        if M < MAX_MODES { M } else { self.nodes.modes }
    }

    #[inline(always)]
    fn evaluate<S: Simd>(mut self, simd: S) {
        let mut first = 0;
        while first < self.width {
            first += match self.width - first {
                1 => self.pass::<S, 1>(simd, first),
                2 => self.pass::<S, 2>(simd, first),
                _ => self.pass::<S, 3>(simd, first),
            };
        }
    }

    /// The loop over all nodes for `L` adjacent tangent vectors, the number of which it returns: each row that is read
    /// serves all of them, and each number of a tangent vector all nodes of a group.
    #[inline(always)]
    fn pass<S: Simd, const L: usize>(&mut self, simd: S, first: usize) -> usize {
        self.sums.fill([0.0; LANES]);
        let vectors = self.nodes.blocks.len() * parts::<S>();
        let mut done = 0;
        // As many vectors of nodes as have sums in registers: with friction two for AVX-512, one for others.
        if const { AXES == 0 } {
            while done + 4 <= vectors {
                self.group::<S, 4, L>(simd, done, first);
                done += 4;
            }
        }
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
        let sums = &self.sums.as_chunks::<L>().0[..self.modes()];
        for (out, sums) in self.out.chunks_exact_mut(self.width).zip(sums) {
            for (out, sum) in out[first..].iter_mut().zip(sums) {
                *out = -total(simd, sum);
            }
        }
        L
    }

    /// Adds the nodes of `K` adjacent vectors.
    #[inline(always)]
    fn group<S: Simd, const K: usize, const L: usize>(
        &mut self,
        simd: S,
        vector: usize,
        first: usize,
    ) {
        let (m, width) = (self.modes(), self.width);
        let nodes = View {
            modes: m,
            ..self.nodes.view()
        };
        let group = Group::<K>::new::<S>(nodes, vector);
        let (dq, dv) = self.vectors[..2 * m * width].split_at(m * width);
        // Changes of displacement and slip velocity at the nodes.
        let zero = Vector::splat(simd, 0.0);
        let (mut u_r, mut slip) = ([zero; L], [[zero; 3]; L]);
        let tangents = dq.chunks_exact(width).zip(dv.chunks_exact(width));
        for (i, (dq, dv)) in tangents.enumerate() {
            let (dq, dv) = (&dq[first..][..L], &dv[first..][..L]);
            let r = group.row(simd, i, |row| &row.r);
            for l in 0..L {
                u_r[l] = r.mul_add(Vector::splat(simd, dq[l]), u_r[l]);
            }
            if AXES > 0 {
                let s = group.row(simd, i, |row| &row.s);
                let t = group.row(simd, i, |row| &row.t);
                for l in 0..L {
                    let v = Vector::splat(simd, dv[l]);
                    slip[l][0] = s.mul_add(v, slip[l][0]);
                    slip[l][1] = t.mul_add(v, slip[l][1]);
                    if AXES == 3 {
                        slip[l][2] = r.mul_add(v, slip[l][2]);
                    }
                }
            }
        }
        let slopes = match AXES {
            0 => NodeSlopes::load_frictionless(simd, self.kept, vector),
            _ => NodeSlopes::load(simd, self.kept, vector),
        };
        let mut forces = [[zero; 3]; L];
        for l in 0..L {
            forces[l] = slopes.change::<AXES>(slopes.stiffness * u_r[l], slip[l]);
        }
        let sums = self.sums.as_chunks_mut::<L>().0;
        for (i, sums) in sums[..m].iter_mut().enumerate() {
            let r = group.row(simd, i, |row| &row.r);
            let s = group.row(simd, i, |row| &row.s);
            let t = group.row(simd, i, |row| &row.t);
            for (sum, [along, across, outward]) in sums.iter_mut().zip(&forces) {
                let mut total = Vector::load(simd, sum, 0);
                for k in 0..K {
                    if AXES > 0 {
                        total = s.one(k).mul_add(along.one(k), total);
                        total = t.one(k).mul_add(across.one(k), total);
                    }
                    total = r.one(k).mul_add(outward.one(k), total);
                }
                total.store(sum, 0);
            }
        }
    }
}

impl<S: Simd, const K: usize> NodeSlopes<S, K> {
    /// Negative change of the force on nodes for changes of radial displacement and slip velocity.
    #[inline(always)]
    fn change<const AXES: usize>(
        &self,
        normal: Vector<S, K>,
        [along, across, outward]: [Vector<S, K>; 3],
    ) -> [Vector<S, K>; 3] {
        let [h_s, h_t, h_r] = self.direction;
        if AXES == 0 {
            return [normal; 3];
        }
        let mut turned = h_t.mul_add(across, h_s * along);
        if AXES == 3 {
            turned = h_r.mul_add(outward, turned);
        }
        let pull = self.coefficient.mul_add(normal, self.bend * turned);
        let radial = match AXES {
            3 => self.drag.mul_add(outward, pull.mul_add(h_r, normal)),
            _ => normal,
        };
        [
            self.drag.mul_add(along, pull * h_s),
            self.drag.mul_add(across, pull * h_t),
            radial,
        ]
    }
}

/// Assembly of the Jacobian of the force, column by column: the change of all modal forces with one modal coordinate or
/// velocity.
pub(crate) struct Assembly<'a> {
    pub nodes: &'a Nodes,
    /// Whether there is friction, and whether it includes the radial component.
    pub friction: bool,
    pub radial: bool,
    pub kept: &'a [[f64; LANES]],
    /// Scratch, `2 m^2`.
    pub sums: &'a mut [[f64; LANES]],
    /// Output: the Jacobian, `m x 2m`, row-major.
    pub matrix: &'a mut [f64],
}

impl WithSimd for Assembly<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let m = self.nodes.modes;
        let zero = Vector::splat(simd, 0.0);
        let viscosities = &self.kept[self.nodes.blocks.len() * KEPT..];
        // Without contact damping the derivative with respect to `v` is symmetric.
        let is_symmetric = viscosities.is_empty();
        let sums = &mut self.sums[..2 * m * m];
        sums.fill([0.0; LANES]);
        let (by_q, by_v) = sums.split_at_mut(m * m);
        for (block, (_, rows)) in self.nodes.iter().enumerate() {
            let convected = self.nodes.convected_rows(block);
            for part in 0..parts::<S>() {
                let unit = block * parts::<S>() + part;
                let mut slopes = match self.friction {
                    true => NodeSlopes::load(simd, self.kept, unit),
                    false => NodeSlopes::load_frictionless(simd, self.kept, unit),
                };
                if !self.radial {
                    slopes.direction[2] = zero;
                }
                let viscosity = viscosities.get(block);
                let viscosity = viscosity.map_or(zero, |v| Vector::load(simd, v, part));
                let change = Change { slopes, part };
                let slip = |row: &Rows| {
                    let [s, t, r] = row.part(simd, part);
                    [s, t, if self.radial { r } else { zero }]
                };
                for (j, row) in rows.iter().enumerate() {
                    let r = row.r.part(simd, part);
                    let turned = convected.get(j).map_or([zero; 3], slip);
                    change.add(simd, slopes.stiffness * r, turned, rows, &mut by_q[j * m..]);
                    let first = if is_symmetric { j } else { 0 };
                    let sums = &mut by_v[j * m + first..];
                    change.add(simd, viscosity * r, slip(row), &rows[first..], sums);
                }
            }
        }
        for (i, row) in self.matrix.chunks_exact_mut(2 * m).enumerate() {
            for j in 0..m {
                let of_v = match is_symmetric {
                    true => i.min(j) * m + i.max(j),
                    false => j * m + i,
                };
                row[j] = -total(simd, &by_q[j * m + i]);
                row[m + j] = -total(simd, &by_v[of_v]);
            }
        }
    }
}

#[inline(always)]
fn total<S: Simd>(simd: S, lanes: &[f64; LANES]) -> f64 {
    Vector::load(simd, lanes, 0).sum()
}

/// Derivative of the generalised forces of some nodes.
struct Change<S: Simd> {
    slopes: NodeSlopes<S>,
    part: usize,
}

impl<S: Simd> Change<S> {
    /// Adds the negative change of the modal forces for a change of the normal force (N) and of the slip
    /// velocity (m/s) to the sums, one per mode.
    #[inline(always)]
    fn add(
        &self,
        simd: S,
        normal: Vector<S>,
        slip: [Vector<S>; 3],
        rows: &[Rows],
        sums: &mut [[f64; LANES]],
    ) {
        let [along, across, outward] = self.slopes.change::<3>(normal, slip);
        for (sum, row) in sums.iter_mut().zip(rows) {
            let [s, t, r] = row.part(simd, self.part);
            let mut total = Vector::load(simd, sum, 0);
            total = s.mul_add(along, total);
            total = t.mul_add(across, total);
            r.mul_add(outward, total).store(sum, 0);
        }
    }
}

/// Product of an `m x 2m` matrix with `width` adjacent vectors.
pub(crate) struct MatrixProduct<'a> {
    pub modes: usize,
    pub matrix: &'a [f64],
    /// `2m x width`.
    pub vectors: &'a [f64],
    pub width: usize,
    /// Output: the product, `m x width`.
    pub out: &'a mut [f64],
}

impl WithSimd for MatrixProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let zero = Vector::splat(simd, 0.0);
        for first in (0..self.width).step_by(S::F64_LANES) {
            match self.modes {
                PAPER_MODES => self.panel(simd, first, &mut [zero; PAPER_MODES]),
                m => self.panel(simd, first, &mut [zero; MAX_MODES][..m]),
            }
        }
    }
}

impl MatrixProduct<'_> {
    /// Product with as many vectors as fit in one SIMD vector, from index `first`.
    #[inline(always)]
    fn panel<S: Simd>(&mut self, simd: S, first: usize, sums: &mut [Vector<S>]) {
        let (m, width) = (sums.len(), self.width);
        let count = S::F64_LANES.min(width - first);
        let matrix = &self.matrix[..2 * m * m];
        for component in 0..2 * m {
            let numbers = &self.vectors[component * width + first..][..count];
            let vector = Vector::load_some(simd, numbers);
            for (i, sum) in sums.iter_mut().enumerate() {
                let factor = Vector::splat(simd, matrix[i * 2 * m + component]);
                *sum = factor.mul_add(vector, *sum);
            }
        }
        for (i, sum) in sums.iter().enumerate() {
            sum.store_some(&mut self.out[i * width + first..][..count]);
        }
    }
}
