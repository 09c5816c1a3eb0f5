//! Identification of spectral lines: one fundamental and its harmonics, or two base frequencies and
//! their combinations.
//!
//! A periodic motion has lines only at `n f1`. A torus, observed through a nonlinearity, has lines at
//! `n f1 + m f2`, strongest at low orders; the paper's 0.57 kHz is `f2 - 3 f1`. With enough
//! combinations, *any* frequency is close to one. Lines are therefore named only within the uncertainty
//! of the frequencies, and every reading of the list is tested against random lines:
//!
//! * The probability `p` that a line at a random frequency gets a name of order `k` or less is at most
//!   the share of the frequency range covered by those combinations. A low order and an accurate
//!   frequency make `p` small. A base frequency is no evidence because it was chosen to fit.
//! * The lines of a reading are combined by Fisher's method for independent tests. For `N` lines at
//!   random frequencies, `S = -sum ln p` exceeds a value with a probability of at most
//!   `exp(-S) sum_{j<N} S^j / j!`.
//! * Many readings are tried. Candidates for the bases are lines, strong ones first; the second base is
//!   one of the strongest lines that are not harmonics of the first. Each place down either list
//!   multiplies the p-value by ten (a Bonferroni correction with weights that sum to 1).
//!
//! The reading with the smallest p-value wins. This favours simple readings: a second base loses its own
//! evidence and makes all other names more probable by chance, so it must explain lines that one base
//! cannot. A base that is a harmonic of the other is no second base.
//!
//! The lines without a name are then compared with the halves of the combinations, where a doubling of the
//! motion adds lines. Finally the bases are chosen among the many that explain the same lines, see
//! `lattice.rs`.

use super::lattice::Lattice;
use super::{Bases, Combination, Line, LineIdentification};

/// Standard uncertainty of a line's frequency in bins, for lines of a motion that is not necessarily
/// steady. The frequency of a steady line is known far more accurately. This value covers tones that
/// drift or are modulated within the window: in a chaotic squeak at 5 degrees with windows of 20 ms,
/// sums of two lines differ from a third by up to 0.4 bins.
pub const FREQUENCY_UNCERTAINTY: f64 = 0.25;

/// Number of candidates for the first base, and maximum number for the second base with each of them.
const BASE_CANDIDATES: usize = 6;

/// Ratio of the weights of successive candidates.
const PENALTY_RATIO: f64 = 10.0;

/// Minimum amplitude of a second base, relative to the strongest line not explained by the first
/// (-6 dB). Otherwise that line should be the base.
const MIN_SECOND_BASE: f64 = 0.5;

/// Maximum probability that a line at a random frequency gets a name. Less significant names are
/// discarded.
const MAX_COVERAGE: f64 = 0.3;

/// Maximum p-value at which two bases are accepted.
const SIGNIFICANCE: f64 = 0.05;

/// Largest number of doublings, and maximum p-value at which one is accepted.
const MAX_DOUBLINGS: usize = 2;
const DOUBLING_SIGNIFICANCE: f64 = 0.01;

/// Lines above this amplitude relative to the strongest (-20 dB) are independent tones: a single base
/// must explain them all.
const STRONG_LINE: f64 = 0.1;

/// Identifies `lines` (strongest first) with frequencies of the given standard `uncertainty`, Hz.
///
/// Of two bases the stronger is `f1`. A line gets a name only within the combined uncertainty (root sum
/// of squares) of the three frequencies. The module documentation describes the choice of the bases.
pub fn identify_lines(lines: &[Line], uncertainty: f64) -> LineIdentification {
    follow_lines(lines, uncertainty, Bases::None)
}

/// Identifies lines as [`identify_lines`], but keeps the `previous` bases of a motion that changes
/// gradually, in time or with a parameter, as long as they explain the same lines and change by at most
/// 1 %: names then do not change although amplitudes do.
pub fn follow_lines(lines: &[Line], uncertainty: f64, previous: Bases) -> LineIdentification {
    let simplest = simplest_reading(lines, uncertainty);
    if simplest.bases == Bases::None {
        return simplest;
    }
    let first = with_doublings(lines, &simplest, previous, uncertainty);
    if !matches!(first.bases, Bases::Two { .. }) || first.bases == simplest.bases {
        return first;
    }
    // Combinations of low order in the final bases can be of high order in those of the search.
    let reading = read(lines, first.bases, uncertainty, 1.0);
    let second = with_doublings(lines, &reading, first.bases, uncertainty);
    if second.bases != first.bases || second.doubling < first.doubling {
        return first;
    }
    let both = second.names.iter().copied().zip(&first.names);
    let names = both.map(|(name, other)| name.or(other.filter(Combination::is_credible)));
    LineIdentification {
        names: names.collect(),
        p_value: first.p_value,
        ..second
    }
}

/// Adds the doublings to a reading without, and chooses the bases.
fn with_doublings(
    lines: &[Line],
    reading: &LineIdentification,
    previous: Bases,
    uncertainty: f64,
) -> LineIdentification {
    let mut lattice = Lattice::of(lines, reading);
    for _ in 0..MAX_DOUBLINGS {
        match halves(&lattice, uncertainty) {
            Some((parity, found)) => lattice.refine(parity, &found),
            None => break,
        }
    }
    lattice.identification(previous, reading.p_value)
}

/// The reading without doublings that has the smallest p-value.
fn simplest_reading(lines: &[Line], uncertainty: f64) -> LineIdentification {
    // Of lines of similar amplitude the lower is the more likely base: an octave counts as 1.5 dB.
    let weight = |i: usize| lines[i].amplitude / lines[i].frequency.powf(0.25);
    let mut ranking: Vec<usize> = (0..lines.len()).collect();
    ranking.sort_by(|&i, &j| weight(j).total_cmp(&weight(i)));

    let mut best = LineIdentification::none(lines.len());
    let mut consider = |reading: LineIdentification| {
        // Of equal readings the first is kept: one base before two, more likely bases first.
        let better = best.bases == Bases::None || reading.p_value < best.p_value;
        if better && is_accepted(&reading, lines) {
            best = reading;
        }
    };
    for (rank, &i) in ranking.iter().take(BASE_CANDIDATES).enumerate() {
        let one = Bases::One {
            f1: lines[i].frequency,
        };
        // Half of the total weight goes to one base, half to two.
        let first = 2.0 * penalty(rank);
        let single = read(lines, one, uncertainty, first);
        let unnamed = |j: &&usize| single.names[**j].is_none();
        let rest: Vec<usize> = ranking.iter().filter(unnamed).copied().collect();
        consider(single);
        let strong = |j: &&usize| weight(**j) >= MIN_SECOND_BASE * weight(rest[0]);
        let seconds = rest.iter().filter(strong).take(BASE_CANDIDATES);
        for (rank, &j) in seconds.enumerate() {
            let two = Bases::Two {
                f1: lines[i.min(j)].frequency,
                f2: lines[i.max(j)].frequency,
            };
            if !is_harmonic(two, uncertainty) {
                consider(read(lines, two, uncertainty, first * penalty(rank)));
            }
        }
    }
    best
}

/// Whether the reading is accepted. One base must explain every strong line. A second base must be
/// strong or explain a line besides its own. Two bases must also be significant, unless they are the
/// only lines.
fn is_accepted(reading: &LineIdentification, lines: &[Line]) -> bool {
    let strong = |line: &Line| line.amplitude >= STRONG_LINE * lines[0].amplitude;
    let named = || lines.iter().zip(&reading.names);
    match reading.bases {
        Bases::None => false,
        Bases::One { .. } => named().all(|(line, name)| name.is_some() || !strong(line)),
        Bases::Two { .. } | Bases::Modulated { .. } => {
            let supports = |(line, name): (&Line, &Option<Combination>)| {
                name.is_some_and(|c| c.m != 0 && (c.order() > 1 || strong(line)))
            };
            named().any(supports) && (reading.p_value <= SIGNIFICANCE || lines.len() == 2)
        }
    }
}

/// Factor on the p-value for a place in a list of candidates: the inverse of its weight. All weights sum
/// to 1.
fn penalty(rank: usize) -> f64 {
    PENALTY_RATIO.powi(rank as i32 + 1) / (PENALTY_RATIO - 1.0)
}

/// Whether one of two bases is a harmonic of the other within the uncertainty.
fn is_harmonic(bases: Bases, uncertainty: f64) -> bool {
    let [f1, f2] = bases.pair();
    let (low, high) = (f1.min(f2), f1.max(f2));
    let harmonic = Combination::new((high / low).round() as i32, 0);
    (high - f64::from(harmonic.n) * low).abs() <= harmonic.tolerance(uncertainty)
}

/// Reads the lines with the given bases and multiplies the p-value by `penalty`.
fn read(lines: &[Line], bases: Bases, uncertainty: f64, penalty: f64) -> LineIdentification {
    let fits = fit(lines, bases, None, uncertainty);
    // The bases fit themselves and are no evidence.
    let evidence = fits.iter().flatten().filter(|(c, _)| c.order() > 1);
    let sum = evidence.map(|(_, p)| -p.ln()).sum();
    let p_value = penalty * fisher_tail(sum, lines.len() - bases.count());
    LineIdentification {
        bases,
        names: fits.into_iter().map(|fit| fit.map(|(c, _)| c)).collect(),
        p_value: p_value.min(1.0),
        doubling: 0,
    }
}

/// Lines, by index, and their new names.
type NewNames = Vec<(usize, Combination)>;

/// The unidentified lines at halves of the points of a lattice: the parity of the points and the new
/// names. `None` unless there are more of them than random lines would give.
fn halves(lattice: &Lattice<'_>, uncertainty: f64) -> Option<([i32; 2], NewNames)> {
    let bases = match lattice.base {
        [f1, 0.0] => Bases::One { f1 },
        [f1, f2] => Bases::Two { f1, f2 },
    };
    let parities: &[[i32; 2]] = match bases.count() {
        1 => &[[1, 0]],
        _ => &[[1, 1], [0, 1], [1, 0]],
    };
    let free: Vec<usize> = (0..lattice.lines.len())
        .filter(|&i| lattice.points[i].is_none())
        .collect();
    let lines: Vec<Line> = free.iter().map(|&i| lattice.lines[i]).collect();
    let tried = parities.iter().map(|&parity| {
        let fits = fit(&lines, bases, Some(parity), uncertainty);
        let evidence = fits.iter().flatten().map(|(_, p)| -p.ln());
        let p_value = parities.len() as f64 * fisher_tail(evidence.sum(), lines.len());
        let found = free.iter().zip(fits);
        let found = found.filter_map(|(&i, fit)| fit.map(|(name, _)| (i, name)));
        (p_value, parity, found.collect())
    });
    let (p_value, parity, found) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (p_value <= DOUBLING_SIGNIFICANCE).then_some((parity, found))
}

/// Name of each line, and the probability that a random line gets a name of the same or a lower order.
/// With a `parity`, the names are halves, see [`Bases::combinations`].
fn fit(
    lines: &[Line],
    bases: Bases,
    parity: Option<[i32; 2]>,
    uncertainty: f64,
) -> Vec<Option<(Combination, f64)>> {
    let top = lines.iter().map(|line| line.frequency).fold(0.0, f64::max);
    let usable = coverage(bases, parity, uncertainty, top);
    let fits = |line: &Line| {
        let mut names = usable.iter();
        let fits = names.find(|(c, _)| {
            (bases.frequency(*c) - line.frequency).abs() <= c.tolerance(uncertainty)
        });
        fits.copied()
    };
    lines.iter().map(fits).collect()
}

/// Combinations that can be names, lowest order first. Each with the share of the frequencies up to
/// `top` within the tolerance of a combination of the same or a lower order.
fn coverage(
    bases: Bases,
    parity: Option<[i32; 2]>,
    uncertainty: f64,
    top: f64,
) -> Vec<(Combination, f64)> {
    let mut all = bases.combinations(parity);
    all.retain(|&c| bases.frequency(c) <= top + c.tolerance(uncertainty));
    let mut covered = 0.0;
    let mut usable = Vec::with_capacity(all.len());
    for order in all.chunk_by(|a, b| a.order() == b.order()) {
        covered += order
            .iter()
            .map(|c| 2.0 * c.tolerance(uncertainty) / top)
            .sum::<f64>();
        if covered > MAX_COVERAGE {
            break;
        }
        usable.extend(order.iter().map(|&c| (c, covered)));
    }
    usable
}

/// Probability that the sum of `count` exponential variables of mean 1 exceeds `sum`, the distribution
/// of `-sum ln p` of as many independent tests (Fisher 1925).
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

#[cfg(test)]
#[path = "naming_tests.rs"]
mod naming_tests;
