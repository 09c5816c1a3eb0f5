//! Optional terms of the contact force: contact damping and the convective part `Omega x u` of the slip
//! velocity. The hot loop is compiled with and without them. This module contains their contribution to the
//! derivative.
//!
//! With the symbols of [`NodeSlopes`](super::node_slopes::NodeSlopes), the velocity `du_r/dt` changes the normal
//! force by `c` (N s/m), and friction with it; the displacement changes the slip velocity by the rows `W_i`
//! of `Omega x Phi_i`:
//!
//! ```text
//! df_i/dv_j += -sum over nodes of c (mu w_i + Phi_i.e_r) (Phi_j.e_r)
//! df_i/dq_j += -sum over nodes of N g Phi_i . W_j + N (dmu/dV - mu/V) w_i (h . W_j)
//! ```

use pulp::{Simd, WithSimd};

use super::node_slopes::{KEPT, NodeSlopes};
use super::nodes::{Nodes, Rows};
use super::simd::{LANES, Vector, parts};

/// Offset of the viscosities (N s/m) of the nodes in a record, after the other derivatives; eight per block.
#[inline(always)]
pub(crate) fn viscosities(blocks: usize) -> usize {
    blocks * KEPT
}

/// Adds the optional terms to the assembled Jacobian of the force.
pub(crate) struct Addition<'a> {
    pub nodes: &'a Nodes,
    /// Whether friction includes the radial component.
    pub radial: bool,
    pub kept: &'a [[f64; LANES]],
    /// Scratch, `2 m^2`.
    pub sums: &'a mut [[f64; LANES]],
    /// The Jacobian, `m x 2m`, row-major.
    pub matrix: &'a mut [f64],
}

impl WithSimd for Addition<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let m = self.nodes.modes;
        let zero = Vector::splat(simd, 0.0);
        let viscosities = &self.kept[viscosities(self.nodes.blocks.len())..];
        self.sums.fill([0.0; LANES]);
        let (by_q, by_v) = self.sums.split_at_mut(m * m);
        for (block, (_, rows)) in self.nodes.iter().enumerate() {
            for part in 0..parts::<S>() {
                let slopes = NodeSlopes::load(simd, self.kept, block * parts::<S>() + part);
                let change = Change { slopes, rows, part };
                if let Some(viscosity) = viscosities.get(block) {
                    let viscosity = Vector::load(simd, viscosity, part);
                    for (j, row) in rows.iter().enumerate() {
                        let normal = viscosity * row.r.part(simd, part);
                        change.add(simd, normal, [zero; 3], &mut by_v[j * m..][..m]);
                    }
                }
                for (j, row) in convected(self.nodes, block).iter().enumerate() {
                    let [s, t, r] = row.part(simd, part);
                    let r = if self.radial { r } else { zero };
                    change.add(simd, zero, [s, t, r], &mut by_q[j * m..][..m]);
                }
            }
        }
        for i in 0..m {
            for j in 0..m {
                self.matrix[i * 2 * m + j] -= Vector::load(simd, &by_q[j * m + i], 0).sum();
                self.matrix[i * 2 * m + m + j] -= Vector::load(simd, &by_v[j * m + i], 0).sum();
            }
        }
    }
}

/// Derivative of the generalised forces of some nodes.
struct Change<'a, S: Simd> {
    slopes: NodeSlopes<S>,
    rows: &'a [Rows],
    part: usize,
}

impl<S: Simd> Change<'_, S> {
    /// Adds the negative change of the modal forces for a change of the normal force (N) and of the slip
    /// velocity (m/s) to the sums, one per mode.
    #[inline(always)]
    fn add(
        &self,
        simd: S,
        normal: Vector<S>,
        [s, t, r]: [Vector<S>; 3],
        sums: &mut [[f64; LANES]],
    ) {
        let slopes = &self.slopes;
        let [h_s, h_t, h_r] = slopes.direction;
        let turned = h_r.mul_add(r, h_t.mul_add(t, h_s * s));
        let pull = slopes.coefficient.mul_add(normal, slopes.bend * turned);
        let along = slopes.drag.mul_add(s, pull * h_s);
        let across = slopes.drag.mul_add(t, pull * h_t);
        let outward = slopes.drag.mul_add(r, pull.mul_add(h_r, normal));
        for (sum, row) in sums.iter_mut().zip(self.rows) {
            let [s, t, r] = row.part(simd, self.part);
            let mut total = Vector::load(simd, sum, 0);
            total = s.mul_add(along, total);
            total = t.mul_add(across, total);
            r.mul_add(outward, total).store(sum, 0);
        }
    }
}

/// The rows of `Omega x Phi_i` of a block; empty if the slip velocity excludes this term.
#[inline(always)]
pub(crate) fn convected(nodes: &Nodes, block: usize) -> &[Rows] {
    match nodes.convected.is_empty() {
        true => &[],
        false => &nodes.convected[block * nodes.modes..][..nodes.modes],
    }
}
