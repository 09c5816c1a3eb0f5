//! What the hot loop leaves behind at each node for the derivative of the force.
//!
//! In a node's own frame the force is `F = -N g(V) V_vec - N e_r`, with `g = mu(V)/V`. A change of the
//! radial displacement, `du_r`, and of the slip velocity, `dV_vec`, changes it by
//!
//! ```text
//! dF = -A k du_r (mu h + e_r) - N g dV_vec - N (dmu/dV - mu/V) h (h . dV_vec)
//! ```
//!
//! where `h` is the direction of the slip velocity. Written so, nothing in it grows without bound as
//! the slip vanishes.

use pulp::Simd;

use super::lanes::{LANES, Place, Vector};

/// Numbers that a block of nodes leaves behind, eight of each.
pub(crate) const KEPT: usize = 7;

/// The derivative at the nodes of some vectors side by side.
#[derive(Clone, Copy)]
pub(crate) struct NodeSlopes<S: Simd, const K: usize = 1> {
    /// `A k` where the node presses, else zero, N/m.
    pub stiffness: Vector<S, K>,
    /// `mu`.
    pub coefficient: Vector<S, K>,
    /// `N g`, N s/m.
    pub drag: Vector<S, K>,
    /// `N (dmu/dV - mu/V)`, N s/m.
    pub bend: Vector<S, K>,
    /// `h` along the node's frame.
    pub direction: [Vector<S, K>; 3],
}

impl<S: Simd> NodeSlopes<S> {
    /// Reads back the stiffness alone.
    #[inline(always)]
    pub fn load_stiffness(simd: S, kept: &[[f64; LANES]], block: usize, part: usize) -> Vector<S> {
        Vector::load(simd, &kept[block * KEPT], part)
    }

    /// Reads back what was kept of a block.
    #[inline(always)]
    pub fn load(simd: S, kept: &[[f64; LANES]], block: usize, part: usize) -> Self {
        let kept = &kept[block * KEPT..][..KEPT];
        let number = |k: usize| Vector::load(simd, &kept[k], part);
        Self {
            stiffness: number(0),
            coefficient: number(1),
            drag: number(2),
            bend: number(3),
            direction: [number(4), number(5), number(6)],
        }
    }
}

impl<S: Simd, const K: usize> NodeSlopes<S, K> {
    /// Those of nodes without friction.
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

    /// Keeps the stiffness alone, which is all that nodes without friction have.
    #[inline(always)]
    pub fn keep_stiffness(stiffness: Vector<S, K>, kept: &mut [[f64; LANES]], first: usize) {
        for k in 0..K {
            let place = Place::of::<S>(first + k);
            let kept = &mut kept[place.block * KEPT];
            stiffness.one(k).store(kept, place.part);
        }
    }

    /// Keeps the derivative at the nodes of the vectors from `first` on: of [`KEPT`] times eight numbers a
    /// block the first `count`; the last is `h` outwards, which not every friction has.
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
            let place = Place::of::<S>(first + k);
            let kept = &mut kept[place.block * KEPT..][..KEPT];
            for (kept, number) in kept.iter_mut().zip(&numbers[..count]) {
                number.one(k).store(kept, place.part);
            }
        }
    }
}
