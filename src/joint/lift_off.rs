//! Eq. (2) at several nodes at once: which of them press, by their gaps or by a status held.

use pulp::Simd;

use super::lanes::{Place, Vector};

/// How the normal stress follows from the gap function `s = p_n + k_c u_r` (Pa). The choice is met
/// once for some nodes, outside of the loops over the modes: there it costs nothing that can be
/// measured, and the hot loop need not be compiled for each.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LiftOff<'a> {
    /// A node opens where its gap function is negative.
    ByGap,
    /// Nodes never open; the stress may become tension.
    Never,
    /// The open nodes are given, one bit a node, and stay open; the closed ones stay closed, if need
    /// be under tension.
    Held(&'a [u8]),
}

impl LiftOff<'_> {
    /// The normal stress of nodes, Pa; they are those of the vectors from `first` on.
    #[inline(always)]
    pub fn stress<S: Simd, const K: usize>(self, first: usize, gap: Vector<S, K>) -> Vector<S, K> {
        match self {
            Self::ByGap => gap.at_least(0.0),
            Self::Never => gap,
            Self::Held(open) => where_closed(open, first, gap),
        }
    }

    /// What changes with the gap: the stiffness of the nodes that press, zero for the open ones.
    /// A node whose gap is exactly zero counts as open where its gap decides.
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
            Self::Held(open) => where_closed(open, first, stiffness),
        }
    }
}

/// The numbers of the closed nodes, zero for the open ones.
#[inline(always)]
fn where_closed<S: Simd, const K: usize>(
    open: &[u8],
    first: usize,
    numbers: Vector<S, K>,
) -> Vector<S, K> {
    numbers.each_vector(
        #[inline(always)]
        |k, vector| {
            let place = Place::of::<S>(first + k);
            vector.where_clear(open[place.block], place.part)
        },
    )
}
