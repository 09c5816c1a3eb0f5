//! Eq. (23): Lyapunov exponents from the growth of tangent vectors.

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
    /// The exponents in falling order.
    pub exponents: Vec<Exponent>,
    /// Time over which growth was averaged, s.
    pub time: f64,
    /// Dimension of the tangent space: how many exponents there are in all.
    pub dimension: usize,
    /// An exponent nearer to zero than this cannot be told from zero in this time, 1/s.
    pub resolution: f64,
}

/// What a motion comes to, by its exponents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attractor {
    /// All exponents negative: it comes to rest.
    Rest,
    /// One exponent zero, the others negative: a limit cycle.
    Cycle,
    /// So many exponents zero (two or more), the others negative.
    Torus(usize),
    /// One exponent positive.
    Chaos,
    /// So many exponents positive (two or more).
    HyperChaos(usize),
    /// Some exponent that matters is doubtful, or too few are known.
    Undecided,
}

impl LyapunovSpectrum {
    /// What is known of the sign of exponent `k`.
    pub fn sign(&self, k: usize) -> Sign {
        let exponent = self.exponents[k];
        if exponent.low() > self.resolution {
            Sign::Positive
        } else if exponent.high() < -self.resolution {
            Sign::Negative
        } else if exponent.half_width <= self.resolution {
            Sign::Zero
        } else {
            Sign::Doubtful
        }
    }

    /// What the motion comes to.
    pub fn attractor(&self) -> Attractor {
        Attractor::Undecided
    }

    /// The Kaplan-Yorke dimension, with its 95 % interval; `None` where too few exponents are known.
    pub fn kaplan_yorke(&self) -> Option<Exponent> {
        None
    }
}

/// How tangent vectors have grown.
#[derive(Clone, Debug)]
pub(super) struct Growth {
    start: f64,
    last: f64,
    sums: Vec<f64>,
}

impl Growth {
    pub fn new(width: usize) -> Self {
        Self {
            start: 0.0,
            last: 0.0,
            sums: vec![0.0; width],
        }
    }

    /// Forgets all growth up to time `t` (s).
    pub fn clear(&mut self, t: f64) {
        self.start = t;
        self.last = t;
        self.sums.fill(0.0);
    }

    /// The time up to which growth is known, s.
    pub fn last(&self) -> f64 {
        self.last
    }

    /// Adds the logarithms of the growth of each vector since the last time, up to time `t` (s).
    pub fn push(&mut self, t: f64, logarithms: &[f64]) {
        self.last = t;
        for (sum, logarithm) in self.sums.iter_mut().zip(logarithms) {
            *sum += logarithm;
        }
    }

    /// Eq. (23): `lambda_i = lim 1/t ln |m_i(t)|`, by the growth so far.
    pub fn spectrum(&self, dimension: usize) -> LyapunovSpectrum {
        let time = self.last - self.start;
        LyapunovSpectrum {
            exponents: self
                .sums
                .iter()
                .map(|sum| Exponent {
                    value: sum / time,
                    half_width: f64::INFINITY,
                })
                .collect(),
            time,
            dimension,
            resolution: 0.0,
        }
    }
}
