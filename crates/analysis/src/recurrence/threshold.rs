//! Recurrence thresholds.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::diagonals::{Limits, Pairs};
use crate::{AnalysisError, DelayVectors, Norm, deviation};

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
            Threshold::Spread(times) => Self::Uniform(times * deviation(pairs.vectors.samples())),
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
            if pairs.vectors.is_stopped() {
                return 0.0;
            }
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

/// Distances that are sorted at most: 8 MB for any length of the signal.
const MAX_KEPT: u64 = 1 << 20;

/// Distance for a recurrence rate, as defined in [`find_threshold`].
fn distance_for_rate(pairs: &Pairs<'_>, rate: f64) -> f64 {
    let n = pairs.states as u64;
    let upper: u64 = pairs.offsets().map(|k| n - k as u64).sum();
    let identity = if pairs.offsets().start > pairs.theiler {
        n
    } else {
        0
    };
    rank_of_rate(rate, upper, identity).map_or(0.0, |rank| {
        let unrooted = order_statistic(pairs, rank, MAX_KEPT);
        pairs.norm.distance_of_unrooted(unrooted)
    })
}

/// Rank, from 0, of the distance for a recurrence rate among those of `upper` pairs; `None` if no pair is to be recurrent.
/// `identity` pairs on the line of identity are always recurrent.
pub(super) fn rank_of_rate(rate: f64, upper: u64, identity: u64) -> Option<u64> {
    let count = rate * (2 * upper + identity) as f64 - identity as f64;
    let count = ((0.5 * count).round().max(0.0) as u64).min(upper);
    count.checked_sub(1)
}

/// The unrooted distance with this rank (0 the smallest) among the counted pairs of the upper triangle.
///
/// Non-negative floating-point numbers have the order of their bit patterns. A pass over all pairs counts the
/// patterns by their leading bits, and the next pass counts those in the bin that contains the rank by the
/// following bits, until so few remain that they can be sorted.
fn order_statistic(pairs: &Pairs<'_>, mut rank: u64, max_kept: u64) -> f64 {
    /// Bits that a pass decides.
    const DIGIT: u32 = 16;
    let (mut prefix, mut undecided) = (0, u64::BITS);
    while undecided > 0 {
        let leading = |bits: u64| bits >> (undecided - DIGIT);
        let is_inside = |bits: u64| leading(bits) >> DIGIT == prefix;
        let new = || vec![0_u64; 1 << DIGIT];
        let count = |mut bins: Vec<u64>, bits: u64| {
            if is_inside(bits) {
                bins[(leading(bits) & ((1 << DIGIT) - 1)) as usize] += 1;
            }
            bins
        };
        let add = |mut a: Vec<u64>, b: Vec<u64>| {
            a.iter_mut().zip(b).for_each(|(sum, count)| *sum += count);
            a
        };
        let bins = fold_pairs(pairs, new, count, add);
        if pairs.vectors.is_stopped() {
            return 0.0;
        }
        let mut bin = 0;
        while rank >= bins[bin] {
            rank -= bins[bin];
            bin += 1;
        }
        prefix = prefix << DIGIT | bin as u64;
        undecided -= DIGIT;
        if bins[bin] <= max_kept {
            let keep = |mut kept: Vec<u64>, bits: u64| {
                if bits >> undecided == prefix {
                    kept.push(bits);
                }
                kept
            };
            let mut kept = fold_pairs(pairs, Vec::new, keep, |a, b| [a, b].concat());
            if pairs.vectors.is_stopped() {
                return 0.0;
            }
            return f64::from_bits(*kept.select_nth_unstable(rank as usize).1);
        }
    }
    f64::from_bits(prefix)
}

/// Folds the bit patterns of the unrooted distances of all counted pairs of the upper triangle, in parallel.
fn fold_pairs<T: Send>(
    pairs: &Pairs<'_>,
    new: impl Fn() -> T + Sync,
    add: impl Fn(T, u64) -> T + Sync,
    merge: impl Fn(T, T) -> T + Sync,
) -> T {
    let (n, first) = (pairs.states, pairs.offsets().start);
    let fold = |(sum, mut distances): (T, Vec<f64>), i: usize| {
        distances.clear();
        if pairs.vectors.is_stopped() {
            return (sum, distances);
        }
        pairs.unrooted_row(i, i + first..n, &mut distances);
        let sum = distances.iter().fold(sum, |sum, e| add(sum, e.to_bits()));
        (sum, distances)
    };
    (0..n.saturating_sub(first))
        .into_par_iter()
        .fold(|| (new(), Vec::new()), fold)
        .map(|(sum, _)| sum)
        .reduce(&new, &merge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantify;
    use crate::test_signals::{noise, sines};

    fn rule(norm: Norm, threshold: Threshold, theiler: usize) -> RecurrenceCriterion {
        RecurrenceCriterion {
            norm,
            threshold,
            theiler,
        }
    }

    /// All unrooted distances of the upper triangle, sorted.
    fn distances(pairs: &Pairs<'_>) -> Vec<f64> {
        let (n, first) = (pairs.states, pairs.offsets().start);
        let mut distances = Vec::new();
        for i in 0..n.saturating_sub(first) {
            pairs.unrooted_row(i, i + first..n, &mut distances);
        }
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

    /// Compares the search by leading bits with sorting all values.
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
                for max_kept in [MAX_KEPT, 100, 0] {
                    let found = order_statistic(&pairs, rank as u64, max_kept);
                    assert_eq!(found, distances[rank], "{rank}, {max_kept} kept");
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
