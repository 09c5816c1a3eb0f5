//! What the hot loop is compiled for: each law of friction, with and without the radial velocity.

use pulp::Simd;

use super::friction::FrictionLaw;
use super::lanes::Vector;

/// What the loop does at each node for friction.
pub(crate) trait Law {
    /// Whether there is friction at all.
    const SLIDES: bool;
    /// Whether the radial velocity takes part, as Eq. (8) has it. Friction then acts on all three components
    /// of a node's frame, else on the two tangential ones.
    const RADIAL: bool;
    /// `mu(V)/V` at the given speeds, all positive.
    fn ratio<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K>;
    /// The same, and `V` times the slope of the ratio: `dmu/dV - mu/V`.
    fn ratio_and_slope<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>);
}

/// No friction.
pub(crate) struct Frictionless;

impl Law for Frictionless {
    const SLIDES: bool = false;
    const RADIAL: bool = false;
    #[inline(always)]
    fn ratio<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K> {
        speed.same(0.0)
    }
    #[inline(always)]
    fn ratio_and_slope<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>) {
        (speed.same(0.0), speed.same(0.0))
    }
}

/// Eq. (5).
pub(crate) struct Smoothed<const RADIAL: bool>(pub super::Stribeck);

impl<const RADIAL: bool> Law for Smoothed<RADIAL> {
    const SLIDES: bool = true;
    const RADIAL: bool = RADIAL;
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

/// A constant coefficient, smoothed at rest.
pub(crate) struct Level<const RADIAL: bool>(pub super::Constant);

impl<const RADIAL: bool> Law for Level<RADIAL> {
    const SLIDES: bool = true;
    const RADIAL: bool = RADIAL;
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

/// A user's own law, called once a vector.
pub(crate) struct Custom<'a, const RADIAL: bool>(pub &'a dyn FrictionLaw);

impl<const RADIAL: bool> Law for Custom<'_, RADIAL> {
    const SLIDES: bool = true;
    const RADIAL: bool = RADIAL;
    #[inline(always)]
    fn ratio<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K> {
        speed.through(|speeds| self.0.ratios(speeds))
    }
    #[inline(always)]
    fn ratio_and_slope<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>) {
        let (ratio, slope) =
            speed.through_both(|speeds, slopes| self.0.ratios_and_slopes(speeds, slopes));
        (ratio, speed * slope)
    }
}
