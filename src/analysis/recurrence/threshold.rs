//! Recurrence thresholds.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::diagonals::{Diagonal, Limits, Pairs, Visitor};
use crate::analysis::{AnalysisError, DelayVectors, Norm, deviation};

/// Threshold for the recurrence of two states.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(
    tag = "threshold",
    content = "threshold_value",
    rename_all = "kebab-case"
)]
pub enum Threshold {
    /// A distance, in the signal's unit.
    Distance(f64),
    /// This multiple of the standard deviation of the samples that form the vectors.
    Spread(f64),
    /// The distance at which this share of the counted pairs is recurrent, 0 to 1.
    Rate(f64),
    /// A separate distance for each state that gives it this many neighbours outside the Theiler window
    /// (fixed amount of neighbours; the plot is asymmetric).
    Neighbours(usize),
}

impl Threshold {
    /// The distance (signal's unit) of [`Threshold::Distance`]. [`RecurrenceCriterion::fixed`] converts the
    /// other thresholds.
    pub fn distance(self) -> Option<f64> {
        match self {
            Self::Distance(distance) => Some(distance),
            Self::Spread(_) | Self::Rate(_) | Self::Neighbours(_) => None,
        }
    }

    /// Returns the threshold if it is in range.
    pub(super) fn check(self) -> Result<Self, AnalysisError> {
        let (valid, what) = match self {
            Self::Distance(distance) => (distance >= 0.0, "the distance must be at least 0"),
            Self::Spread(times) => (
                times >= 0.0 && times.is_finite(),
                "the spread must be finite and at least 0",
            ),
            Self::Rate(rate) => ((0.0..=1.0).contains(&rate), "the rate must be from 0 to 1"),
            Self::Neighbours(count) => (count > 0, "the number of neighbours must be at least 1"),
        };
        valid
            .then_some(self)
            .ok_or(AnalysisError::Threshold { what })
    }
}

/// Criterion for recurrent pairs, and the pairs that count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RecurrenceCriterion {
    /// Norm of the distances.
    pub norm: Norm,
    /// Recurrence threshold.
    #[serde(flatten)]
    pub threshold: Threshold,
    /// Theiler window: pairs with `|i - j| < theiler` are excluded from all counts. 0 excludes none; 1
    /// (usual) excludes the line of identity.
    #[serde(rename = "theiler_states")]
    pub theiler: usize,
}

impl RecurrenceCriterion {
    /// The same criterion with the threshold converted to a distance for these vectors, which avoids
    /// computing it repeatedly. [`Threshold::Neighbours`] stays unchanged because it has a distance for
    /// every state.
    ///
    /// # Errors
    /// [`AnalysisError::Threshold`] as in [`quantify`](super::quantify).
    pub fn fixed(self, vectors: &DelayVectors<'_>) -> Result<Self, AnalysisError> {
        let threshold = match self.threshold.check()? {
            Threshold::Neighbours(count) => Threshold::Neighbours(count),
            _ => Threshold::Distance(find_threshold(vectors, &self)?),
        };
        Ok(Self { threshold, ..self })
    }
}

/// Computes the distance (signal's unit) of a threshold.
///
/// For [`Threshold::Rate`] it is exact: the smallest distance at which at least `round(rate * pairs)` of
/// the counted pairs are recurrent. It is the distance of one of the pairs. Other pairs at the same
/// distance are included, which can make the actual rate larger. A rate of less than half a pair gives
/// 0. Memory is proportional to the number of vectors.
///
/// # Errors
/// [`AnalysisError::Threshold`] for a distance or spread that is negative or NaN, a rate outside 0 to 1,
/// 0 neighbours, and always for [`Threshold::Neighbours`]: it has a distance for every state, which only
/// [`quantify`](super::quantify) computes.
pub fn find_threshold(
    vectors: &DelayVectors<'_>,
    rule: &RecurrenceCriterion,
) -> Result<f64, AnalysisError> {
    if let Threshold::Neighbours(_) = rule.threshold {
        let what = "a fixed number of neighbours has no single distance; use a rate instead";
        return Err(AnalysisError::Threshold { what });
    }
    let pairs = Pairs::new(vectors, rule.norm, rule.theiler);
    match ResolvedThreshold::find(&pairs, rule.threshold)? {
        ResolvedThreshold::Uniform(distance) => Ok(distance),
        ResolvedThreshold::PerColumn(_) => {
            unreachable!("only a fixed number of neighbours has a distance per state")
        }
    }
}

/// A threshold resolved to distances.
pub(super) enum ResolvedThreshold {
    /// One distance for all pairs.
    Uniform(f64),
    /// Limit of the unrooted distance for each column, padded as [`Limits::Columns`] requires.
    PerColumn(Vec<f64>),
}

impl ResolvedThreshold {
    pub fn limits(&self, norm: Norm) -> Limits<'_> {
        match self {
            Self::Uniform(distance) => Limits::One(norm.unrooted_limit(*distance)),
            Self::PerColumn(distances) => Limits::Columns(distances),
        }
    }

    pub fn find(pairs: &Pairs<'_>, threshold: Threshold) -> Result<Self, AnalysisError> {
        Ok(match threshold.check()? {
            Threshold::Distance(distance) => Self::Uniform(distance),
            Threshold::Spread(times) => Self::Uniform(times * deviation(pairs.samples)),
            Threshold::Rate(rate) => Self::Uniform(distance_for_rate(pairs, rate)),
            Threshold::Neighbours(count) => Self::PerColumn(column_limits(pairs, count)),
        })
    }
}

/// For each state, the unrooted distance that contains `count` other states outside the Theiler window,
/// or all of them if there are fewer.
fn column_limits(pairs: &Pairs<'_>, count: usize) -> Vec<f64> {
    let n = pairs.states;
    let first = pairs.offsets().start;
    let mut limits: Vec<f64> = (0..n)
        .into_par_iter()
        .map_init(Vec::new, |distances, j| {
            distances.clear();
            pairs.unrooted_row(j, 0..(j + 1).saturating_sub(first), distances);
            pairs.unrooted_row(j, j.saturating_add(first).min(n)..n, distances);
            match count.min(distances.len()).checked_sub(1) {
                // Non-negative floating-point numbers have the order of their bit patterns.
                Some(last) => {
                    *distances
                        .select_nth_unstable_by_key(last, |e| e.to_bits())
                        .1
                }
                None => 0.0,
            }
        })
        .collect();
    limits.resize(n + 64, 0.0);
    limits
}

/// Distance for a recurrence rate, as defined in [`find_threshold`].
fn distance_for_rate(pairs: &Pairs<'_>, rate: f64) -> f64 {
    let n = pairs.states as u64;
    let upper: u64 = pairs.offsets().map(|k| n - k as u64).sum();
    // If the line of identity counts, it is always recurrent.
    let identity = if pairs.offsets().start > pairs.theiler {
        n
    } else {
        0
    };
    let count = rate * (2 * upper + identity) as f64 - identity as f64;
    let count = ((0.5 * count).round().max(0.0) as u64).min(upper);
    match count.checked_sub(1) {
        Some(rank) => pairs
            .norm
            .distance_of_unrooted(order_statistic(pairs, upper, rank)),
        None => 0.0,
    }
}

/// The unrooted distance with this rank (0 the smallest) among the `upper` counted pairs of the upper
/// triangle.
///
/// A sample of the pairs gives a first bracket. A pass over all pairs counts those below the bracket and
/// keeps those inside. If there are too many to keep, it counts them in bins, one of which becomes the
/// next bracket. Brackets are ranges of the bit patterns, which have the order of the numbers, so a
/// bracket can shrink to a single value.
fn order_statistic(pairs: &Pairs<'_>, upper: u64, rank: u64) -> f64 {
    /// 8 MB for any length of the signal.
    const MAX_KEPT: usize = 1 << 20;
    let bracket = Bracket::from_sample(pairs, rank as f64 / upper as f64);
    narrow_down(pairs, bracket, rank, MAX_KEPT)
}

/// The unrooted distance with this rank, starting from any bracket and keeping at most `max_kept`
/// values.
fn narrow_down(pairs: &Pairs<'_>, mut bracket: Bracket, rank: u64, max_kept: usize) -> f64 {
    while bracket.first < bracket.last {
        let scan = Scan::of(pairs, bracket, max_kept);
        bracket = match rank.checked_sub(scan.below) {
            None => Bracket {
                first: 0,
                last: bracket.first - 1,
            },
            Some(rank) if rank >= scan.inside.count() => Bracket {
                first: bracket.last + 1,
                last: Bracket::ALL.last,
            },
            Some(rank) => scan.inside.narrow(bracket, rank),
        };
    }
    f64::from_bits(bracket.first)
}

/// Range of unrooted distances from `first` to `last` inclusive, as bit patterns.
#[derive(Clone, Copy, Debug)]
struct Bracket {
    first: u64,
    last: u64,
}

impl Bracket {
    const ALL: Self = Self {
        first: 0,
        last: f64::INFINITY.to_bits(),
    };
    /// Number of bins per bracket.
    const BINS: usize = 1 << 16;

    /// Bracket that probably contains the quantile `share`.
    fn from_sample(pairs: &Pairs<'_>, share: f64) -> Self {
        const DRAWS: usize = 1 << 16;
        // Successive multiples of these, modulo 1, fill a square evenly (1/p and 1/p^2 with p^3 = p +
        // 1).
        const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
        let n = pairs.states as f64;
        let state = |draw: usize, step: f64| ((draw as f64 * step).fract() * n) as usize;
        let draws = (1..=DRAWS).map(|draw| STEPS.map(|step| state(draw, step)));
        let counted = draws.filter(|[i, j]| pairs.offsets().contains(&i.abs_diff(*j)));
        let mut sample: Vec<u64> = counted
            .map(|[i, j]| pairs.unrooted(i, j).to_bits())
            .collect();
        sample.sort_unstable();
        // Five standard deviations of the number of sampled values below the quantile.
        let middle = share * sample.len() as f64;
        let margin = 5.0 + 5.0 * (middle * (1.0 - share)).sqrt();
        let at = |place: f64| sample.get(place as usize).copied();
        Self {
            first: if middle < margin {
                Self::ALL.first
            } else {
                at(middle - margin).unwrap_or(Self::ALL.first)
            },
            last: at(middle + margin).unwrap_or(Self::ALL.last),
        }
    }

    /// Number of low bits that locate a value within a bin.
    fn shift(self) -> u32 {
        let bins = Self::BINS.ilog2();
        (u64::BITS - (self.last - self.first).leading_zeros()).saturating_sub(bins)
    }

    fn bin(self, bits: u64) -> usize {
        ((bits - self.first) >> self.shift()) as usize
    }
}

/// Unrooted distances inside a bracket.
enum Inside {
    /// All values.
    Kept(Vec<u64>),
    /// Number of values per bin.
    Binned(Vec<u64>),
}

impl Inside {
    fn add(&mut self, bracket: Bracket, max_kept: usize, bits: u64) {
        match self {
            Self::Kept(kept) if kept.len() < max_kept => kept.push(bits),
            Self::Kept(kept) => {
                let mut bins = vec![0; Bracket::BINS];
                kept.iter().for_each(|&bits| bins[bracket.bin(bits)] += 1);
                bins[bracket.bin(bits)] += 1;
                *self = Self::Binned(bins);
            }
            Self::Binned(bins) => bins[bracket.bin(bits)] += 1,
        }
    }

    fn merge(self, other: Self, bracket: Bracket, max_kept: usize) -> Self {
        match (self, other) {
            (Self::Binned(mut a), Self::Binned(b)) => {
                a.iter_mut().zip(b).for_each(|(sum, count)| *sum += count);
                Self::Binned(a)
            }
            (mut sum, Self::Kept(kept)) | (Self::Kept(kept), mut sum) => {
                kept.into_iter()
                    .for_each(|bits| sum.add(bracket, max_kept, bits));
                sum
            }
        }
    }

    fn count(&self) -> u64 {
        match self {
            Self::Kept(kept) => kept.len() as u64,
            Self::Binned(bins) => bins.iter().sum(),
        }
    }

    /// The part of the bracket that contains the value with this rank.
    fn narrow(self, bracket: Bracket, mut rank: u64) -> Bracket {
        match self {
            Self::Kept(mut kept) => {
                let bits = *kept.select_nth_unstable(rank as usize).1;
                Bracket {
                    first: bits,
                    last: bits,
                }
            }
            Self::Binned(bins) => {
                let mut bin = 0;
                while rank >= bins[bin] {
                    rank -= bins[bin];
                    bin += 1;
                }
                let width = 1 << bracket.shift();
                let first = bracket.first + bin as u64 * width;
                Bracket {
                    first,
                    last: bracket.last.min(first + (width - 1)),
                }
            }
        }
    }
}

/// Result of a pass over all pairs.
struct Scan<'a> {
    pairs: &'a Pairs<'a>,
    bracket: Bracket,
    /// Maximum number of values kept.
    max_kept: usize,
    /// Number of pairs below the bracket.
    below: u64,
    inside: Inside,
}

impl<'a> Scan<'a> {
    fn new(pairs: &'a Pairs<'a>, bracket: Bracket, max_kept: usize) -> Self {
        Self {
            pairs,
            bracket,
            max_kept,
            below: 0,
            inside: Inside::Kept(Vec::new()),
        }
    }

    fn of(pairs: &'a Pairs<'a>, bracket: Bracket, max_kept: usize) -> Self {
        let below = bracket.first.checked_sub(1).map_or(-1.0, f64::from_bits);
        let limits = Limits::Two(f64::from_bits(bracket.last), below);
        let new = || Self::new(pairs, bracket, max_kept);
        let scan = |mut scan: Self, block| {
            pairs.visit(block, limits, &mut scan);
            scan
        };
        let merge = |mut a: Self, b: Self| {
            a.below += b.below;
            a.inside = a.inside.merge(b.inside, bracket, max_kept);
            a
        };
        pairs
            .blocks()
            .into_par_iter()
            .fold(new, scan)
            .reduce(new, merge)
    }
}

impl Visitor for Scan<'_> {
    #[inline(always)]
    fn visit(&mut self, diagonal: &Diagonal<'_>) {
        for (word, (&upto, &below)) in diagonal.upper.iter().zip(diagonal.lower).enumerate() {
            self.below += u64::from(below.count_ones());
            let mut inside = upto & !below;
            while inside != 0 {
                let i = 64 * word + inside.trailing_zeros() as usize;
                let unrooted = self.pairs.unrooted(i, i + diagonal.offset);
                self.inside
                    .add(self.bracket, self.max_kept, unrooted.to_bits());
                inside &= inside - 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::quantify;
    use crate::analysis::test_signals::{noise, sines};

    fn rule(norm: Norm, threshold: Threshold, theiler: usize) -> RecurrenceCriterion {
        RecurrenceCriterion {
            norm,
            threshold,
            theiler,
        }
    }

    /// All unrooted distances of the upper triangle, sorted.
    fn distances(pairs: &Pairs<'_>) -> Vec<f64> {
        let of_offset = |k: usize| (0..pairs.states - k).map(move |i| pairs.unrooted(i, i + k));
        let mut distances: Vec<f64> = pairs.offsets().flat_map(of_offset).collect();
        distances.sort_by(f64::total_cmp);
        distances
    }

    #[test]
    fn the_distance_for_a_rate_is_the_smallest_that_reaches_it() {
        let signal = noise(2, 700, 1.0);
        let vectors = DelayVectors::new(&signal, 7, 5).unwrap();
        for norm in [Norm::Euclidean, Norm::Maximum, Norm::Manhattan] {
            for theiler in [0, 1, 40] {
                for rate in [1e-4, 0.01, 0.05, 0.3, 0.999, 1.0] {
                    let by_rate = rule(norm, Threshold::Rate(rate), theiler);
                    let distance = find_threshold(&vectors, &by_rate).unwrap();
                    let reached = |distance| {
                        let rule = rule(norm, Threshold::Distance(distance), theiler);
                        quantify(&vectors, &rule).unwrap()
                    };
                    let counts = reached(distance);
                    if distance > 0.0 {
                        let count = rate * counts.pairs() as f64;
                        let below = reached(distance.next_down()).recurrent;
                        // Pairs occur twice, once per triangle.
                        assert!(counts.recurrent as f64 >= count - 1.0, "{by_rate:?}");
                        assert!((below as f64) < count + 1.0, "{by_rate:?}");
                        // No two sums over noise are equal.
                        if norm != Norm::Maximum {
                            assert_eq!(counts.recurrent - below, 2, "{by_rate:?}");
                        }
                    }
                    assert_eq!(counts, quantify(&vectors, &by_rate).unwrap());
                }
            }
        }
    }

    /// Compares the search by sample and bins with sorting all values.
    #[test]
    fn order_statistics_are_exact_with_any_ties() {
        let rough = noise(4, 520, 1.0);
        let tied: Vec<f64> = rough.iter().map(|x| (3.0 * x).round()).collect();
        let smooth = sines(1.0, 520, &[(0.01, 1.0, 0.0)]);
        for signal in [rough, tied, smooth, vec![0.0; 520]] {
            let vectors = DelayVectors::new(&signal, 3, 4).unwrap();
            let pairs = Pairs::new(&vectors, Norm::Euclidean, 1);
            let distances = distances(&pairs);
            let last = distances.len() - 1;
            for rank in [0, 1, 700, last / 20, last / 2, last - 1, last] {
                let found = order_statistic(&pairs, distances.len() as u64, rank as u64);
                assert_eq!(found, distances[rank], "{rank}");
                // Any bracket works, even one that misses the value.
                for bracket in [Bracket::ALL, Bracket { first: 1, last: 2 }] {
                    let found = narrow_down(&pairs, bracket, rank as u64, 100);
                    assert_eq!(found, distances[rank], "{rank} {bracket:?}");
                }
            }
        }
    }

    #[test]
    fn a_spread_is_a_multiple_of_the_standard_deviation() {
        let signal = [1.0, -1.0, 1.0, -1.0, 3.0, -3.0];
        let vectors = DelayVectors::new(&signal, 1, 2).unwrap();
        let spread = rule(Norm::Maximum, Threshold::Spread(0.5), 1);
        let distance = find_threshold(&vectors, &spread).unwrap();
        assert_eq!(distance, 0.5 * (22.0_f64 / 6.0).sqrt());
    }

    #[test]
    fn a_fixed_criterion_gives_the_same_counts() {
        let signal = noise(8, 300, 1.0);
        let vectors = DelayVectors::new(&signal, 3, 3).unwrap();
        for threshold in [
            Threshold::Distance(1.3),
            Threshold::Spread(0.7),
            Threshold::Rate(0.05),
            Threshold::Neighbours(9),
        ] {
            let rule = rule(Norm::Euclidean, threshold, 2);
            let fixed = rule.fixed(&vectors).unwrap();
            let distance = find_threshold(&vectors, &rule).ok();
            assert_eq!(fixed.threshold.distance(), distance, "{threshold:?}");
            let counts = quantify(&vectors, &rule).unwrap();
            assert_eq!(quantify(&vectors, &fixed).unwrap(), counts);
        }
    }

    #[test]
    fn each_column_has_the_given_number_of_neighbours() {
        let signal = noise(6, 150, 1.0);
        let vectors = DelayVectors::new(&signal, 1, 2).unwrap();
        for theiler in [1, 10] {
            let neighbours = rule(Norm::Euclidean, Threshold::Neighbours(7), theiler);
            let counts = quantify(&vectors, &neighbours).unwrap();
            assert_eq!(counts.recurrent, 7 * 149);
        }
        let all = rule(Norm::Euclidean, Threshold::Neighbours(1000), 1);
        let counts = quantify(&vectors, &all).unwrap();
        assert_eq!(counts.recurrent, counts.pairs());
    }

    #[test]
    fn thresholds_out_of_range_are_rejected() {
        let signal = [0.0, 1.0, 2.0];
        let vectors = DelayVectors::new(&signal, 1, 1).unwrap();
        for threshold in [
            Threshold::Distance(-1.0),
            Threshold::Distance(f64::NAN),
            Threshold::Spread(-0.1),
            Threshold::Spread(f64::INFINITY),
            Threshold::Rate(-0.1),
            Threshold::Rate(1.1),
            Threshold::Rate(f64::NAN),
            Threshold::Neighbours(0),
        ] {
            let rule = rule(Norm::Euclidean, threshold, 1);
            assert!(quantify(&vectors, &rule).is_err(), "{threshold:?}");
            assert!(find_threshold(&vectors, &rule).is_err(), "{threshold:?}");
            assert!(rule.fixed(&vectors).is_err(), "{threshold:?}");
        }
        let neighbours = rule(Norm::Euclidean, Threshold::Neighbours(1), 1);
        assert!(find_threshold(&vectors, &neighbours).is_err());
    }
}
