//! Eq. (23): Lyapunov exponents from the growth of tangent vectors.

mod batches;
mod growth;
mod interval;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub(super) use batches::Growth;
pub use interval::student;

/// A Lyapunov exponent with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Exponent {
    /// Estimate of the value, 1/s unless stated otherwise.
    #[schemars(with = "Option<f64>")]
    pub value: f64,
    /// Half-width of the 95 % confidence interval, in the unit of the value; infinite while it cannot be
    /// estimated.
    #[schemars(with = "Option<f64>")]
    pub half_width: f64,
}

impl Exponent {
    /// Lower end of the 95 % confidence interval, 1/s.
    pub fn low(&self) -> f64 {
        self.value - self.half_width
    }

    /// Upper end of the 95 % confidence interval, 1/s.
    pub fn high(&self) -> f64 {
        self.value + self.half_width
    }
}

/// Sign of an exponent as far as its confidence interval determines it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Sign {
    /// The whole interval lies above zero by more than the resolution.
    Positive,
    /// The interval contains zero and is no wider than the resolution, over at least the minimum
    /// averaging time for a zero exponent ([`MIN_PERIODS_FOR_ZERO`]).
    Zero,
    /// The whole interval lies below zero by more than the resolution.
    Negative,
    /// Undetermined: the interval is too wide, or it excludes zero only within the resolution.
    Undetermined,
}

/// Minimum averaging time for a zero exponent, in periods of the slowest mode. Over a shorter time a
/// slowly decaying direction is indistinguishable from a neutral one. A system without modes has no time
/// scale and no minimum.
pub const MIN_PERIODS_FOR_ZERO: f64 = 1000.0;

/// The largest Lyapunov exponents of a trajectory, or all of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LyapunovSpectrum {
    /// The exponents in the order of the orthonormal vectors. The order is descending after the vectors
    /// have converged to their directions. Exponents that differ by less than their intervals may be in
    /// either order; sorting them would bias their difference. A collapsed direction, for example that
    /// of a sticking mass, has the value minus infinity.
    #[serde(rename = "exponents_per_s")]
    pub exponents: Vec<Exponent>,
    /// Averaging time, s.
    #[serde(rename = "averaged_s")]
    pub time: f64,
    /// Dimension of the tangent space: the total number of exponents.
    pub dimension: usize,
    /// Resolution, 1/s: an exponent of smaller magnitude is indistinguishable from zero over this
    /// averaging time. A neutral vector also changes its length, by an assumed factor of 10 or by the
    /// observed range.
    #[serde(rename = "resolution_per_s")]
    #[schemars(with = "Option<f64>")]
    pub resolution: f64,
    /// The Kaplan–Yorke dimension with its 95 % interval, dimensionless: `k` plus the sum of the first
    /// `k` exponents divided by the magnitude of the next one, where `k` is the largest number of
    /// exponents whose sum is not negative. Exponents that count as zero are taken as zero. `None` for an
    /// equilibrium, if too few exponents are known, or if it depends on an undetermined one. (J. L. Kaplan
    /// and J. A. Yorke, Lecture Notes in Mathematics 730 (1979) 204-227.)
    pub kaplan_yorke: Option<Exponent>,
}

/// Type of motion as far as it is known without the exponents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Motion {
    /// A non-constant motion of an autonomous system.
    #[default]
    Free,
    /// A motion of a non-autonomous (driven) system. The drive phase has no tangent vector, so there is
    /// one zero exponent less than for the autonomous system.
    Driven,
    /// The state has not changed at all: an equilibrium.
    Still,
}

/// Type of attractor, classified by the exponents. It is serialised as its [`Attractor::name`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, strum::IntoStaticStr)]
#[serde(into = "&'static str")]
#[strum(serialize_all = "kebab-case")]
pub enum Attractor {
    /// A fixed point, at which the state is constant, with negative exponents.
    StableEquilibrium,
    /// A fixed point with a positive exponent.
    UnstableEquilibrium,
    /// A fixed point of which neither is shown.
    Equilibrium,
    /// All exponents are negative: the motion converges to a fixed point.
    FixedPoint,
    /// Driven, and all exponents are negative: the motion is phase-locked to the drive.
    PhaseLocked,
    /// One zero exponent, the others negative: a limit cycle.
    Cycle,
    /// A torus with this number of frequencies (two or more), including that of a drive. Each frequency
    /// except that of the drive has a zero exponent; the others are negative.
    Torus(usize),
    /// Exactly one exponent is shown to be positive.
    Chaos,
    /// This number of exponents is shown to be positive (two or more).
    Hyperchaos(usize),
    /// A relevant exponent is undetermined, or too few exponents are known.
    #[default]
    Undecided,
}

impl Attractor {
    /// Whether at least one exponent is shown to be positive.
    pub fn is_chaotic(self) -> bool {
        matches!(self, Self::Chaos | Self::Hyperchaos(_))
    }

    /// Whether the classification is conclusive.
    pub fn is_decided(self) -> bool {
        !matches!(self, Self::Undecided | Self::Equilibrium)
    }

    /// Identifier for tables and files: `fixed-point`, `phase-locked`, `cycle`, `torus`, `chaos`,
    /// `hyperchaos`, `stable-equilibrium`, `unstable-equilibrium`, `equilibrium` or `undecided`.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl std::fmt::Display for Attractor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::StableEquilibrium => f.write_str("stable equilibrium"),
            Self::UnstableEquilibrium => f.write_str("unstable equilibrium"),
            Self::Equilibrium => f.write_str("equilibrium of undetermined stability"),
            Self::FixedPoint => f.write_str("fixed point"),
            Self::PhaseLocked => f.write_str("phase-locked to the drive"),
            Self::Cycle => f.write_str("limit cycle"),
            Self::Torus(frequencies) => write!(f, "torus with {frequencies} frequencies"),
            other => f.write_str(other.name()),
        }
    }
}

impl LyapunovSpectrum {
    /// Sign of exponent `k`, counted from 0.
    ///
    /// # Panics
    /// If `k` is not less than the number of exponents.
    pub fn sign(&self, k: usize) -> Sign {
        let exponent = self.exponents[k];
        if exponent.low() > self.resolution {
            Sign::Positive
        } else if exponent.high() < -self.resolution {
            Sign::Negative
        } else if exponent.value.abs() <= exponent.half_width
            && exponent.half_width <= self.resolution
            && exponent.half_width.is_finite()
        {
            Sign::Zero
        } else {
            Sign::Undetermined
        }
    }

    /// Number of exponents with the given sign.
    pub fn count(&self, sign: Sign) -> usize {
        let all = 0..self.exponents.len();
        all.filter(|&k| self.sign(k) == sign).count()
    }

    /// Type of attractor of an autonomous system; see [`LyapunovSpectrum::attractor_of`].
    pub fn attractor(&self) -> Attractor {
        self.attractor_of(Motion::Free)
    }

    /// Type of attractor. An exponent counts as positive only if its whole interval is positive, so
    /// hyperchaos requires two such exponents. For an equilibrium the same exponents determine only its
    /// stability.
    pub fn attractor_of(&self, motion: Motion) -> Attractor {
        let [positive, zero, negative, doubtful] = [
            Sign::Positive,
            Sign::Zero,
            Sign::Negative,
            Sign::Undetermined,
        ]
        .map(|s| self.count(s));
        // Exponents that are not computed do not exceed the last computed one.
        let known = self.exponents.len() >= self.dimension || negative > 0;
        let known = known && doubtful == 0 && !self.exponents.is_empty();
        if motion == Motion::Still {
            return match (positive, zero) {
                (1.., _) => Attractor::UnstableEquilibrium,
                (0, 0) if known => Attractor::StableEquilibrium,
                _ => Attractor::Equilibrium,
            };
        }
        match (positive, zero, motion) {
            (1, ..) => Attractor::Chaos,
            (2.., ..) => Attractor::Hyperchaos(positive),
            _ if !known => Attractor::Undecided,
            (_, 0, Motion::Driven) => Attractor::PhaseLocked,
            (_, 0, _) => Attractor::FixedPoint,
            (_, 1, Motion::Free) => Attractor::Cycle,
            (_, _, Motion::Driven) => Attractor::Torus(zero + 1),
            _ => Attractor::Torus(zero),
        }
    }
}

#[cfg(test)]
mod tests;
