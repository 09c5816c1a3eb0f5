//! Eq. (2) for several nodes at once: normal stress by gap function or by a given contact status.

use pulp::Simd;

use super::simd::{LanePosition, Vector};

/// Relation between the gap function `s = p_n + k_c u_r` (Pa) and the normal stress. The variant is matched
/// once for a group of nodes, outside the loops over the modes, where its cost is not measurable; the hot
/// loop is not compiled for each variant.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Separation<'a> {
    /// A node separates if its gap function is negative.
    ByGap,
    /// Bonded nodes: they do not separate, and the stress can be tensile.
    Never,
    /// A fixed contact status, one bit per node (set for separated nodes). Closed nodes remain closed, also
    /// under tension. With contact damping, as many bits follow, set for closed nodes without contact force.
    Fixed(&'a [u8]),
}

impl Separation<'_> {
    /// Normal stress of the nodes in the vectors from `first` on, Pa.
    #[inline(always)]
    pub fn stress<S: Simd, const K: usize>(self, first: usize, gap: Vector<S, K>) -> Vector<S, K> {
        match self {
            Self::ByGap => gap.at_least(0.0),
            Self::Never => gap,
            Self::Fixed(status) => where_closed(status, first, gap),
        }
    }

    /// Derivative of the stress with respect to displacement: the stiffness of closed nodes, zero for
    /// separated ones. With the variant `ByGap` a node with a gap of exactly zero is separated.
    #[inline(always)]
    pub fn pressing<S: Simd, const K: usize>(
        self,
        first: usize,
        gap: Vector<S, K>,
        stiffness: Vector<S, K>,
    ) -> Vector<S, K> {
        match self {
            Self::ByGap => stiffness.where_positive(gap),
            Self::Never => stiffness,
            Self::Fixed(status) => where_closed(status, first, stiffness),
        }
    }

    /// The numbers of the nodes that push, zero for the others. A contact pushes and never pulls: a damped
    /// node has no force while `unclamped`, the stress of spring and dashpot (Pa), is negative. Bonded nodes
    /// can pull.
    #[inline(always)]
    pub fn pushing<S: Simd, const K: usize>(
        self,
        first: usize,
        unclamped: Vector<S, K>,
        numbers: Vector<S, K>,
    ) -> Vector<S, K> {
        match self {
            Self::ByGap => numbers.where_positive(unclamped),
            Self::Never => numbers,
            Self::Fixed(status) => where_closed(&status[status.len() / 2..], first, numbers),
        }
    }
}

/// The numbers of nodes with a clear bit (closed nodes), zero for the others.
#[inline(always)]
fn where_closed<S: Simd, const K: usize>(
    status: &[u8],
    first: usize,
    numbers: Vector<S, K>,
) -> Vector<S, K> {
    numbers.each_vector(
        #[inline(always)]
        |k, vector| {
            let place = LanePosition::of::<S>(first + k);
            vector.where_clear(status[place.block], place.part)
        },
    )
}
