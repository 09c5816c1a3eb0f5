//! Derivatives of the contact force at each node, recorded by the hot loop.
//!
//! In the sliding frame the force of a node is `F = -N g(V) V_vec - N e_r`, with `g = mu(V)/V`. Its change
//! with radial displacement `du_r` and slip velocity `dV_vec` is
//!
//! ```text
//! dF = -A k du_r (mu h + e_r) - N g dV_vec - N (dmu/dV - mu/V) h (h . dV_vec)
//! ```
//!
//! where `h` is the direction of the slip velocity. In this form all terms are bounded for vanishing slip.

use pulp::Simd;

use super::simd::{LANES, LanePosition, Vector};

/// Recorded numbers for a block of nodes, eight of each. With contact damping, the viscosities (N s/m) of all blocks follow.
pub(crate) const KEPT: usize = 7;

/// Derivatives at the nodes of adjacent vectors.
#[derive(Clone, Copy)]
pub(crate) struct NodeSlopes<S: Simd, const K: usize = 1> {
    /// `A k` of a closed node, zero for a separated one, N/m.
    pub stiffness: Vector<S, K>,
    /// `mu`.
    pub coefficient: Vector<S, K>,
    /// `N g`, N s/m.
    pub drag: Vector<S, K>,
    /// `N (dmu/dV - mu/V)`, N s/m.
    pub bend: Vector<S, K>,
    /// Components of `h` in the sliding frame.
    pub direction: [Vector<S, K>; 3],
}

impl<S: Simd, const K: usize> NodeSlopes<S, K> {
    /// Loads the derivatives at the nodes of the vectors from `first` on.
    #[inline(always)]
    pub fn load(simd: S, kept: &[[f64; LANES]], first: usize) -> Self {
        let mut numbers = [Vector::splat(simd, 0.0); KEPT];
        for (n, number) in numbers.iter_mut().enumerate() {
            *number = Self::load_number(simd, kept, first, n);
        }
        let [stiffness, coefficient, drag, bend, direction @ ..] = numbers;
        Self {
            stiffness,
            coefficient,
            drag,
            bend,
            direction,
        }
    }

    /// Loads the derivatives of nodes without friction.
    #[inline(always)]
    pub fn load_frictionless(simd: S, kept: &[[f64; LANES]], first: usize) -> Self {
        Self::frictionless(simd, Self::load_number(simd, kept, first, 0))
    }

    /// Loads one of the derivatives.
    #[inline(always)]
    fn load_number(simd: S, kept: &[[f64; LANES]], first: usize, number: usize) -> Vector<S, K> {
        Vector::from_parts(
            simd,
            #[inline(always)]
            |k| {
                let place = LanePosition::of::<S>(first + k);
                Vector::load(simd, &kept[place.block * KEPT + number], place.part)
            },
        )
    }

    /// Derivatives of nodes without friction.
    #[inline(always)]
    pub fn frictionless(simd: S, stiffness: Vector<S, K>) -> Self {
        let zero = Vector::splat(simd, 0.0);
        Self {
            stiffness,
            coefficient: zero,
            drag: zero,
            bend: zero,
            direction: [zero; 3],
        }
    }

    /// Stores the stiffness, the only derivative of nodes without friction.
    #[inline(always)]
    pub fn keep_stiffness(stiffness: Vector<S, K>, kept: &mut [[f64; LANES]], first: usize) {
        for k in 0..K {
            let place = LanePosition::of::<S>(first + k);
            let kept = &mut kept[place.block * KEPT];
            stiffness.one(k).store(kept, place.part);
        }
    }

    /// Stores the first `count` of the [`KEPT`] derivatives at the nodes of the vectors from `first` on;
    /// the last one, the outward component of `h`, is not required by all friction laws.
    #[inline(always)]
    pub fn keep(self, count: usize, kept: &mut [[f64; LANES]], first: usize) {
        let [along, across, outward] = self.direction;
        let numbers = [
            self.stiffness,
            self.coefficient,
            self.drag,
            self.bend,
            along,
            across,
            outward,
        ];
        for k in 0..K {
            let place = LanePosition::of::<S>(first + k);
            let kept = &mut kept[place.block * KEPT..][..KEPT];
            for (kept, number) in kept.iter_mut().zip(&numbers[..count]) {
                number.one(k).store(kept, place.part);
            }
        }
    }
}
