//! Separation and closure of contact nodes, with one guard function per node.
//!
//! The status contains one bit per node, set for separated nodes, eight nodes per byte. Under a fixed
//! status a closed node has the normal stress `N = p_n + k_c u_r`, also if it is negative, and a separated
//! node has none, so that the force is as smooth as the friction law.

use pulp::{Simd, WithSimd};

use super::nodes::Nodes;
use super::separation::Separation;
use super::simd::{LANES, parts};
use super::{ContactDamping, Joint};
use crate::dynamics::{Switching, System};

impl Switching for Joint {
    fn status_len(&self) -> usize {
        self.nodes.blocks.len()
    }

    /// A node is separated if its gap function is negative. Bonded nodes never separate.
    fn status_of(&self, _t: f64, z: &[f64], status: &mut [u8]) {
        if self.unilateral {
            self.separated_nodes(&z[..self.modes()], status);
        } else {
            status.fill(0);
        }
    }

    /// With the status of the state this force is bit-identical to [`System::force`].
    fn force_in(&self, status: &[u8], _t: f64, z: &[f64], out: &mut [f64]) {
        self.force_by(Separation::Fixed(status), None, z, out);
    }

    /// One guard per node; none for bonded nodes.
    fn guards(&self) -> usize {
        if self.unilateral { self.nodes.count } else { 0 }
    }

    /// Eq. (17): the transitions of all nodes. Each node has its own guard, `s_k` of Eq. (18) while it is
    /// closed and `-s_k` while it is separated, Pa. The product of the printed equation would be zero once
    /// one node is separated.
    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        if self.unilateral {
            self.arch.dispatch(Guards {
                nodes: &self.nodes,
                q: &z[..self.modes()],
                status,
                values,
            });
        }
    }

    /// The node changes its status; the state is continuous.
    fn cross(&self, guard: usize, _t: f64, z: &mut [f64], status: &mut [u8]) {
        debug_assert!(
            self.rests_on_guard(guard, &z[..self.modes()]),
            "node {guard} changes sides away from its guard"
        );
        status[guard / LANES] ^= 1 << (guard % LANES);
    }

    /// The vector field is continuous, except with a dashpot at separation: all other forces of a node are
    /// proportional to `N = p_n + k_c u_r`, which is zero on the guard, and a separated node has no force.
    /// The vector fields before and after the transition are equal there, and since the state is
    /// continuous, Eq. (16) becomes `delta z+ = delta z- + (F_before - F_after) delta t = delta z-`.
    fn is_continuous(&self) -> bool {
        !matches!(self.contact_damping, ContactDamping::KelvinVoigt { .. })
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let (block, lane) = (guard / LANES, guard % LANES);
        let m = self.nodes.modes;
        let sign = if status[block] >> lane & 1 == 1 {
            -1.0
        } else {
            1.0
        };
        let slope = sign * self.nodes.blocks[block].stiffness.0[lane];
        let rows = &self.nodes.rows[block * m..][..m];
        gradient.fill(0.0);
        for (gradient, row) in gradient.iter_mut().zip(rows) {
            *gradient = slope * row.r.0[lane];
        }
        0.0
    }
}

impl Joint {
    /// Whether the spring stress of a node at modal coordinates `q` is negligible relative to the terms of
    /// which it is the difference, so that the node can change its status.
    fn rests_on_guard(&self, node: usize, q: &[f64]) -> bool {
        let (block, lane) = (node / LANES, node % LANES);
        let m = self.nodes.modes;
        let rows = &self.nodes.rows[block * m..][..m];
        let block = &self.nodes.blocks[block];
        let (pre_stress, stiffness) = (block.pre_stress.0[lane], block.stiffness.0[lane]);
        let terms = rows.iter().zip(q).map(|(row, q)| row.r.0[lane] * q);
        let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), u| (sum + u, size + u.abs()));
        (pre_stress + stiffness * sum).abs() <= 1e-6 * (pre_stress + stiffness * size)
    }
}

/// The kernel for the gap functions of all nodes: the guards.
struct Guards<'a> {
    nodes: &'a Nodes,
    q: &'a [f64],
    status: &'a [u8],
    /// Output: one guard per node, Pa.
    values: &'a mut [f64],
}

impl WithSimd for Guards<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let guards = self.values.chunks_mut(LANES).zip(self.status);
        for ((block, rows), (values, bits)) in self.nodes.iter().zip(guards) {
            let mut eight = [0.0; LANES];
            for part in 0..parts::<S>() {
                let gap = block.gap(simd, rows, part, self.q);
                gap.negated_where_set(*bits, part).store(&mut eight, part);
            }
            values.copy_from_slice(&eight[..values.len()]);
        }
    }
}
