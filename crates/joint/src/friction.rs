//! Eq. (3) and (5): friction force and coefficient of friction as functions of the slip velocity.
//!
//! The force on a node is `-mu(V) N V_vec / V`. The implementation uses the *ratio* `mu(V) / V`, which is
//! finite for zero slip speed `V` (for Eq. (5) it tends to `creep mu_s`), so that no vector of zero length
//! is normalised. One call returns value and slope, which keeps force and Jacobian consistent.

use std::fmt::Debug;

use pulp::Simd;

use super::exponential::Exponential;
use super::simd::Vector;

/// Coefficient of friction divided by slip speed, with its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// `mu(V) / V`, s/m.
    pub value: f64,
    /// `d(mu(V) / V)/dV`, s^2/m^2.
    pub slope: f64,
}

/// A friction law: the coefficient as a smooth function of the slip speed.
///
/// Implement it for a custom law and pass it to [`super::Joint::with_friction`]. The law must be regularised
/// at zero like Eq. (5): `mu(0) = 0` with a finite slope.
pub trait FrictionLaw: Debug + Send + Sync {
    /// Ratio `mu(V) / V` and its slope at a slip speed (m/s, non-negative).
    fn ratio(&self, speed: f64) -> Ratio;

    /// Replaces each slip speed by its ratio. Override it if the law can be vectorised.
    fn ratios(&self, speeds: &mut [f64]) {
        for speed in speeds {
            *speed = self.ratio(*speed).value;
        }
    }

    /// As [`FrictionLaw::ratios`]; writes the slopes of the ratios to `slopes`.
    fn ratios_and_slopes(&self, speeds: &mut [f64], slopes: &mut [f64]) {
        for (slope, speed) in slopes.iter_mut().zip(speeds.iter()) {
            *slope = self.ratio(*speed).slope;
        }
        self.ratios(speeds);
    }

    /// Slip speed below which a node is classified as sticking, m/s.
    fn stick_speed(&self) -> f64;
}

/// A law with a vectorised coefficient.
pub(crate) trait VectorLaw {
    /// `mu(V)/V` for several positive speeds at once; inlined into the hot loop.
    fn ratio_vector<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K>;
    /// [`VectorLaw::ratio_vector`], bit-identical, and `V` times its slope, from the same exponentials.
    fn ratio_and_slope_vector<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>);
}

/// Eq. (5): `mu(V) = (1 - exp(-creep V)) (mu_d + (mu_s - mu_d) exp(-stribeck V))`, the smoothing curve
/// method.
///
/// In the paper `creep` is `d` and `stribeck` is `f`. As printed in Fig. 3 (`d = 10`, `f = 1000`) the curve
/// has no negative slope at the slip speed of the paper; with exchanged values the joint squeaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// Static coefficient `mu_s`.
    pub mu_s: f64,
    /// Kinetic coefficient `mu_d`.
    pub mu_d: f64,
    /// Slope factor of the creep region, s/m, positive.
    pub creep: f64,
    /// Slope factor of the sliding region, s/m, non-negative.
    pub stribeck: f64,
}

impl Stribeck {
    /// The coefficient of friction `mu(V)`.
    pub fn coefficient(&self, speed: f64) -> f64 {
        -(-self.creep * speed).exp_m1() * self.sliding(speed)
    }

    /// `dmu/dV`, s/m.
    pub fn slope(&self, speed: f64) -> f64 {
        self.creep * (-self.creep * speed).exp() * self.sliding(speed)
            - (-self.creep * speed).exp_m1() * self.sliding_slope(speed)
    }

    /// The sliding factor of Eq. (5), `mu_d + (mu_s - mu_d) exp(-stribeck V)`, at a slip speed `V` (m/s).
    pub fn sliding(&self, speed: f64) -> f64 {
        self.mu_d + (self.mu_s - self.mu_d) * (-self.stribeck * speed).exp()
    }

    fn sliding_slope(&self, speed: f64) -> f64 {
        -self.stribeck * (self.mu_s - self.mu_d) * (-self.stribeck * speed).exp()
    }

    /// `exp(-creep V)` and `exp(-stribeck V)`.
    #[inline(always)]
    fn exponentials<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Exponential<S, K>, Exponential<S, K>) {
        (
            Exponential::of(speed, self.creep),
            Exponential::of(speed, self.stribeck),
        )
    }

    /// The sliding factor times the denominator of its exponential.
    #[inline(always)]
    fn sliding_vector<S: Simd, const K: usize>(&self, slide: Exponential<S, K>) -> Vector<S, K> {
        let (above, below) = (slide.above(), slide.below());
        above.mul_add(
            above.broadcast(self.mu_s - self.mu_d),
            below * below.broadcast(self.mu_d),
        )
    }
}

impl VectorLaw for Stribeck {
    #[inline(always)]
    fn ratio_vector<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K> {
        let (creep, slide) = self.exponentials(speed);
        let below = creep.below() * slide.below();
        creep.rest() * self.sliding_vector(slide) / (speed * below)
    }

    /// The cancellation near zero speed is small compared with the ratio, to which the force derivative adds the slope.
    #[inline(always)]
    fn ratio_and_slope_vector<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>) {
        let (creep, slide) = self.exponentials(speed);
        let below = creep.below() * slide.below();
        let sliding = self.sliding_vector(slide);
        let ratio = creep.rest() * sliding / (speed * below);
        let creep_rise = creep.above() * speed.broadcast(self.creep);
        let sliding_fall = slide.above() * speed.broadcast(self.stribeck * (self.mu_s - self.mu_d));
        let slope = creep_rise.mul_add(sliding, -(creep.rest() * sliding_fall)) / below;
        (ratio, slope - ratio)
    }
}

impl FrictionLaw for Stribeck {
    fn ratio(&self, speed: f64) -> Ratio {
        let x = self.creep * speed;
        let (share, share_slope) = creep_share(x);
        // mu / V = creep * (1 - exp(-x))/x * sliding
        Ratio {
            value: self.creep * share * self.sliding(speed),
            slope: self.creep
                * (self.creep * share_slope * self.sliding(speed)
                    + share * self.sliding_slope(speed)),
        }
    }

    fn stick_speed(&self) -> f64 {
        1.0 / self.creep
    }
}

/// Coulomb friction with constant coefficient, regularised: `mu(V) = mu (1 - exp(-creep V))`. This is Eq. (5)
/// with `mu_s = mu_d = mu` and requires one exponential only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    /// Coefficient of friction `mu` during sliding.
    pub mu: f64,
    /// Slope factor of the creep region, s/m, positive.
    pub creep: f64,
}

impl VectorLaw for Constant {
    #[inline(always)]
    fn ratio_vector<S: Simd, const K: usize>(&self, speed: Vector<S, K>) -> Vector<S, K> {
        let creep = Exponential::of(speed, self.creep);
        creep.rest() * speed.broadcast(self.mu) / (speed * creep.below())
    }

    #[inline(always)]
    fn ratio_and_slope_vector<S: Simd, const K: usize>(
        &self,
        speed: Vector<S, K>,
    ) -> (Vector<S, K>, Vector<S, K>) {
        let creep = Exponential::of(speed, self.creep);
        let ratio = creep.rest() * speed.broadcast(self.mu) / (speed * creep.below());
        let slope = creep.above() * speed.broadcast(self.creep * self.mu) / creep.below();
        (ratio, slope - ratio)
    }
}

impl FrictionLaw for Constant {
    fn ratio(&self, speed: f64) -> Ratio {
        let (share, share_slope) = creep_share(self.creep * speed);
        let steepest = self.creep * self.mu;
        Ratio {
            value: steepest * share,
            slope: steepest * self.creep * share_slope,
        }
    }

    fn stick_speed(&self) -> f64 {
        1.0 / self.creep
    }
}

/// `(1 - exp(-x)) / x` and its derivative for `x >= 0`, without cancellation.
pub(super) fn creep_share(x: f64) -> (f64, f64) {
    if x >= 0.5 {
        let value = -(-x).exp_m1() / x;
        return (value, ((-x).exp() - value) / x);
    }
    // sum over k of (-x)^k / (k+1)!, and its derivative; 16 terms give full precision.
    let (mut value, mut slope) = (1.0, 0.0);
    let mut term = 0.5; // (-x)^(k-1) / (k+1)!
    for k in 1..=16 {
        value -= x * term;
        slope -= f64::from(k) * term;
        term *= -x / f64::from(k + 2);
    }
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: Stribeck = Stribeck {
        mu_s: 0.55,
        mu_d: 0.25,
        creep: 1000.0,
        stribeck: 10.0,
    };
    const PRINTED: Stribeck = Stribeck {
        creep: 10.0,
        stribeck: 1000.0,
        ..PAPER
    };

    /// Both readings of Fig. 3 at the slip speed of the paper.
    #[test]
    fn both_readings_at_the_paper_speed() {
        assert!((PAPER.coefficient(15.9e-3) - 0.506).abs() < 5e-4);
        assert!((PAPER.slope(15.9e-3) + 2.56).abs() < 5e-3);
        assert!((PRINTED.coefficient(15.9e-3) - 0.037).abs() < 5e-4);
        assert!(PRINTED.slope(15.9e-3) > 0.0);
    }

    /// The ratio is the coefficient divided by the speed, and its slope is the derivative, at all speeds.
    #[test]
    fn ratio_and_slope_agree_with_the_coefficient() {
        for law in [PAPER, PRINTED] {
            for speed in [1e-9, 1e-6, 1e-4, 4.9e-4, 5.1e-4, 3e-3, 0.0159, 0.3, 2.0] {
                let ratio = law.ratio(speed);
                assert!((ratio.value * speed / law.coefficient(speed) - 1.0).abs() < 1e-14);
                let exact = (law.slope(speed) - ratio.value) / speed;
                // The closed form cancels at low speeds; the tolerance includes its rounding error.
                let rounding = 4e-16 * ratio.value / speed;
                assert!(
                    (ratio.slope - exact).abs() <= 1e-12 * exact.abs() + rounding,
                    "{speed}"
                );
            }
            assert_eq!(law.ratio(0.0).value, law.creep * law.mu_s);
            let tiny = law.ratio(1e-300);
            assert!((tiny.value / (law.creep * law.mu_s) - 1.0).abs() < 1e-15);
        }
    }

    /// Vector and scalar forms agree within a few units in the last place.
    #[test]
    fn vectors_agree_with_scalars() {
        struct Ratios(Stribeck, Constant, f64);
        impl pulp::WithSimd for Ratios {
            type Output = [f64; 3];
            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
                let speed = Vector::<S>::splat(simd, self.2);
                let (again, slope) = self.1.ratio_and_slope_vector(speed);
                let ratios = [
                    self.0.ratio_vector(speed),
                    self.1.ratio_vector(speed),
                    slope,
                ];
                assert_eq!(again.sum(), ratios[1].sum());
                ratios.map(|ratio| ratio.sum() / S::F64_LANES as f64)
            }
        }
        for law in [PAPER, PRINTED] {
            let mut speed = 1e-140;
            while speed < 50.0 {
                let constant = Constant {
                    mu: law.mu_d,
                    creep: law.creep,
                };
                let [got, flat, slope] = pulp::Arch::new().dispatch(Ratios(law, constant, speed));
                let exact = law.ratio(speed).value;
                assert!((got / exact - 1.0).abs() < 3e-15, "{speed}");
                // The constant law is Eq. (5) without decrease.
                let level = Stribeck {
                    mu_s: law.mu_d,
                    ..law
                };
                let (exact, same) = (constant.ratio(speed), level.ratio(speed));
                assert!((exact.value / same.value - 1.0).abs() < 1e-15, "{speed}");
                assert!((exact.slope / same.slope - 1.0).abs() < 1e-14, "{speed}");
                assert!((flat / exact.value - 1.0).abs() < 3e-15, "{speed}");
                let slope = (slope - exact.slope * speed).abs();
                assert!(slope <= 1e-14 * exact.value, "{speed}: {slope}");
                speed *= 1.13;
            }
        }
    }
}
