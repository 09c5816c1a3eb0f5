//! Eq. (23): Lyapunov exponents from the growth of tangent vectors.

mod batches;
mod growth;
mod interval;

pub(super) use growth::Growth;

/// One Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// The whole interval is above zero.
    Positive,
    /// Zero, as nearly as the time averaged can tell.
    Zero,
    /// The whole interval is below zero.
    Negative,
    /// The interval is too wide to tell.
    Doubtful,
}

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

/// What a motion comes to, by its exponents.
///
/// The phase of a drive has no tangent vector. A driven motion therefore has one exponent of zero
/// less: where a motion left to itself would be a cycle, a driven one, with all exponents negative,
/// follows its drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attractor {
    /// All exponents negative: it comes to rest, or follows its drive.
    Rest,
    /// One exponent zero, the others negative: a limit cycle.
    Cycle,
    /// So many exponents zero (two or more), the others negative.
    Torus(usize),
    /// One exponent positive, and none beside it shown to be.
    Chaos,
    /// So many exponents shown to be positive (two or more).
    HyperChaos(usize),
    /// Some exponent that matters is doubtful, or too few are known.
    Undecided,
}

impl std::fmt::Display for Attractor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Rest => f.write_str("rest, or in step with a drive"),
            Self::Cycle => f.write_str("limit cycle"),
            Self::Torus(tones) => write!(f, "torus of {tones} tones"),
            Self::Chaos => f.write_str("chaos"),
            Self::HyperChaos(_) => f.write_str("hyper-chaos"),
            Self::Undecided => f.write_str("undecided"),
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
        } else if exponent.half_width <= self.resolution && exponent.half_width.is_finite() {
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

    /// What the motion comes to. An exponent counts as positive only if its whole interval is; so a
    /// motion is called hyper-chaotic only if two are.
    pub fn attractor(&self) -> Attractor {
        let positive = self.count(Sign::Positive);
        if positive > 0 {
            return match positive {
                1 => Attractor::Chaos,
                more => Attractor::HyperChaos(more),
            };
        }
        let zero = self.count(Sign::Zero);
        // Those not followed are at or below the last one followed.
        let known = self.exponents.len() >= self.dimension || self.count(Sign::Negative) > 0;
        if !known || self.exponents.is_empty() || self.count(Sign::Doubtful) > 0 {
            return Attractor::Undecided;
        }
        match zero {
            0 => Attractor::Rest,
            1 => Attractor::Cycle,
            more => Attractor::Torus(more),
        }
    }

    /// The Kaplan-Yorke dimension with its 95 % interval, a pure number: `k` and the sum of the
    /// first `k` exponents over the size of the next one, `k` being the most exponents whose sum is
    /// not negative; exponents that count as zero are taken as zero. `None` where too few exponents
    /// are known. (J. L. Kaplan and J. A. Yorke, Lecture Notes in Mathematics 730 (1979) 204-227.)
    pub fn kaplan_yorke(&self) -> Option<Exponent> {
        self.kaplan_yorke
    }

    /// Whether every interval reaches at most so far, `half_width` (1/s), to either side: time to
    /// stop.
    pub fn is_settled(&self, half_width: f64) -> bool {
        let mut exponents = self.exponents.iter();
        self.time > 0.0 && exponents.all(|exponent| exponent.half_width <= half_width)
    }

    /// The same per radian of a vibration: divided by a circular frequency `omega` (rad/s), by the
    /// first natural frequency as a rule; the time is then an angle, rad.
    pub fn divided_by(&self, omega: f64) -> Self {
        let divided = |exponent: &Exponent| Exponent {
            value: exponent.value / omega,
            half_width: exponent.half_width / omega,
        };
        Self {
            exponents: self.exponents.iter().map(divided).collect(),
            time: self.time * omega,
            dimension: self.dimension,
            resolution: self.resolution / omega,
            kaplan_yorke: self.kaplan_yorke,
        }
    }
}

/// The exponents by the growth up to earlier times, to see them settle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Convergence {
    /// Time averaged over, evenly spaced, s: at most 129 instants, the last one the present.
    pub times: Vec<f64>,
    /// For each of the exponents, its value at these times, 1/s.
    pub values: Vec<Vec<f64>>,
}

#[cfg(test)]
mod tests;
