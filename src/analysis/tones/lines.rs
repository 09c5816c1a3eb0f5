//! Names for spectral lines: one fundamental and its harmonics, or two base frequencies and
//! their combinations.
//!
//! A periodic motion has lines at `n f1` only. A torus, seen through any nonlinearity, has lines
//! at `n f1 + m f2`, low orders strongest; the paper's 0.57 kHz is `f2 - 3 f1`. So a name is a
//! claim about the motion, and with enough combinations *any* frequency comes near one. Names are
//! therefore given only within the uncertainty of the frequencies, and every reading of the list
//! is weighed against chance:
//!
//! * A line at a random frequency would get a name of order `k` or less with a probability `p`
//!   of at most the share of the range that those combinations cover. A low order and a sharp
//!   frequency make `p` small. A base itself has no such evidence: it was picked to fit.
//! * The lines of a reading are joined as Fisher joins independent tests: for `N` lines at random
//!   frequencies, `S = -sum ln p` exceeds a value with probability `exp(-S) sum_{j<N} S^j / j!`
//!   at most.
//! * Many readings are tried. Bases are looked for among the lines, strong ones first; the second
//!   among the strongest of those that are no harmonics of the first. A place down either list
//!   makes chance ten times as likely to be held responsible (a Bonferroni correction whose
//!   weights sum to 1).
//!
//! The reading least owed to chance wins. Parsimony follows: a second base gives up its own
//! evidence and makes all other names cheaper, so it must explain lines that one base cannot;
//! and of the many pairs of bases that span the same lines, strong ones that keep the orders low
//! win.

use std::fmt;

use super::Line;

/// Highest harmonic `n f1` (or `m f2`) looked for.
const HIGHEST_HARMONIC: i32 = 30;

/// Highest order `|n| + |m|` of a combination of both bases looked for.
const HIGHEST_ORDER: i32 = 8;

/// How many lines are tried as first base, and for each how many at most as second.
const BASE_CANDIDATES: usize = 6;

/// Ratio of the weights of one place in the lists of candidates and the next.
const PREFERENCE: f64 = 10.0;

/// A second base has at least this share of the strongest line that the first leaves unnamed
/// (-6 dB): otherwise that line ought to be the base.
const SECOND_SHARE: f64 = 0.5;

/// A name that a line at a random frequency would get with more than this probability is none.
const EASIEST_NAME: f64 = 0.3;

/// Two bases are believed if chance does as well with at most this probability.
const SIGNIFICANCE: f64 = 0.05;

/// A line of this share of the strongest (-20 dB) is a tone in its own right: one base that does
/// not explain it is not believed.
const STRONG: f64 = 0.1;

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
                harmonics
                    .chain(second)
                    .chain(mixed(HIGHEST_ORDER))
                    .collect()
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
        let frequencies = mixed(4).map(|c| self.frequency(c));
        frequencies.filter(|&f| f > 0.0).min_by(f64::total_cmp)
    }
}

/// The combinations of both bases up to an order, of either sign.
fn mixed(order: i32) -> impl Iterator<Item = Combination> {
    let all =
        (-order..=order).flat_map(move |n| (-order..=order).map(move |m| Combination { n, m }));
    all.filter(move |c| c.is_mixed() && c.order() <= order)
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

    /// Whether to tell it. One base must explain every strong line. A second base must be strong
    /// or explain a line besides its own; and two bases must explain more than chance would, or
    /// be all there is.
    fn is_believable(&self, lines: &[Line]) -> bool {
        let strong = |line: &Line| line.amplitude >= STRONG * lines[0].amplitude;
        let named = || lines.iter().zip(&self.names);
        match self.bases {
            Bases::None => false,
            Bases::One { .. } => named().all(|(line, name)| name.is_some() || !strong(line)),
            Bases::Two { .. } => {
                let supports = |(line, name): (&Line, &Option<Combination>)| {
                    name.is_some_and(|c| c.m != 0 && (c.order() > 1 || strong(line)))
                };
                named().any(supports) && (self.chance <= SIGNIFICANCE || lines.len() == 2)
            }
        }
    }
}

/// Names `lines` (strongest first), whose frequencies have the given standard `uncertainty`, Hz.
///
/// Of two bases the stronger is `f1`. A line farther from each combination than the three
/// uncertainties allow (added in squares) gets no name. See the module for how one is chosen.
pub fn name_lines(lines: &[Line], uncertainty: f64) -> Naming {
    // Of lines of like strength the lower is the likelier base: an octave counts as 1.5 dB.
    let weight = |i: usize| lines[i].amplitude / lines[i].frequency.powf(0.25);
    let mut ranking: Vec<usize> = (0..lines.len()).collect();
    ranking.sort_by(|&i, &j| weight(j).total_cmp(&weight(i)));

    let mut best = Naming::none(lines.len());
    let mut consider = |reading: Naming| {
        // The first of equals stays: one base before two, the likelier before the others.
        let better = best.bases == Bases::None || reading.chance < best.chance;
        if better && reading.is_believable(lines) {
            best = reading;
        }
    };
    for (place, &i) in ranking.iter().take(BASE_CANDIDATES).enumerate() {
        let one = Bases::One {
            f1: lines[i].frequency,
        };
        // Half of all weight goes to one base, half to two.
        let first = 2.0 * price(place);
        let single = read(lines, one, uncertainty, first);
        let unnamed = |j: &&usize| single.names[**j].is_none();
        let rest: Vec<usize> = ranking.iter().filter(unnamed).copied().collect();
        consider(single);
        let strong = |j: &&usize| weight(**j) >= SECOND_SHARE * weight(rest[0]);
        let seconds = rest.iter().filter(strong).take(BASE_CANDIDATES);
        for (place, &j) in seconds.enumerate() {
            let two = Bases::Two {
                f1: lines[i.min(j)].frequency,
                f2: lines[i.max(j)].frequency,
            };
            consider(read(lines, two, uncertainty, first * price(place)));
        }
    }
    best
}

/// What a place in a list of candidates costs: the inverse of its weight, all weights summing to 1.
fn price(place: usize) -> f64 {
    PREFERENCE.powi(place as i32 + 1) / (PREFERENCE - 1.0)
}

/// Reads the lines with the given bases, whose chance is multiplied by `price`.
fn read(lines: &[Line], bases: Bases, uncertainty: f64, price: f64) -> Naming {
    let top = lines.iter().map(|line| line.frequency).fold(0.0, f64::max);
    let usable = easiness(bases, uncertainty, top);
    let fit = |line: &Line| {
        usable
            .iter()
            .find(|(c, _)| (bases.frequency(*c) - line.frequency).abs() <= c.tolerance(uncertainty))
    };
    let fits: Vec<_> = lines.iter().map(fit).collect();
    // The bases fit themselves and are no evidence.
    let evidence = fits
        .iter()
        .flatten()
        .filter(|(c, _)| c.order() > 1)
        .map(|(_, p)| -p.ln());
    let chance = price * fisher_tail(evidence.sum(), lines.len() - bases.count());
    Naming {
        bases,
        names: fits.into_iter().map(|fit| fit.map(|(c, _)| *c)).collect(),
        chance: chance.min(1.0),
    }
}

/// The combinations that can be names, lowest order first, each with the share of the
/// frequencies up to `top` that lie within the tolerance of one of its order or less.
fn easiness(bases: Bases, uncertainty: f64, top: f64) -> Vec<(Combination, f64)> {
    let mut all = bases.combinations();
    all.retain(|&c| bases.frequency(c) <= top + c.tolerance(uncertainty));
    let mut covered = 0.0;
    let mut usable = Vec::with_capacity(all.len());
    for order in all.chunk_by(|a, b| a.order() == b.order()) {
        covered += order
            .iter()
            .map(|c| 2.0 * c.tolerance(uncertainty) / top)
            .sum::<f64>();
        if covered > EASIEST_NAME {
            break;
        }
        usable.extend(order.iter().map(|&c| (c, covered)));
    }
    usable
}

/// The probability that the sum of `count` exponential variables of mean 1 exceeds `sum`: that of
/// `-ln p` of as many independent tests (Fisher 1925).
fn fisher_tail(sum: f64, count: usize) -> f64 {
    let mut term = (-sum).exp();
    let mut tail = 0.0;
    for j in 1..=count {
        tail += term;
        term *= sum / j as f64;
    }
    if count == 0 { 1.0 } else { tail }
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
            let list = lines(&[
                (4100.0, 1.0),
                (8200.0, 0.5),
                (16_400.0, 0.3),
                (12_300.0 + miss, 0.02),
            ]);
            assert_eq!(labels(&name_lines(&list, UNCERTAINTY))[3], label);
        }
    }

    /// A quarter of a bin of a 20 ms window, as the pipeline has it.
    const QUARTER_BIN: f64 = 12.5;

    #[test]
    fn the_scene_periodic_2deg_has_one_base() {
        // 20 ms, settled; amplitudes in mm/s.
        let list = lines(&[
            (4110.8, 15.776),
            (12_332.5, 5.857),
            (8221.7, 1.435),
            (16_443.3, 0.9702),
            (20_554.2, 0.5379),
            (24_665.0, 0.1653),
            (32_886.6, 0.1222),
            (36_997.5, 0.0990),
            (41_108.3, 0.0613),
            (28_775.8, 0.0609),
            (45_219.1, 0.0327),
            (57_551.6, 0.0264),
        ]);
        let orders = [1, 3, 2, 4, 5, 6, 8, 9, 10, 7, 11, 14];
        let expected = orders.map(|n| Combination { n, m: 0 }.to_string());
        for uncertainty in [1.0, UNCERTAINTY, QUARTER_BIN] {
            assert_eq!(labels(&name_lines(&list, uncertainty)), expected);
        }
    }

    #[test]
    fn modes_that_grow_side_by_side_have_no_pattern() {
        // The same scene after 10 ms: four natural frequencies.
        let list = lines(&[
            (4097.3, 1.0388),
            (7539.5, 1.0375),
            (1743.4, 0.1237),
            (12_444.2, 0.1105),
        ]);
        let naming = name_lines(&list, 2.0 * QUARTER_BIN);
        assert_eq!(naming.bases, Bases::None);
    }

    #[test]
    fn names_of_the_scene_torus_3deg_stay() {
        // 20 ms at 145 ms and at 150 ms; in the second the lines miss their sums by up to 7 Hz.
        let earlier = [
            (4112.6, 15.9284),
            (12_338.7, 6.0999),
            (7988.0, 2.5355),
            (3872.6, 2.3190),
            (12_100.1, 1.4222),
            (16_451.5, 1.0878),
            (8227.6, 1.0495),
            (12_579.1, 1.0079),
            (7750.2, 0.6414),
            (20_564.0, 0.4875),
            (4590.4, 0.3416),
            (24_441.2, 0.2272),
        ];
        let later = [
            (4113.3, 15.8812),
            (12_338.7, 6.1369),
            (7986.5, 2.6084),
            (3876.3, 2.4304),
            (12_100.0, 1.4497),
            (16_451.7, 1.0830),
            (8224.9, 1.0664),
            (7755.3, 0.6759),
            (20_565.3, 0.4813),
            (4587.8, 0.3569),
            (24_437.5, 0.2336),
            (16_204.6, 0.2050),
        ];
        let common = ["f1", "3 f1", "f1 + f2", "f2", "2 f1 + f2", "4 f1", "2 f1"];
        let named = |list| labels(&name_lines(&lines(list), QUARTER_BIN));
        let (earlier, later) = (named(&earlier), named(&later));
        assert_eq!(earlier[..7], common);
        assert_eq!(later[..7], common);
        let rest = ["4 f1 - f2", "2 f2", "5 f1", "3 f1 - 2 f2", "5 f1 + f2"];
        assert_eq!(earlier[7..], rest);
        let rest = ["2 f2", "5 f1", "3 f1 - 2 f2", "5 f1 + f2", "3 f1 + f2"];
        assert_eq!(later[7..], rest);
    }

    #[test]
    fn names_of_the_scene_chaos_5deg_stay() {
        // 20 ms at 35 ms and at 45 ms, the strongest lines; f1 + f2 is missed by 10 and by 20 Hz.
        let earlier = [
            (4120.2, 15.7631),
            (12_359.6, 5.8589),
            (7996.3, 3.2460),
            (3885.7, 3.0009),
            (12_125.1, 2.1305),
            (12_594.6, 1.1174),
        ];
        let later = [
            (4121.2, 15.3612),
            (12_359.3, 6.0820),
            (8007.6, 2.9609),
            (3906.5, 3.0996),
            (12_142.6, 2.0726),
            (12_575.4, 1.2702),
        ];
        for list in [earlier, later] {
            let names = labels(&name_lines(&lines(&list), QUARTER_BIN));
            let expected = ["f1", "3 f1", "f1 + f2", "f2", "2 f1 + f2", "4 f1 - f2"];
            assert_eq!(names, expected);
        }
    }

    #[test]
    fn a_faint_second_tone_has_the_name_that_it_keeps() {
        // The scene tilt-ramp, 50 ms, just as the torus is born: f1 + f2 is stronger than f2.
        let list = lines(&[
            (4105.7, 16.3691),
            (12_316.8, 6.0429),
            (8213.6, 1.4425),
            (16_422.6, 1.2332),
            (20_528.9, 0.6500),
            (7965.5, 0.3556),
            (3858.5, 0.3091),
            (12_072.3, 0.1815),
            (24_636.6, 0.1687),
            (32_844.3, 0.1494),
        ]);
        let names = labels(&name_lines(&list, UNCERTAINTY));
        assert_eq!(names[..5], ["f1", "3 f1", "2 f1", "4 f1", "5 f1"]);
        assert_eq!(names[5..], ["f1 + f2", "f2", "2 f1 + f2", "6 f1", "8 f1"]);
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
        assert!(
            f64::from(believed) <= SIGNIFICANCE * f64::from(trials),
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
    fn tail_of_the_joint_evidence() {
        assert_eq!(fisher_tail(0.0, 0), 1.0);
        assert_eq!(fisher_tail(0.0, 5), 1.0);
        assert!((fisher_tail(3.0, 1) - (-3.0_f64).exp()).abs() < 1e-16);
        // Two tests at 5 % each: 0.0025 (1 - ln 0.0025).
        let sum = -2.0 * 0.05_f64.ln();
        assert!((fisher_tail(sum, 2) - 0.0025 * (1.0 - 0.0025_f64.ln())).abs() < 1e-15);
    }
}
