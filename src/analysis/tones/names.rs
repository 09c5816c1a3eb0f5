//! Names of spectral lines: combinations of one or two base frequencies.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Maximum harmonic number `n` of `n f1` (or `m` of `m f2`).
const MAX_HARMONIC: i32 = 30;

/// Maximum order `|n| + |m|` of a combination of both bases.
const MAX_ORDER: i32 = 8;

/// The combination frequency `n f1 + m f2`. Displays as `f1`, `3 f1`, `f2 - 3 f1`, ...
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Combination {
    /// Multiple of the first base.
    pub n: i32,
    /// Multiple of the second base.
    pub m: i32,
}

impl Combination {
    /// Order `|n| + |m|`.
    pub fn order(self) -> i32 {
        self.n.abs() + self.m.abs()
    }

    /// Whether both bases contribute.
    pub fn is_mixed(self) -> bool {
        self.n != 0 && self.m != 0
    }

    /// Tolerance of `n f1 + m f2` against a line if each of the three frequencies has the given standard
    /// uncertainty.
    pub(super) fn tolerance(self, uncertainty: f64) -> f64 {
        uncertainty * f64::from(1 + self.n * self.n + self.m * self.m).sqrt()
    }
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let term = |count: i32, base: &str| match count.abs() {
            1 => base.to_owned(),
            many => format!("{many} {base}"),
        };
        let (one, two) = (term(self.n, "f1"), term(self.m, "f2"));
        match (self.n, self.m) {
            (_, 0) => f.write_str(&one),
            (0, _) => f.write_str(&two),
            (1.., 1..) => write!(f, "{one} + {two}"),
            (1.., _) => write!(f, "{one} - {two}"),
            _ => write!(f, "{two} - {one}"),
        }
    }
}

/// Base frequencies of a list of lines, Hz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
}

impl Bases {
    /// Number of bases.
    pub(super) fn count(self) -> usize {
        match self {
            Bases::None => 0,
            Bases::One { .. } => 1,
            Bases::Two { .. } => 2,
        }
    }

    /// Frequency of a combination, Hz.
    pub fn frequency(self, name: Combination) -> f64 {
        match self {
            Bases::None => 0.0,
            Bases::One { f1 } => f64::from(name.n) * f1,
            Bases::Two { f1, f2 } => f64::from(name.n) * f1 + f64::from(name.m) * f2,
        }
    }

    /// Combinations considered, with positive frequency, lowest order first.
    pub(super) fn combinations(self) -> Vec<Combination> {
        let harmonics = (1..=MAX_HARMONIC).map(|n| Combination { n, m: 0 });
        let mut all: Vec<Combination> = match self {
            Bases::None => Vec::new(),
            Bases::One { .. } => harmonics.collect(),
            Bases::Two { .. } => {
                let second = (1..=MAX_HARMONIC).map(|m| Combination { n: 0, m });
                harmonics.chain(second).chain(mixed(MAX_ORDER)).collect()
            }
        };
        all.retain(|&c| self.frequency(c) > 0.0);
        all.sort_by_key(|c| c.order());
        all
    }

    /// Beat frequency, Hz: the lowest difference frequency `|n f1 + m f2|` of combinations up to order
    /// four, which is audible and visible in the envelope. `None` unless there are two bases.
    pub fn beat(self) -> Option<f64> {
        let Bases::Two { .. } = self else { return None };
        let frequencies = mixed(4).map(|c| self.frequency(c));
        frequencies.filter(|&f| f > 0.0).min_by(f64::total_cmp)
    }
}

/// Combinations of both bases up to an order, of either sign.
fn mixed(order: i32) -> impl Iterator<Item = Combination> {
    let all =
        (-order..=order).flat_map(move |n| (-order..=order).map(move |m| Combination { n, m }));
    all.filter(move |c| c.is_mixed() && c.order() <= order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combinations_display_in_the_usual_form() {
        let text = |n, m| Combination { n, m }.to_string();
        assert_eq!(text(1, 0), "f1");
        assert_eq!(text(3, 0), "3 f1");
        assert_eq!(text(0, 2), "2 f2");
        assert_eq!(text(-3, 1), "f2 - 3 f1");
        assert_eq!(text(2, -1), "2 f1 - f2");
        assert_eq!(text(1, 1), "f1 + f2");
    }
}
