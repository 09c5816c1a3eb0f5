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

use serde::Serialize;

use super::{Bases, Combination, Line};

/// Standard uncertainty of a line's frequency in bins, for naming lines of a motion that need not
/// be steady. A steady line is known far better; this covers tones that drift or are modulated
/// within the window: in a chaotic squeak at 5 degrees, 20 ms at a time, sums of two lines miss a
/// third by up to 0.4 bins.
pub const FREQUENCY_UNCERTAINTY: f64 = 0.25;

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

/// A spectral line with its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpectralLine {
    /// Frequency refined below a bin, Hz.
    #[serde(rename = "frequency_hz")]
    pub frequency: f64,
    /// Amplitude in the signal's unit (one-sided: a sine of amplitude A gives A).
    pub amplitude: f64,
    /// Name such as `f1`, `3 f1`, `f2 - 3 f1`; empty where nothing fits.
    pub label: String,
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

    /// By how much `line`, the `i`-th of those named, misses its name: its frequency less
    /// that of the combination, Hz. `None` where nothing fits.
    pub fn misfit(&self, i: usize, line: Line) -> Option<f64> {
        self.names[i].map(|name| line.frequency - self.bases.frequency(name))
    }

    /// The lines that were named, with their names.
    pub fn label(&self, lines: &[Line]) -> Vec<SpectralLine> {
        let named = lines.iter().zip(&self.names);
        let labelled = named.map(|(line, name)| SpectralLine {
            frequency: line.frequency,
            amplitude: line.amplitude,
            label: name.map_or_else(String::new, |name| name.to_string()),
        });
        labelled.collect()
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
#[path = "lines_tests.rs"]
mod tests;
