//! Eq. (3) and (5): friction force and coefficient of friction as functions of the slip velocity.
//!
//! The force on a node is `-mu(V) N V_vec / V`. The implementation uses the *ratio* `mu(V) / V`, which is
//! finite for zero slip speed `V` (for Eq. (5) it tends to `creep mu_s`), so that no vector of zero length
//! is normalised. Each law is written once, in [`Dual`] numbers: force and derivative cannot disagree.

use std::fmt::Debug;
use std::sync::Arc;

use pulp::Simd;

use super::dual::Dual;
use super::dynamic_friction::{DynamicFriction, Evolving};
use super::friction_table::FrictionTable;
use super::simd::Vector;

/// Coefficient of friction divided by slip speed, with its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// `mu(V) / V`, s/m.
    pub value: f64,
    /// `d(mu(V) / V)/dV`, s^2/m^2. It acts on forces times `V`, so that rounding errors of the order of
    /// those of `value / V` are irrelevant.
    pub slope: f64,
}

/// A friction law: the coefficient as a smooth function of the slip speed.
///
/// Implement it for a custom law and pass it to [`super::Joint::with_friction`]. The law must be regularised
/// at zero like Eq. (5): `mu(0) = 0` with a finite slope.
pub trait FrictionLaw: Debug + Send + Sync {
    /// Ratio `mu(V) / V` and its slope at a slip speed (m/s, non-negative).
    fn ratio(&self, speed: f64) -> Ratio;

    /// Slip speed below which a node is classified as sticking, m/s.
    fn stick_speed(&self) -> f64;
}

/// Least square of a slip speed, m^2/s^2: it permits a division by the speed.
const LEAST_SQUARE: f64 = 1e-280;

/// A coefficient of friction as a function of the slip speed; inlined into the hot loop.
pub(crate) trait Curve {
    /// See [`ContactLaw::IS_COMMON`].
    const IS_COMMON: bool = false;

    /// `mu(V)/V` at positive speeds.
    fn over_speed<S: Simd, const K: usize, const N: usize>(
        &self,
        speed: Dual<S, K, N>,
    ) -> Dual<S, K, N>;

    /// `mu(V)/V` at a single speed (m/s).
    fn ratio_at(&self, speed: f64) -> Ratio {
        let speed = Dual::<_, 1, 1>::scalar(speed.max(LEAST_SQUARE.sqrt()), 0);
        let Dual { value, slopes } = self.over_speed(speed);
        Ratio {
            value: value.sum(),
            slope: slopes[0].sum(),
        }
    }
}

/// Friction as a compile-time parameter of the hot loop.
pub(crate) trait ContactLaw {
    /// Whether there is friction.
    const HAS_FRICTION: bool = true;

    /// Whether the hot loop is compiled without the extras, too. Each combination takes time to compile.
    const IS_COMMON: bool = false;

    /// Whether friction includes the radial slip velocity, as in Eq. (8). It then acts on all three
    /// components of the node frame, otherwise on the two tangential components.
    fn radial(&self) -> bool;

    /// Number of internal states per node.
    fn states(&self) -> usize {
        0
    }

    /// Friction force of a node divided by its normal force, with the opposite sign, and the rate of its state (1/s), at a
    /// slip velocity (m/s) and a state.
    fn response<S: Simd, const K: usize, const N: usize>(
        &self,
        slip: [Dual<S, K, N>; 3],
        state: [Dual<S, K, N>; 3],
    ) -> [[Dual<S, K, N>; 3]; 2];
}

/// Magnitude of a slip velocity (m/s), at least 1e-140 m/s.
#[inline(always)]
pub(crate) fn slip_speed<S: Simd, const K: usize, const N: usize>(
    [along, across, outward]: [Dual<S, K, N>; 3],
    radial: bool,
) -> Dual<S, K, N> {
    let mut square = across.mul_add(across, along * along);
    if radial {
        square = outward.mul_add(outward, square);
    }
    square.at_least(LEAST_SQUARE).sqrt()
}

/// No friction.
pub(crate) struct Frictionless;

impl ContactLaw for Frictionless {
    const HAS_FRICTION: bool = false;
    const IS_COMMON: bool = true;

    #[inline(always)]
    fn radial(&self) -> bool {
        false
    }

    #[inline(always)]
    fn response<S: Simd, const K: usize, const N: usize>(
        &self,
        [along, ..]: [Dual<S, K, N>; 3],
        _state: [Dual<S, K, N>; 3],
    ) -> [[Dual<S, K, N>; 3]; 2] {
        [[Dual::constant(along.value.broadcast(0.0)); 3]; 2]
    }
}

/// Friction against the slip velocity, with a coefficient that depends on its magnitude.
struct AgainstSlip<'a, L: ?Sized> {
    law: &'a L,
    radial: bool,
}

impl<L: Curve + ?Sized> ContactLaw for AgainstSlip<'_, L> {
    const IS_COMMON: bool = L::IS_COMMON;

    #[inline(always)]
    fn radial(&self) -> bool {
        self.radial
    }

    #[inline(always)]
    fn response<S: Simd, const K: usize, const N: usize>(
        &self,
        slip: [Dual<S, K, N>; 3],
        _state: [Dual<S, K, N>; 3],
    ) -> [[Dual<S, K, N>; 3]; 2] {
        let speed = slip_speed(slip, self.radial);
        // The derivative with respect to the speed is one number.
        let ratio = self.law.over_speed(Dual::<S, K, 1>::input(speed.value, 0));
        let ratio = speed.chain(ratio.value, ratio.slopes[0]);
        let zero = Dual::constant(ratio.value.broadcast(0.0));
        let [along, across, outward] = slip;
        let outward = if self.radial { ratio * outward } else { zero };
        [[ratio * along, ratio * across, outward], [zero; 3]]
    }
}

impl Curve for dyn FrictionLaw {
    /// One call per node.
    #[inline(always)]
    fn over_speed<S: Simd, const K: usize, const N: usize>(
        &self,
        speed: Dual<S, K, N>,
    ) -> Dual<S, K, N> {
        speed.compose_scalar(
            #[inline(always)]
            |speed| {
                let Ratio { value, slope } = self.ratio(speed);
                [value, slope]
            },
        )
    }
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
    /// Coulomb friction with a constant coefficient `mu`, regularised: `mu(V) = mu (1 - exp(-creep V))`.
    pub fn constant(mu: f64, creep: f64) -> Self {
        Self {
            mu_s: mu,
            mu_d: mu,
            creep,
            stribeck: 0.0,
        }
    }

    /// The coefficient of friction `mu(V)`.
    pub fn coefficient(&self, speed: f64) -> f64 {
        speed * self.ratio_at(speed).value
    }

    /// `dmu/dV`, s/m.
    pub fn slope(&self, speed: f64) -> f64 {
        let ratio = self.ratio_at(speed);
        ratio.value + speed * ratio.slope
    }
}

/// The sliding factor of Eq. (5), `mu_d + (mu_s - mu_d) exp(-stribeck V)`, as a quotient like [`Dual::exponential`]. A constant
/// coefficient requires no exponential.
#[inline(always)]
pub(crate) fn sliding<S: Simd, const K: usize, const N: usize>(
    [mu_s, mu_d, stribeck]: [f64; 3],
    speed: Dual<S, K, N>,
) -> (Dual<S, K, N>, Vector<S, K>) {
    if mu_s == mu_d {
        let one = speed.value.broadcast(1.0);
        return (Dual::constant(one.broadcast(mu_d)), one);
    }
    let slide = speed.exponential(stribeck);
    let below = slide.below;
    let falling = below.broadcast(mu_s - mu_d);
    let lowest = below * below.broadcast(mu_d);
    (slide.above.times_plus(falling, lowest), below)
}

impl Curve for Stribeck {
    const IS_COMMON: bool = true;

    #[inline(always)]
    fn over_speed<S: Simd, const K: usize, const N: usize>(
        &self,
        speed: Dual<S, K, N>,
    ) -> Dual<S, K, N> {
        let creep = speed.exponential(self.creep);
        let (sliding, below) = sliding([self.mu_s, self.mu_d, self.stribeck], speed);
        let below = creep.below * below;
        creep.rest * sliding / speed.times(below)
    }
}

impl FrictionLaw for Stribeck {
    fn ratio(&self, speed: f64) -> Ratio {
        self.ratio_at(speed)
    }

    fn stick_speed(&self) -> f64 {
        1.0 / self.creep
    }
}

/// Friction law of a joint.
#[derive(Clone, Debug, PartialEq)]
pub enum Friction {
    /// No friction.
    None,
    /// A Stribeck curve, regularised at zero slip.
    Stribeck {
        /// The law.
        law: Stribeck,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
    /// A measured curve, regularised at zero slip.
    Table {
        /// The law.
        law: Arc<FrictionTable>,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
    /// A law with an internal state at each node.
    Dynamic {
        /// The law.
        law: DynamicFriction,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
    /// A law implemented by the user; it equals itself alone.
    Custom {
        /// The law.
        law: Arc<dyn FrictionLaw>,
        /// Whether the radial part `(V . e_r) Phi_r` of Eq. (8) is included.
        radial: bool,
    },
}

impl PartialEq for dyn FrictionLaw {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::addr_eq(self, other)
    }
}

impl Friction {
    /// The law as a function of the slip velocity alone; `None` without friction, and with an internal state.
    pub fn law(&self) -> Option<&dyn FrictionLaw> {
        match self {
            Self::None | Self::Dynamic { .. } => None,
            Self::Stribeck { law, .. } => Some(law),
            Self::Table { law, .. } => Some(law.as_ref()),
            Self::Custom { law, .. } => Some(law.as_ref()),
        }
    }

    /// The law with an internal state.
    pub(crate) fn evolving(&self) -> Option<Evolving<'_>> {
        match *self {
            Self::Dynamic { ref law, radial } => Some(Evolving { law, radial }),
            _ => None,
        }
    }

    /// Number of internal states per contact node.
    pub fn states(&self) -> usize {
        self.evolving().map_or(0, |law| law.states())
    }

    /// Whether friction includes the radial slip velocity.
    pub fn radial(&self) -> bool {
        match *self {
            Self::None => false,
            Self::Stribeck { radial, .. }
            | Self::Table { radial, .. }
            | Self::Dynamic { radial, .. }
            | Self::Custom { radial, .. } => radial,
        }
    }

    /// Calls a function that is compiled for each law.
    #[inline(always)]
    pub(crate) fn dispatch<W: WithLaw>(&self, task: W) -> W::Output {
        match *self {
            Self::None => task.with_law::<_, 0>(Frictionless),
            Self::Stribeck { ref law, radial } => {
                task.with_law::<_, 3>(AgainstSlip { law, radial })
            }
            Self::Table { ref law, radial } => {
                let law = law.as_ref();
                task.with_law::<_, 3>(AgainstSlip { law, radial })
            }
            Self::Dynamic { ref law, radial } => task.with_law::<_, 6>(Evolving { law, radial }),
            Self::Custom { ref law, radial } => {
                let law = law.as_ref();
                task.with_law::<_, 3>(AgainstSlip { law, radial })
            }
        }
    }
}

/// What depends on the type of the friction law.
pub(crate) trait WithLaw {
    type Output;
    /// `N` is the number of inputs of the law: none, the slip velocity, or slip velocity and state, by components.
    fn with_law<L: ContactLaw, const N: usize>(self, law: L) -> Self::Output;
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

    /// Value and slope at all speeds are those of the printed equation; the constant law is Eq. (5) without decrease.
    #[test]
    fn ratio_and_slope_are_those_of_the_equation() {
        for law in [PAPER, PRINTED] {
            for law in [law, Stribeck::constant(law.mu_d, law.creep)] {
                let mut speed = 1e-140;
                while speed < 50.0 {
                    let rest = -(-law.creep * speed).exp_m1();
                    let falling = (law.mu_s - law.mu_d) * (-law.stribeck * speed).exp();
                    let exact = rest * (law.mu_d + falling) / speed;
                    let slope = law.creep * (1.0 - rest) * (law.mu_d + falling)
                        - rest * law.stribeck * falling;
                    let Ratio {
                        value,
                        slope: found,
                    } = law.ratio(speed);
                    assert!((value / exact - 1.0).abs() < 3e-15, "{speed}");
                    let error = (found * speed - (slope - exact)).abs();
                    assert!(error <= 1e-14 * exact, "{speed}: {error}");
                    speed *= 1.13;
                }
                let resting = law.ratio(0.0).value / (law.creep * law.mu_s);
                assert!((resting - 1.0).abs() < 3e-15);
            }
        }
    }
}
