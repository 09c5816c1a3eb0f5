//! Separation and closure of contact nodes, and the end of the force of a damped contact, with their guards.
//!
//! The status contains one bit per node, set for separated nodes, eight nodes per byte. Contact damping adds
//! as many bits, set for closed nodes whose spring and dashpot would together pull; such a node has no force.
//! Under a fixed status a closed node has the normal stress of spring and dashpot, also if it is negative, and
//! any other node has none, so that the force is as smooth as the friction law.
//!
//! A damped node that is pulled off passes three events: its stress falls through zero, where the force ends
//! continuously; its gap function falls through zero, where it separates without force; its gap function rises
//! through zero, where the force of a dashpot jumps to `k_c tau du_r/dt`.

use pulp::{Simd, WithSimd};

use super::nodes::{Block, Nodes, Rows, radial_part};
use super::separation::Separation;
use super::simd::{LANES, Vector, parts};
use super::{ContactDamping, Joint};
use squeakscope_dynamics::{Switching, System};

impl Switching for Joint {
    fn status_len(&self) -> usize {
        self.nodes.blocks.len() * self.guards_per_node()
    }

    /// A node is separated if its gap function is negative. Bonded nodes never separate.
    fn status_of(&self, _t: f64, z: &[f64], status: &mut [u8]) {
        let m = self.modes();
        if !self.unilateral {
            status.fill(0);
            return;
        }
        let (separated, pulled) = status.split_at_mut(self.nodes.blocks.len());
        self.separated_nodes(&z[..m], separated);
        if !self.contact_damping.is_none() {
            self.arch.dispatch(PulledNodes {
                stress: self.damped_stress(z),
                separated,
                pulled,
            });
        }
    }

    /// With the status of the state this force is bit-identical to [`System::force`].
    fn force_in(&self, status: &[u8], _t: f64, z: &[f64], out: &mut [f64]) {
        self.force_by(Separation::Fixed(status), None, z, out);
    }

    /// One guard per node, two with contact damping; none for bonded nodes.
    fn guards(&self) -> usize {
        match self.unilateral {
            true => self.nodes.count * self.guards_per_node(),
            false => 0,
        }
    }

    /// Eq. (17): the transitions of all nodes. Each node has its own guard, `s_k` of Eq. (18) while it is
    /// closed and `-s_k` while it is separated, Pa. The product of the printed equation would be zero once
    /// one node is separated.
    ///
    /// With contact damping as many guards follow: for a closed node the stress of spring and dashpot, with
    /// the opposite sign while it would pull. For a separated node this guard is inactive, a positive number.
    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        if !self.unilateral {
            return;
        }
        let (gaps, stresses) = values.split_at_mut(self.nodes.count);
        self.arch.dispatch(Guards {
            nodes: &self.nodes,
            q: &z[..self.modes()],
            status,
            values: gaps,
        });
        if !self.contact_damping.is_none() {
            let (separated, pulled) = status.split_at(self.nodes.blocks.len());
            self.arch.dispatch(StressGuards {
                stress: self.damped_stress(z),
                separated,
                pulled,
                values: stresses,
            });
        }
    }

    /// The node changes its status; the state is continuous.
    fn cross(&self, guard: usize, _t: f64, z: &mut [f64], status: &mut [u8]) {
        let (node, is_gap) = (guard % self.nodes.count, guard < self.nodes.count);
        debug_assert!(
            !is_gap || self.rests_on_guard(node, &z[..self.modes()]),
            "node {node} changes sides away from its guard"
        );
        let (byte, bit) = (node / LANES, 1 << (node % LANES));
        let (separated, pulled) = status.split_at_mut(self.nodes.blocks.len());
        if is_gap {
            separated[byte] ^= bit;
            if let Some(pulled) = pulled.get_mut(byte) {
                *pulled &= !bit;
            }
        } else {
            pulled[byte] ^= bit;
        }
    }

    /// The vector field is continuous, except with a dashpot at closing: all other forces of a node are
    /// proportional to its normal stress, which is zero on the guard, and on its other side the node has no
    /// force. The vector fields before and after the transition are equal there, and since the state is
    /// continuous, Eq. (16) becomes `delta z+ = delta z- + (F_before - F_after) delta t = delta z-`.
    fn is_continuous(&self) -> bool {
        !matches!(self.contact_damping, ContactDamping::KelvinVoigt { .. })
    }

    /// The state is continuous.
    fn reset_tangents(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        _tangents: (&mut [f64], usize, f64),
    ) {
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let (node, is_gap) = (guard % self.nodes.count, guard < self.nodes.count);
        let (block, lane) = (node / LANES, node % LANES);
        let m = self.nodes.modes;
        let (separated, pulled) = status.split_at(self.nodes.blocks.len());
        let is_set = |bits: &[u8]| bits[block] >> lane & 1 == 1;
        let stiffness = self.nodes.blocks[block].stiffness.0[lane];
        let (is_negated, [by_q, by_v]) = match is_gap {
            true => (is_set(separated), [stiffness, 0.0]),
            false if is_set(separated) => (false, [0.0; 2]),
            false => (is_set(pulled), self.contact_damping.guard_slopes(stiffness)),
        };
        let sign = if is_negated { -1.0 } else { 1.0 };
        gradient.fill(0.0);
        for (i, row) in self.nodes.rows[block * m..][..m].iter().enumerate() {
            gradient[i] = sign * by_q * row.r.0[lane];
            gradient[m + i] = sign * by_v * row.r.0[lane];
        }
        0.0
    }
}

impl Joint {
    /// Number of guards, and of bits of the status, of a node that can separate.
    fn guards_per_node(&self) -> usize {
        1 + usize::from(!self.contact_damping.is_none())
    }

    fn damped_stress<'a>(&'a self, z: &'a [f64]) -> DampedNodes<'a> {
        let (q, v) = z[..2 * self.modes()].split_at(self.modes());
        DampedNodes {
            nodes: &self.nodes,
            damping: self.contact_damping,
            q,
            v,
        }
    }

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

/// Nodes with contact damping at a state.
struct DampedNodes<'a> {
    nodes: &'a Nodes,
    damping: ContactDamping,
    q: &'a [f64],
    v: &'a [f64],
}

impl DampedNodes<'_> {
    /// The guard of the contact force at the nodes of one vector, in the unit of [`ContactDamping::guard`].
    #[inline(always)]
    fn guard<S: Simd>(&self, simd: S, block: &Block, rows: &[Rows], part: usize) -> Vector<S> {
        let gap = block.gap(simd, rows, part, self.q);
        let rate = radial_part(simd, rows, part, self.v);
        let stiffness = block.stiffness.part(simd, part);
        self.damping.guard([gap, stiffness, rate])
    }
}

/// The kernel for the closed nodes that would pull.
struct PulledNodes<'a> {
    stress: DampedNodes<'a>,
    separated: &'a [u8],
    /// Output: one bit per node, eight nodes per byte; a set bit is a closed node that would pull.
    pulled: &'a mut [u8],
}

impl WithSimd for PulledNodes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let bits = self.pulled.iter_mut().zip(self.separated);
        for ((block, rows), (pulled, separated)) in self.stress.nodes.iter().zip(bits) {
            *pulled = 0;
            for part in 0..parts::<S>() {
                let guard = self.stress.guard(simd, block, rows, part);
                *pulled |= guard.negative_bits() << (part * S::F64_LANES);
            }
            *pulled &= !separated;
        }
    }
}

/// The kernel for the guards of the contact force of damped nodes.
struct StressGuards<'a> {
    stress: DampedNodes<'a>,
    separated: &'a [u8],
    pulled: &'a [u8],
    /// Output: one guard per node, in the unit of [`ContactDamping::guard`].
    values: &'a mut [f64],
}

impl WithSimd for StressGuards<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let one = Vector::splat(simd, 1.0);
        let bits = self.separated.iter().zip(self.pulled);
        let guards = self.values.chunks_mut(LANES).zip(bits);
        for ((block, rows), (values, (separated, pulled))) in self.stress.nodes.iter().zip(guards) {
            let mut eight = [0.0; LANES];
            for part in 0..parts::<S>() {
                let guard = self.stress.guard(simd, block, rows, part);
                let guard = guard.negated_where_set(*pulled, part);
                // A separated node has no force whose sign could change.
                let active = guard.where_clear(*separated, part);
                let inactive = one.where_clear(!separated, part);
                (active + inactive).store(&mut eight, part);
            }
            values.copy_from_slice(&eight[..values.len()]);
        }
    }
}
