//! Friction laws as compile-time parameters of the hot loop, with and without the radial slip velocity.

use pulp::Simd;

use super::friction::{FrictionLaw, VectorLaw};
use super::simd::Vector;

/// Friction law of the hot loop.
pub(crate) trait FrictionKernel {
    /// Whether the law has friction.
    const HAS_FRICTION: bool = true;
    /// Whether friction includes the radial slip velocity, as in Eq. (8). It then acts on all three
    /// components of the node frame, otherwise on the two tangential components. A constant, except for
    /// measured curves and custom laws.
    fn radial(&self) -> bool;
    /// `mu(V)/V` at positive speeds; zero for a law that is evaluated elsewhere.
    #[inline(always)]
    fn ratio<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K> {
        speed.broadcast(0.0)
    }
    /// `mu(V)/V`, and `V` times its slope: `dmu/dV - mu/V`.
    #[inline(always)]
    fn ratio_and_slope<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>) {
        (speed.broadcast(0.0), speed.broadcast(0.0))
    }
}

/// No friction.
pub(crate) struct Frictionless;

impl FrictionKernel for Frictionless {
    const HAS_FRICTION: bool = false;
    #[inline(always)]
    fn radial(&self) -> bool {
        false
    }
}

/// A law that the hot loop is compiled for.
pub(crate) struct Curve<L, const RADIAL: bool>(pub L);

impl<L: VectorLaw, const RADIAL: bool> FrictionKernel for Curve<L, RADIAL> {
    #[inline(always)]
    fn radial(&self) -> bool {
        RADIAL
    }
    #[inline(always)]
    fn ratio<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K> {
        self.0.ratio_vector(speed)
    }
    #[inline(always)]
    fn ratio_and_slope<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>) {
        self.0.ratio_and_slope_vector(speed)
    }
}

/// The slip velocity for laws with an internal state, which are evaluated elsewhere.
pub(crate) struct SlipOnly {
    pub radial: bool,
}

impl FrictionKernel for SlipOnly {
    #[inline(always)]
    fn radial(&self) -> bool {
        self.radial
    }
}

/// A custom law, called once per vector.
pub(crate) struct Custom<'a> {
    pub law: &'a dyn FrictionLaw,
    pub radial: bool,
}

impl FrictionKernel for Custom<'_> {
    #[inline(always)]
    fn radial(&self) -> bool {
        self.radial
    }
    #[inline(always)]
    fn ratio<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K> {
        speed.map_slice(|speeds| self.law.ratios(speeds))
    }
    #[inline(always)]
    fn ratio_and_slope<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>) {
        let (ratio, slope) =
            speed.map_slices(|speeds, slopes| self.law.ratios_and_slopes(speeds, slopes));
        (ratio, speed * slope)
    }
}
