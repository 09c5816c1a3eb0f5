//! Names of spectral lines: combinations of one or two base frequencies.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

/// Maximum harmonic number `n` of `n f1` (or `m` of `m f2`).
const MAX_HARMONIC: i32 = 30;

/// Maximum order `|n| + |m|` of a combination of both bases.
const MAX_ORDER: i32 = 8;

/// The combination frequency `(n f1 + m f2) / divisor`. Displays as `f1`, `3 f1`, `f2 - 3 f1`,
/// `(f1 + f2)/2`, ...
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Combination {
    /// Multiple of the first base.
    pub n: i32,
    /// Multiple of the second base.
    pub m: i32,
    /// Common divisor: 1, or 2 or 4 for a line of a doubled motion.
    #[serde(skip_serializing_if = "is_one")]
    pub divisor: i32,
}

fn is_one(divisor: &i32) -> bool {
    *divisor == 1
}

impl Combination {
    /// The combination `n f1 + m f2`.
    pub const fn new(n: i32, m: i32) -> Self {
        Self { n, m, divisor: 1 }
    }

    /// The combination `(n f1 + m f2) / divisor` in lowest terms, for a divisor of any sign but 0.
    pub(super) fn reduced(n: i32, m: i32, divisor: i32) -> Self {
        let common = gcd(gcd(n, m), divisor) * divisor.signum();
        Self {
            n: n / common,
            m: m / common,
            divisor: divisor / common,
        }
    }

    /// Order `|n| + |m|`.
    pub fn order(self) -> i32 {
        self.n.abs() + self.m.abs()
    }

    /// Whether both bases contribute.
    pub fn is_mixed(self) -> bool {
        self.n != 0 && self.m != 0
    }

    /// Whether the order is at most twice that of the combinations that are searched: other bases of the
    /// same lines have combinations of a higher order.
    pub(super) fn is_credible(&self) -> bool {
        self.order() <= 2 * MAX_ORDER * self.divisor
    }

    /// Tolerance of the combination against a line if each of the three frequencies has the given
    /// standard uncertainty.
    pub(super) fn tolerance(self, uncertainty: f64) -> f64 {
        let [n, m, divisor] = [self.n, self.m, self.divisor].map(f64::from);
        uncertainty * (1.0 + (n * n + m * m) / (divisor * divisor)).sqrt()
    }
}

/// Greatest common divisor, at least 0.
pub(super) fn gcd(a: i32, b: i32) -> i32 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Combination {
    /// The combination in the symbols of the bases.
    pub(super) fn text(self, [one, two]: [&str; 2]) -> String {
        let term = |count: i32, base: &str| match count.abs() {
            1 => base.to_owned(),
            many => format!("{many} {base}"),
        };
        let (one, two) = (term(self.n, one), term(self.m, two));
        let sum = match (self.n, self.m) {
            (_, 0) => one,
            (0, _) => two,
            (1.., 1..) => format!("{one} + {two}"),
            (1.., _) => format!("{one} - {two}"),
            _ => format!("{two} - {one}"),
        };
        match self.divisor {
            1 => sum,
            divisor if self.is_mixed() => format!("({sum})/{divisor}"),
            divisor => format!("{sum}/{divisor}"),
        }
    }
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(["f1", "f2"]))
    }
}

/// Base frequencies of a list of lines, Hz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "bases", rename_all = "kebab-case")]
pub enum Bases {
    /// No simple pattern, or no line.
    None,
    /// One fundamental: `n f1`.
    One {
        /// Fundamental, Hz.
        #[serde(rename = "f1_hz")]
        f1: f64,
    },
    /// Two base frequencies, the first the stronger: `n f1 + m f2`.
    Two {
        /// First base, Hz.
        #[serde(rename = "f1_hz")]
        f1: f64,
        /// Second base, Hz.
        #[serde(rename = "f2_hz")]
        f2: f64,
    },
    /// One tone with sidebands in symmetric pairs, `n f1 ± m fm`: a tone whose amplitude or frequency is
    /// modulated. The spectrum does not tell whether the modulation is a motion of its own, as on a
    /// torus.
    Modulated {
        /// Frequency of the carrier, Hz.
        #[serde(rename = "f1_hz")]
        f1: f64,
        /// Modulation frequency, Hz.
        #[serde(rename = "fm_hz")]
        fm: f64,
    },
}

impl Bases {
    /// The bases of named lines; `frequency` is the frequency (Hz) of the line with a name.
    pub fn of_names(frequency: impl Fn(&str) -> Option<f64>) -> Self {
        let sideband = || frequency("f1 + fm").or_else(|| frequency("f1 - fm"));
        match (frequency("f1"), frequency("f2"), sideband()) {
            (None, ..) => Bases::None,
            (Some(f1), Some(f2), _) => Bases::Two { f1, f2 },
            (Some(f1), None, Some(f)) => Bases::Modulated {
                f1,
                fm: (f - f1).abs(),
            },
            (Some(f1), None, None) => Bases::One { f1 },
        }
    }

    /// Number of bases.
    pub(super) fn count(self) -> usize {
        match self {
            Bases::None => 0,
            Bases::One { .. } => 1,
            Bases::Two { .. } | Bases::Modulated { .. } => 2,
        }
    }

    /// Both bases, Hz; 0 for a missing one.
    pub(super) fn pair(self) -> [f64; 2] {
        match self {
            Bases::None => [0.0; 2],
            Bases::One { f1 } => [f1, 0.0],
            Bases::Two { f1, f2 } => [f1, f2],
            Bases::Modulated { f1, fm } => [f1, fm],
        }
    }

    /// Symbols of both bases.
    pub(super) fn symbols(self) -> [&'static str; 2] {
        match self {
            Bases::Modulated { .. } => ["f1", "fm"],
            _ => ["f1", "f2"],
        }
    }

    /// Frequency of a combination, Hz.
    pub fn frequency(self, name: Combination) -> f64 {
        let [f1, f2] = self.pair();
        (f64::from(name.n) * f1 + f64::from(name.m) * f2) / f64::from(name.divisor)
    }

    /// Combinations considered, with positive frequency, lowest order first. With a `parity`, those
    /// halves `(n f1 + m f2) / 2` of which `n` and `m` are odd or even as its components are.
    pub(super) fn combinations(self, parity: Option<[i32; 2]>) -> Vec<Combination> {
        let harmonics = (1..=MAX_HARMONIC).map(|n| Combination::new(n, 0));
        let mut all: Vec<Combination> = match self.count() {
            0 => Vec::new(),
            1 => harmonics.collect(),
            _ => {
                let second = (1..=MAX_HARMONIC).map(|m| Combination::new(0, m));
                harmonics.chain(second).chain(mixed(MAX_ORDER)).collect()
            }
        };
        if let Some([n, m]) = parity {
            all.retain(|c| (c.n - n) % 2 == 0 && (c.m - m) % 2 == 0);
            all.iter_mut().for_each(|c| c.divisor = 2);
        }
        all.retain(|&c| self.frequency(c) > 0.0);
        all.sort_by_key(|c| c.order());
        all
    }

    /// Beat frequency, Hz: the lowest difference frequency `|n f1 + m f2|` of combinations up to order
    /// four, which is audible and visible in the envelope; of a modulated tone, the modulation frequency.
    /// `None` unless there are two bases.
    pub fn beat(self) -> Option<f64> {
        match self {
            Bases::None | Bases::One { .. } => None,
            Bases::Modulated { fm, .. } => Some(fm),
            Bases::Two { .. } => {
                let frequencies = mixed(4).map(|c| self.frequency(c));
                frequencies.filter(|&f| f > 0.0).min_by(f64::total_cmp)
            }
        }
    }
}

/// Combinations of both bases up to an order, of either sign.
fn mixed(order: i32) -> impl Iterator<Item = Combination> {
    let all =
        (-order..=order).flat_map(move |n| (-order..=order).map(move |m| Combination::new(n, m)));
    all.filter(move |c| c.is_mixed() && c.order() <= order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combinations_display_in_the_usual_form() {
        let text = |n, m| Combination::new(n, m).text(["f1", "f2"]);
        assert_eq!(text(1, 0), "f1");
        assert_eq!(text(3, 0), "3 f1");
        assert_eq!(text(0, 2), "2 f2");
        assert_eq!(text(-3, 1), "f2 - 3 f1");
        assert_eq!(text(2, -1), "2 f1 - f2");
        assert_eq!(text(1, 1), "f1 + f2");
        let half = |n, m, divisor| Combination::reduced(n, m, divisor).text(["f1", "f2"]);
        assert_eq!(half(1, 1, 2), "(f1 + f2)/2");
        assert_eq!(half(-2, -2, -4), "(f1 + f2)/2");
        assert_eq!(half(-6, 2, 8), "(f2 - 3 f1)/4");
        assert_eq!(half(3, 0, 2), "3 f1/2");
        assert_eq!(half(6, -2, 2), "3 f1 - f2");
    }
}
