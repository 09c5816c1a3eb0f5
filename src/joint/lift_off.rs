//! Eq. (2) at several nodes at once: which of them press, by their gaps or by a status held.

use pulp::Simd;

use super::lanes::Vector;

/// How the normal stress follows from the gap function `s = p_n + k_c u_r` (Pa).
pub(crate) trait LiftOff {
    /// The normal stress of the nodes of a block, Pa.
    fn stress<S: Simd>(&self, block: usize, part: usize, gap: Vector<S>) -> Vector<S>;

    /// What changes with the gap: the stiffness of the nodes that press, zero for the open ones.
    /// A node whose gap is exactly zero counts as open where its gap decides.
    fn pressing<S: Simd>(
        &self,
        block: usize,
        part: usize,
        gap: Vector<S>,
        stiffness: Vector<S>,
    ) -> Vector<S>;
}

/// A node opens where its gap function is negative.
pub(crate) struct Unilateral;

impl LiftOff for Unilateral {
    #[inline(always)]
    fn stress<S: Simd>(&self, _: usize, _: usize, gap: Vector<S>) -> Vector<S> {
        gap.at_least(0.0)
    }

    #[inline(always)]
    fn pressing<S: Simd>(
        &self,
        _: usize,
        _: usize,
        gap: Vector<S>,
        stiffness: Vector<S>,
    ) -> Vector<S> {
        stiffness.where_positive(gap)
    }
}

/// Nodes never open; the stress may become tension.
pub(crate) struct Bonded;

impl LiftOff for Bonded {
    #[inline(always)]
    fn stress<S: Simd>(&self, _: usize, _: usize, gap: Vector<S>) -> Vector<S> {
        gap
    }

    #[inline(always)]
    fn pressing<S: Simd>(
        &self,
        _: usize,
        _: usize,
        _: Vector<S>,
        stiffness: Vector<S>,
    ) -> Vector<S> {
        stiffness
    }
}

/// The open nodes are given, one bit a node, and stay open; the closed ones stay closed, if need
/// be under tension.
pub(crate) struct Held<'a>(pub &'a [u8]);

impl LiftOff for Held<'_> {
    #[inline(always)]
    fn stress<S: Simd>(&self, block: usize, part: usize, gap: Vector<S>) -> Vector<S> {
        gap.where_clear(self.0[block], part)
    }

    #[inline(always)]
    fn pressing<S: Simd>(
        &self,
        block: usize,
        part: usize,
        _: Vector<S>,
        stiffness: Vector<S>,
    ) -> Vector<S> {
        stiffness.where_clear(self.0[block], part)
    }
}
