//! Eq. (23): Lyapunov exponents from the growth of tangent vectors.

mod batches;
mod growth;
mod interval;

use serde::Serialize;

pub(super) use growth::Growth;

/// One Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exponent {
    /// Its value, 1/s.
    pub value: f64,
    /// Half the width of its 95 % confidence interval, 1/s; infinite while it cannot be told.
    pub half_width: f64,
}

impl Exponent {
    /// Lower end of the interval, 1/s.
    pub fn low(&self) -> f64 {
        self.value - self.half_width
    }

    /// Upper end of the interval, 1/s.
    pub fn high(&self) -> f64 {
        self.value + self.half_width
    }
}

/// What can be said of an exponent's sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// The whole interval is above zero, beyond the resolution.
    Positive,
    /// The interval holds zero and is no wider than the resolution, in a time long enough for a zero
    /// ([`PERIODS_FOR_ZERO`]).
    Zero,
    /// The whole interval is below zero, beyond the resolution.
    Negative,
    /// Neither: the interval is too wide, or it excludes zero within the resolution.
    Doubtful,
}

/// Periods of the slowest mode over which growth has to be averaged before an exponent counts as
/// zero. In less time, one that decays slowly looks alike. Where there is no mode there is no measure
/// of time, and any is long enough.
pub const PERIODS_FOR_ZERO: f64 = 1000.0;

/// The largest Lyapunov exponents of a motion, or all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LyapunovSpectrum {
    /// The exponents, in the order of the orthonormal vectors. It is the falling order once the
    /// vectors have turned to their directions; exponents nearer to each other than their intervals
    /// may stand either way round, since sorting them would push them apart. A direction that
    /// collapses, as all that sticks does, has the value minus infinity.
    pub exponents: Vec<Exponent>,
    /// Time over which growth was averaged, s.
    pub time: f64,
    /// Dimension of the tangent space: how many exponents there are in all.
    pub dimension: usize,
    /// An exponent nearer to zero than this cannot be told from zero in this time, 1/s: a neutral
    /// vector changes its length, too, by a factor of ten, say, or by what was seen of it.
    pub resolution: f64,
    /// The Kaplan-Yorke dimension, see [`LyapunovSpectrum::kaplan_yorke`].
    pub kaplan_yorke: Option<Exponent>,
}

/// What is known of a motion beside its exponents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Motion {
    /// It moves, left to itself.
    #[default]
    Free,
    /// It moves under a law that changes with time. The phase of the drive has no tangent vector:
    /// there is one exponent of zero less than a motion left to itself would have.
    Driven,
    /// The state has not moved at all: an equilibrium.
    Still,
}

/// What a motion comes to, by its exponents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attractor {
    /// The state does not move at all.
    Equilibrium(Stability),
    /// All exponents negative: it comes to rest.
    Rest,
    /// Driven, and all exponents negative: it follows its drive.
    InStep,
    /// One exponent zero, the others negative: a limit cycle.
    Cycle,
    /// So many tones (two or more), the one of a drive included; one exponent of zero for each of the
    /// others, the rest negative.
    Torus(usize),
    /// One exponent positive, and none beside it shown to be.
    Chaos,
    /// So many exponents shown to be positive (two or more).
    HyperChaos(usize),
    /// Some exponent that matters is doubtful, or too few are known.
    Undecided,
}

/// What becomes of states near an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// They come to it: all exponents are negative.
    Stable,
    /// They leave it: an exponent is positive.
    Unstable,
    /// Neither is shown.
    Undecided,
}

impl Attractor {
    /// Whether something is told.
    pub fn is_decided(self) -> bool {
        !matches!(
            self,
            Self::Undecided | Self::Equilibrium(Stability::Undecided)
        )
    }

    /// In a word, for tables and files: `rest`, `in-step`, `cycle`, `torus`, `chaos`, `hyper-chaos`,
    /// `stable-equilibrium`, `unstable-equilibrium`, `equilibrium` or `undecided`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Equilibrium(Stability::Stable) => "stable-equilibrium",
            Self::Equilibrium(Stability::Unstable) => "unstable-equilibrium",
            Self::Equilibrium(Stability::Undecided) => "equilibrium",
            Self::Rest => "rest",
            Self::InStep => "in-step",
            Self::Cycle => "cycle",
            Self::Torus(_) => "torus",
            Self::Chaos => "chaos",
            Self::HyperChaos(_) => "hyper-chaos",
            Self::Undecided => "undecided",
        }
    }
}

impl std::fmt::Display for Attractor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Equilibrium(Stability::Stable) => f.write_str("rests on a stable equilibrium"),
            Self::Equilibrium(Stability::Unstable) => {
                f.write_str("rests on an unstable equilibrium")
            }
            Self::Equilibrium(Stability::Undecided) => f.write_str("rests on an equilibrium"),
            Self::InStep => f.write_str("in step with its drive"),
            Self::Cycle => f.write_str("limit cycle"),
            Self::Torus(tones) => write!(f, "torus of {tones} tones"),
            other => f.write_str(other.name()),
        }
    }
}

impl LyapunovSpectrum {
    /// What is known of the sign of exponent `k`.
    ///
    /// # Panics
    /// When there are not so many exponents.
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
            Sign::Doubtful
        }
    }

    /// How many of the exponents have a sign.
    pub fn count(&self, sign: Sign) -> usize {
        let all = 0..self.exponents.len();
        all.filter(|&k| self.sign(k) == sign).count()
    }

    /// What a motion left to itself comes to; see [`LyapunovSpectrum::attractor_of`].
    pub fn attractor(&self) -> Attractor {
        self.attractor_of(Motion::Free)
    }

    /// What the motion comes to. An exponent counts as positive only if its whole interval is; so a
    /// motion is called hyper-chaotic only if two are. At an equilibrium the same exponents tell of
    /// its stability alone.
    pub fn attractor_of(&self, motion: Motion) -> Attractor {
        let [positive, zero, negative, doubtful] =
            [Sign::Positive, Sign::Zero, Sign::Negative, Sign::Doubtful].map(|s| self.count(s));
        // Those not followed are at or below the last one followed.
        let known = self.exponents.len() >= self.dimension || negative > 0;
        let known = known && doubtful == 0 && !self.exponents.is_empty();
        if motion == Motion::Still {
            return Attractor::Equilibrium(match (positive, zero) {
                (1.., _) => Stability::Unstable,
                (0, 0) if known => Stability::Stable,
                _ => Stability::Undecided,
            });
        }
        match (positive, zero, motion) {
            (1, ..) => Attractor::Chaos,
            (2.., ..) => Attractor::HyperChaos(positive),
            _ if !known => Attractor::Undecided,
            (_, 0, Motion::Driven) => Attractor::InStep,
            (_, 0, _) => Attractor::Rest,
            (_, 1, Motion::Free) => Attractor::Cycle,
            (_, _, Motion::Driven) => Attractor::Torus(zero + 1),
            _ => Attractor::Torus(zero),
        }
    }

    /// The Kaplan-Yorke dimension with its 95 % interval, a pure number: `k` and the sum of the
    /// first `k` exponents over the size of the next one, `k` being the most exponents whose sum is
    /// not negative; exponents that count as zero are taken as zero. `None` where too few exponents
    /// are known, or where a doubtful one decides. (J. L. Kaplan and J. A. Yorke, Lecture Notes in Mathematics 730 (1979) 204-227.)
    pub fn kaplan_yorke(&self) -> Option<Exponent> {
        self.kaplan_yorke
    }
}

#[cfg(test)]
mod tests;
