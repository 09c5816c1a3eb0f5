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

use pulp::{Scalar, Simd, WithSimd};

use super::dual::Dual;
use super::nodes::radial_part;
use super::normal::Separation;
use super::simd::{LANES, Vector, parts};
use super::{ContactDamping, Joint};
use squeakscope_dynamics::Switching;

impl Switching for Joint {
    fn status_len(&self) -> usize {
        self.nodes.blocks.len() * self.guards_per_node()
    }

    /// A node is separated if its gap function is negative. Bonded nodes never separate.
    fn status_of(&self, _t: f64, z: &[f64], status: &mut [u8]) {
        if !self.unilateral {
            status.fill(0);
            return;
        }
        let [q, v, _] = self.parts(z);
        let (separated, pulled) = status.split_at_mut(self.nodes.blocks.len());
        self.each_guard(q, v, |block, gaps, guards| {
            separated[block] = negative_bits(gaps);
            if let Some(pulled) = pulled.get_mut(block) {
                *pulled = negative_bits(guards) & !separated[block];
            }
        });
    }

    /// With the status of the state this force is bit-identical to [`System::force`](squeakscope_dynamics::System::force).
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
        let [q, v, _] = self.parts(z);
        let blocks = self.nodes.blocks.len();
        let (gaps, stresses) = values.split_at_mut(self.nodes.count);
        let is_set = |bits: u8, lane: usize| bits >> lane & 1 == 1;
        let signed = |x: f64, is_negated: bool| if is_negated { -x } else { x };
        self.each_guard(q, v, |block, of_gaps, of_stresses| {
            let separated = status[block];
            let first = block * LANES;
            for (lane, gap) in gaps[first..].iter_mut().zip(of_gaps).enumerate() {
                *gap.0 = signed(*gap.1, is_set(separated, lane));
            }
            if !self.contact_damping.is_none() {
                let pulled = status[blocks + block];
                for (lane, stress) in stresses[first..].iter_mut().zip(of_stresses).enumerate() {
                    *stress.0 = if is_set(separated, lane) {
                        // A separated node has no force whose sign could change.
                        1.0
                    } else {
                        signed(*stress.1, is_set(pulled, lane))
                    };
                }
            }
        });
    }

    /// The node changes its status; the state is continuous.
    fn cross(&self, guard: usize, _t: f64, _z: &mut [f64], status: &mut [u8]) {
        let (node, is_gap) = (guard % self.nodes.count, guard < self.nodes.count);
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
            false => {
                // Linear in both: at any gap and velocity the same.
                let [gap, rate] = [0, 1].map(|input| Dual::<_, 1, 2>::scalar(0.0, input));
                let stiffness = Vector::splat(Scalar::new(), stiffness);
                let gap = gap.times(stiffness);
                let guard = self.contact_damping.guard(gap, stiffness, rate);
                (is_set(pulled), guard.slopes.map(Vector::sum))
            }
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

    /// Gives the gap functions and the guards of the contact force of all nodes to a function, see [`GapsAndGuards`].
    fn each_guard(
        &self,
        q: &[f64],
        v: &[f64],
        of_block: impl FnMut(usize, &[f64; LANES], &[f64; LANES]),
    ) {
        self.arch.dispatch(GapsAndGuards {
            joint: self,
            q,
            v,
            of_block,
        });
    }

    /// Eq. (18): the indicators `s_k = p_n + k_c u_r` (Pa) of all nodes at modal coordinates `q`, written to
    /// `gaps` (one per node). A node separates when its indicator falls through zero. The printed equation
    /// clamps the indicator at zero, which would hide the crossing; the clamp is omitted.
    pub fn gaps(&self, q: &[f64], gaps: &mut [f64]) {
        self.each_guard(q, &[], |block, values, _| {
            let gaps = &mut gaps[block * LANES..];
            let count = gaps.len().min(LANES);
            gaps[..count].copy_from_slice(&values[..count]);
        });
    }

    /// Writes the status at modal coordinates `q`: one bit per node, set for separated nodes, eight nodes
    /// per byte.
    pub fn separated_nodes(&self, q: &[f64], status: &mut [u8]) {
        self.each_guard(q, &[], |block, gaps, _| {
            status[block] = negative_bits(gaps);
        });
    }
}

/// The kernel for the gap functions `s_k` (Pa) and the guards of the contact force ([`ContactDamping::guard`]) of all
/// nodes, which it gives to a function by blocks, with the index of the block.
struct GapsAndGuards<'a, F> {
    joint: &'a Joint,
    q: &'a [f64],
    /// Modal velocities; none for the gap functions alone.
    v: &'a [f64],
    of_block: F,
}

impl<F: FnMut(usize, &[f64; LANES], &[f64; LANES])> WithSimd for GapsAndGuards<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (nodes, damping) = (&self.joint.nodes, self.joint.contact_damping);
        let (mut gaps, mut guards) = ([0.0; LANES], [0.0; LANES]);
        for (index, (block, rows)) in nodes.iter().enumerate() {
            for part in 0..parts::<S>() {
                let gap = block.gap(simd, rows, part, self.q);
                gap.store(&mut gaps, part);
                if !damping.is_none() {
                    let rate = radial_part(simd, rows, part, self.v);
                    let [gap, rate] = [gap, rate].map(Dual::<S, 1, 0>::constant);
                    let stiffness = block.stiffness.part(simd, part);
                    let guard = damping.guard(gap, stiffness, rate);
                    guard.value.store(&mut guards, part);
                }
            }
            (self.of_block)(index, &gaps, &guards);
        }
    }
}

/// One bit per negative number.
fn negative_bits(numbers: &[f64; LANES]) -> u8 {
    let bits = numbers.iter().enumerate();
    bits.fold(0, |bits, (lane, x)| bits | u8::from(*x < 0.0) << lane)
}
