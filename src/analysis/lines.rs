//! Names for spectral lines: one fundamental and its harmonics, or two base frequencies and
//! their combinations.
//!
//! A periodic motion has lines at `n f1` only. A torus, seen through any nonlinearity, has lines
//! at `n f1 + m f2`, low orders strongest; the paper's 0.57 kHz is `f2 - 3 f1`. So a name is a
//! claim about the motion, and with enough combinations *any* frequency comes near one. Names are
//! therefore given only within the uncertainty of the frequencies, and a reading of the whole
//! list is believed only if it leaves nothing unexplained or if chance would hardly do as well.

use std::fmt;

use super::Line;

/// Highest harmonic `n f1` (or `m f2`) looked for.
const HIGHEST_HARMONIC: i32 = 10;

/// Highest order `|n| + |m|` of a combination of both bases looked for.
const HIGHEST_ORDER: i32 = 5;

/// How many of the strongest lines are tried as base frequencies.
const BASE_CANDIDATES: usize = 6;

/// A reading is believed if chance does as well with at most this probability.
const SIGNIFICANCE: f64 = 0.05;

/// A line that only explains itself is a second base if it has this share of the first's
/// amplitude (-20 dB): a tone in its own right.
const STRONG_SECOND: f64 = 0.1;

/// `n f1 + m f2`. Displays as `f1`, `3 f1`, `f2 - 3 f1`, ...
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Combination {
    /// Multiple of the first base.
    pub n: i32,
    /// Multiple of the second base.
    pub m: i32,
}

impl Combination {
    /// `|n| + |m|`.
    pub fn order(self) -> i32 {
        self.n.abs() + self.m.abs()
    }

    /// Whether both bases take part.
    pub fn is_mixed(self) -> bool {
        self.n != 0 && self.m != 0
    }

    /// By how much `n f1 + m f2` may miss a line if each of the three frequencies has the given
    /// standard uncertainty.
    fn tolerance(self, uncertainty: f64) -> f64 {
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

/// The base frequencies of a list of lines, Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bases {
    /// No simple pattern, or no line.
    None,
    /// One fundamental: `n f1`.
    One {
        /// The fundamental.
        f1: f64,
    },
    /// Two base frequencies, the first the stronger: `n f1 + m f2`.
    Two {
        /// The first base.
        f1: f64,
        /// The second base.
        f2: f64,
    },
}

impl Bases {
    /// How many there are.
    fn count(self) -> usize {
        match self {
            Bases::None => 0,
            Bases::One { .. } => 1,
            Bases::Two { .. } => 2,
        }
    }

    /// The frequency of a combination.
    pub fn frequency(self, name: Combination) -> f64 {
        match self {
            Bases::None => 0.0,
            Bases::One { f1 } => f64::from(name.n) * f1,
            Bases::Two { f1, f2 } => f64::from(name.n) * f1 + f64::from(name.m) * f2,
        }
    }

    /// The combinations looked for, those of positive frequency, lowest order first.
    fn combinations(self) -> Vec<Combination> {
        let harmonics = (1..=HIGHEST_HARMONIC).map(|n| Combination { n, m: 0 });
        let mut all: Vec<Combination> = match self {
            Bases::None => Vec::new(),
            Bases::One { .. } => harmonics.collect(),
            Bases::Two { .. } => {
                let second = (1..=HIGHEST_HARMONIC).map(|m| Combination { n: 0, m });
                let range = -HIGHEST_ORDER..=HIGHEST_ORDER;
                let mixed = range
                    .clone()
                    .flat_map(|n| range.clone().map(move |m| Combination { n, m }));
                let low = mixed.filter(|c| c.is_mixed() && c.order() <= HIGHEST_ORDER);
                harmonics.chain(second).chain(low).collect()
            }
        };
        all.retain(|&c| self.frequency(c) > 0.0);
        all.sort_by_key(|c| c.order());
        all
    }

    /// The lowest difference frequency `|n f1 + m f2|` of combinations up to order four: the beat
    /// that the ear and the envelope follow. `None` unless there are two bases.
    pub fn beat(self) -> Option<f64> {
        let Bases::Two { .. } = self else { return None };
        let mixed = self
            .combinations()
            .into_iter()
            .filter(|c| c.is_mixed() && c.order() <= 4);
        mixed.map(|c| self.frequency(c)).min_by(f64::total_cmp)
    }
}

/// How a list of lines reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Naming {
    /// The base frequencies.
    pub bases: Bases,
    /// The name of each line, in the order given; `None` where nothing fits.
    pub names: Vec<Option<Combination>>,
    /// An upper bound of the probability that lines at random frequencies would be explained as
    /// well by bases chosen among them; 1 where the bases explain no line but themselves.
    pub chance: f64,
}

impl Naming {
    /// No pattern among `count` lines.
    fn none(count: usize) -> Self {
        Self {
            bases: Bases::None,
            names: vec![None; count],
            chance: 1.0,
        }
    }

    /// How many lines have a name.
    pub fn explained(&self) -> usize {
        self.names.iter().flatten().count()
    }

    /// Whether no line lacks a name, or chance is unlikely to have given them.
    fn is_believable(&self) -> bool {
        self.explained() == self.names.len() || self.chance <= SIGNIFICANCE
    }
}

/// Names `lines` (strongest first), whose frequencies have the given standard `uncertainty`, Hz.
///
/// Bases are looked for among the strongest lines themselves. The reading that explains more
/// lines wins, the one of the stronger bases among equals. Two bases are preferred to one if the second
/// explains a line besides its own, or is strong (-20 dB of the first or more). A line farther
/// from each combination than the three uncertainties allow (added in squares) gets no name.
pub fn name_lines(lines: &[Line], uncertainty: f64) -> Naming {
    let candidates = lines.len().min(BASE_CANDIDATES);
    let f = |i: usize| lines[i].frequency;
    let singles = (0..candidates).map(|i| Bases::One { f1: f(i) });
    let pairs = (0..candidates)
        .flat_map(|i| (i + 1..candidates).map(move |j| (i, j)))
        .map(|(i, j)| Bases::Two { f1: f(i), f2: f(j) });
    let one = best(lines, singles.collect(), uncertainty);
    let two = best(lines, pairs.collect(), uncertainty);
    match (one, two) {
        (None, None) => Naming::none(lines.len()),
        (Some(one), None) => one,
        (None, Some(two)) => two,
        (Some(one), Some(two)) => {
            let gain = two.explained().saturating_sub(one.explained());
            if gain >= 2 || (gain == 1 && second_is_strong(lines, two.bases)) {
                two
            } else {
                one
            }
        }
    }
}

/// The best believable reading among the given bases.
fn best(lines: &[Line], bases: Vec<Bases>, uncertainty: f64) -> Option<Naming> {
    let tried = bases.len();
    let readings = bases
        .into_iter()
        .map(|b| read(lines, b, uncertainty, tried));
    // The first of equals stays: bases come strongest first.
    let better = |a: Naming, b: Naming| if b.explained() > a.explained() { b } else { a };
    readings.reduce(better).filter(Naming::is_believable)
}

/// Reads the lines with the given bases, one choice among `tried`.
fn read(lines: &[Line], bases: Bases, uncertainty: f64, tried: usize) -> Naming {
    let combinations = bases.combinations();
    let name = |line: &Line| {
        let fits = combinations
            .iter()
            .filter(|c| (bases.frequency(**c) - line.frequency).abs() <= c.tolerance(uncertainty));
        fits.copied().min_by_key(|c| c.order())
    };
    let names: Vec<Option<Combination>> = lines.iter().map(name).collect();

    // A random line falls within the tolerance of some combination with at most this probability.
    let top = lines.iter().map(|line| line.frequency).fold(0.0, f64::max);
    let within = combinations.iter().filter(|c| bases.frequency(**c) <= top);
    let covered: f64 = within.map(|c| 2.0 * c.tolerance(uncertainty)).sum();
    let others = lines.len() - bases.count();
    let hits = names.iter().flatten().count() - bases.count();
    let chance = tried as f64 * at_least(hits, others, (covered / top).min(1.0));
    Naming {
        bases,
        names,
        chance: chance.min(1.0),
    }
}

/// Whether the second base has a tenth of the first's amplitude.
fn second_is_strong(lines: &[Line], bases: Bases) -> bool {
    let amplitude = |f: f64| {
        lines
            .iter()
            .find(|line| line.frequency == f)
            .map(|line| line.amplitude)
    };
    match bases {
        Bases::Two { f1, f2 } => amplitude(f2) >= amplitude(f1).map(|a| STRONG_SECOND * a),
        Bases::None | Bases::One { .. } => false,
    }
}

/// The probability of at least `hits` successes in `trials` of probability `p`.
fn at_least(hits: usize, trials: usize, p: f64) -> f64 {
    let mut choose = 1.0;
    let mut below = 0.0;
    for k in 0..hits {
        below += choose * p.powi(k as i32) * (1.0 - p).powi((trials - k) as i32);
        choose *= (trials - k) as f64 / (k + 1) as f64;
    }
    1.0 - below
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A tenth of a 50 Hz bin.
    const UNCERTAINTY: f64 = 5.0;

    fn lines(list: &[(f64, f64)]) -> Vec<Line> {
        let line = |&(frequency, amplitude)| Line {
            frequency,
            amplitude,
        };
        list.iter().map(line).collect()
    }

    fn labels(naming: &Naming) -> Vec<String> {
        let label = |name: &Option<Combination>| name.map_or(String::new(), |c| c.to_string());
        naming.names.iter().map(label).collect()
    }

    #[test]
    fn names_read_as_one_writes_them() {
        let text = |n, m| Combination { n, m }.to_string();
        assert_eq!(text(1, 0), "f1");
        assert_eq!(text(3, 0), "3 f1");
        assert_eq!(text(0, 2), "2 f2");
        assert_eq!(text(-3, 1), "f2 - 3 f1");
        assert_eq!(text(2, -1), "2 f1 - f2");
        assert_eq!(text(1, 1), "f1 + f2");
    }

    #[test]
    fn a_lone_line_is_the_fundamental() {
        let naming = name_lines(&lines(&[(4100.0, 1.0)]), UNCERTAINTY);
        assert_eq!(naming.bases, Bases::One { f1: 4100.0 });
        assert_eq!(labels(&naming), ["f1"]);
        assert_eq!(naming.bases.beat(), None);
    }

    #[test]
    fn harmonics_of_the_limit_cycle() {
        // 2 degrees, azimuth 0: 4.117 kHz, 12.33 at 0.13, 8.22 at 0.05.
        let list = lines(&[(4117.0, 1.0), (12_351.5, 0.13), (8233.0, 0.05)]);
        let naming = name_lines(&list, UNCERTAINTY);
        assert_eq!(labels(&naming), ["f1", "3 f1", "2 f1"]);
    }

    #[test]
    fn a_weak_fundamental_below_the_strongest_line_is_found() {
        // The locked 1:2 tone: 2.07 kHz weaker than its octave.
        let list = lines(&[(4140.0, 1.0), (2070.0, 0.4), (6210.0, 0.1), (8280.0, 0.05)]);
        let naming = name_lines(&list, UNCERTAINTY);
        assert_eq!(naming.bases, Bases::One { f1: 2070.0 });
        assert_eq!(labels(&naming), ["2 f1", "f1", "3 f1", "4 f1"]);
    }

    #[test]
    fn torus_of_the_natural_set() {
        let list = lines(&[(4110.0, 15.0), (3870.0, 4.0), (12_331.0, 2.0), (241.0, 0.1)]);
        let naming = name_lines(&list, UNCERTAINTY);
        assert_eq!(labels(&naming), ["f1", "f2", "3 f1", "f1 - f2"]);
        assert!((naming.bases.beat().unwrap() - 240.0).abs() < 1e-9);
    }

    #[test]
    fn torus_of_the_paper() {
        // Fig. 6: 0.57 = f2 - 3 f1 of 3.87 and 12.18 kHz; and the side lines that go with it.
        let list = lines(&[
            (3870.0, 1.0),
            (12_180.0, 0.8),
            (570.0, 0.2),
            (4440.0, 0.1),
            (11_610.0, 0.05),
        ]);
        let naming = name_lines(&list, UNCERTAINTY);
        assert_eq!(
            labels(&naming),
            ["f1", "f2", "f2 - 3 f1", "f2 - 2 f1", "3 f1"]
        );
        assert!(naming.chance < SIGNIFICANCE, "{}", naming.chance);
        assert!((naming.bases.beat().unwrap() - 570.0).abs() < 1e-9);
    }

    #[test]
    fn a_strong_second_tone_without_combinations_is_a_base() {
        let naming = name_lines(&lines(&[(4100.0, 1.0), (12_900.0, 0.5)]), UNCERTAINTY);
        assert_eq!(labels(&naming), ["f1", "f2"]);
        assert_eq!(naming.chance, 1.0);
    }

    #[test]
    fn a_weak_stray_line_stays_without_a_name() {
        let list = lines(&[
            (4100.0, 1.0),
            (8200.0, 0.3),
            (12_300.0, 0.1),
            (9713.0, 0.002),
        ]);
        let naming = name_lines(&list, UNCERTAINTY);
        assert_eq!(labels(&naming), ["f1", "2 f1", "3 f1", ""]);
    }

    #[test]
    fn a_line_outside_the_uncertainty_is_not_named() {
        // 3 f1 may miss by 5 sqrt(10) = 15.8 Hz.
        for (miss, label) in [(15.0, "3 f1"), (17.0, "")] {
            let list = lines(&[(4100.0, 1.0), (8200.0, 0.5), (12_300.0 + miss, 0.02)]);
            assert_eq!(labels(&name_lines(&list, UNCERTAINTY))[2], label);
        }
    }

    #[test]
    fn random_lines_are_seldom_believed() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let trials = 400;
        let mut believed = 0;
        for _ in 0..trials {
            let list: Vec<(f64, f64)> = (0..8)
                .map(|_| (rng.random_range(200.0..13_000.0), 1.0))
                .collect();
            if name_lines(&lines(&list), UNCERTAINTY).bases != Bases::None {
                believed += 1;
            }
        }
        // Two tests (one base, two bases) at 5 % each.
        assert!(
            f64::from(believed) <= 0.1 * f64::from(trials),
            "{believed} of {trials}"
        );
    }

    #[test]
    fn no_lines_no_names() {
        let naming = name_lines(&[], UNCERTAINTY);
        assert_eq!(naming.bases, Bases::None);
        assert!(naming.names.is_empty());
    }

    #[test]
    fn binomial_tail() {
        assert_eq!(at_least(0, 5, 0.3), 1.0);
        assert!((at_least(2, 3, 0.5) - 0.5).abs() < 1e-15);
        assert!((at_least(3, 3, 0.1) - 1e-3).abs() < 1e-15);
    }
}
