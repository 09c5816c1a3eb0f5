//! When two states count as the same: thresholds as types.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::sweep::{Diagonal, Limits, Pairs, Visitor};
use crate::analysis::{AnalysisError, DelayVectors, Norm, deviation};

/// How near is the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    tag = "threshold",
    content = "threshold_value",
    rename_all = "kebab-case"
)]
pub enum Threshold {
    /// A distance, in the signal's unit.
    Distance(f64),
    /// This many times the standard deviation of the samples that the vectors are made of.
    Spread(f64),
    /// The distance at which this share of the counted pairs is recurrent, 0 to 1.
    Rate(f64),
    /// A distance for each state, such that this many others (outside the Theiler window) are
    /// near it (fixed amount of neighbours; the plot is not symmetric).
    Neighbours(usize),
}

impl Threshold {
    /// The distance (signal's unit), if it is one: see [`RecurrenceRule::fixed`] for the others.
    pub fn distance(self) -> Option<f64> {
        match self {
            Self::Distance(distance) => Some(distance),
            Self::Spread(_) | Self::Rate(_) | Self::Neighbours(_) => None,
        }
    }

    /// The threshold itself, if it is within its range.
    pub(super) fn check(self) -> Result<Self, AnalysisError> {
        let (right, what) = match self {
            Self::Distance(distance) => (distance >= 0.0, "a distance must be at least 0"),
            Self::Spread(times) => (
                times >= 0.0 && times.is_finite(),
                "a spread must be finite and at least 0",
            ),
            Self::Rate(rate) => ((0.0..=1.0).contains(&rate), "a rate must be from 0 to 1"),
            Self::Neighbours(wanted) => (wanted > 0, "ask for at least one neighbour"),
        };
        right
            .then_some(self)
            .ok_or(AnalysisError::Threshold { what })
    }
}

/// Which pairs of states are recurrent, and which count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecurrenceRule {
    /// How distances are measured.
    pub norm: Norm,
    /// How near is the same.
    #[serde(flatten)]
    pub threshold: Threshold,
    /// Pairs with `|i - j| < theiler` are left out of every count: 0 keeps all, 1 (the usual)
    /// leaves out the line of identity.
    #[serde(rename = "theiler_states")]
    pub theiler: usize,
}

impl RecurrenceRule {
    /// The same rule with the distance that its threshold comes to for these vectors, which is
    /// then found once, however often it is needed. [`Threshold::Neighbours`] stays as it is: it
    /// has a distance for every state.
    ///
    /// # Errors
    /// [`AnalysisError::Threshold`] as in [`quantify`](super::quantify).
    pub fn fixed(self, vectors: &DelayVectors<'_>) -> Result<Self, AnalysisError> {
        let threshold = match self.threshold.check()? {
            Threshold::Neighbours(wanted) => Threshold::Neighbours(wanted),
            _ => Threshold::Distance(find_threshold(vectors, &self)?),
        };
        Ok(Self { threshold, ..self })
    }
}

/// The distance (signal's unit) that a threshold comes to.
///
/// For [`Threshold::Rate`] it is exact: the smallest distance at which at least
/// `round(rate * pairs)` of the counted pairs are recurrent, hence the distance of one of the
/// pairs; others at the same distance come with it, so that the rate reached may be larger. A
/// rate of less than half a pair gives 0. Memory is proportional to the number of vectors.
///
/// # Errors
/// [`AnalysisError::Threshold`] for a distance or spread that is negative or not a number, a rate
/// outside 0 to 1, 0 neighbours, and for [`Threshold::Neighbours`] as such: it has a distance for
/// every state, which only [`quantify`](super::quantify) finds.
pub fn find_threshold(
    vectors: &DelayVectors<'_>,
    rule: &RecurrenceRule,
) -> Result<f64, AnalysisError> {
    if let Threshold::Neighbours(_) = rule.threshold {
        let what = "a number of neighbours has no single distance; ask for a rate instead";
        return Err(AnalysisError::Threshold { what });
    }
    let pairs = Pairs::new(vectors, rule.norm, rule.theiler);
    match Nearness::find(&pairs, rule.threshold)? {
        Nearness::Everywhere(distance) => Ok(distance),
        Nearness::Columns(_) => unreachable!("only neighbours have a distance for every state"),
    }
}

/// What a threshold comes to.
pub(super) enum Nearness {
    /// One distance for all pairs.
    Everywhere(f64),
    /// The largest recurrent extent of each column, padded as [`Limits::Columns`] wants it.
    Columns(Vec<f64>),
}

impl Nearness {
    pub fn limits(&self, norm: Norm) -> Limits<'_> {
        match self {
            Self::Everywhere(distance) => Limits::One(norm.extent_within(*distance)),
            Self::Columns(extents) => Limits::Columns(extents),
        }
    }

    pub fn find(pairs: &Pairs<'_>, threshold: Threshold) -> Result<Self, AnalysisError> {
        Ok(match threshold.check()? {
            Threshold::Distance(distance) => Self::Everywhere(distance),
            Threshold::Spread(times) => Self::Everywhere(times * deviation(pairs.samples)),
            Threshold::Rate(rate) => Self::Everywhere(distance_for_rate(pairs, rate)),
            Threshold::Neighbours(wanted) => Self::Columns(extents_of_columns(pairs, wanted)),
        })
    }
}

/// The extent within which so many other states outside the Theiler window lie, for each state;
/// all of them if there are fewer.
fn extents_of_columns(pairs: &Pairs<'_>, wanted: usize) -> Vec<f64> {
    let n = pairs.states;
    let first = pairs.offsets().start;
    let mut limits: Vec<f64> = (0..n)
        .into_par_iter()
        .map_init(Vec::new, |extents, j| {
            extents.clear();
            pairs.extents(j, 0..(j + 1).saturating_sub(first), extents);
            pairs.extents(j, j.saturating_add(first).min(n)..n, extents);
            match wanted.min(extents.len()).checked_sub(1) {
                // Numbers that are not negative are ordered like their bits.
                Some(last) => *extents.select_nth_unstable_by_key(last, |e| e.to_bits()).1,
                None => 0.0,
            }
        })
        .collect();
    limits.resize(n + 64, 0.0);
    limits
}

/// The share of pairs, as [`find_threshold`] says.
fn distance_for_rate(pairs: &Pairs<'_>, rate: f64) -> f64 {
    let n = pairs.states as u64;
    let upper: u64 = pairs.offsets().map(|k| n - k as u64).sum();
    // A line of identity that is counted is recurrent anyway.
    let identity = if pairs.offsets().start > pairs.theiler {
        n
    } else {
        0
    };
    let wanted = rate * (2 * upper + identity) as f64 - identity as f64;
    let wanted = ((0.5 * wanted).round().max(0.0) as u64).min(upper);
    match wanted.checked_sub(1) {
        Some(rank) => pairs
            .norm
            .distance_of_extent(order_statistic(pairs, upper, rank)),
        None => 0.0,
    }
}

/// The extent with this rank (0 the smallest) among those of the `upper` counted pairs of the
/// upper triangle.
///
/// A sample of the pairs brackets it. A pass over all pairs counts those below the bracket and
/// keeps those inside; if they are too many to keep, counts them in bins, one of which is the next
/// bracket. Works on the bits of the extents, which are ordered like the numbers, so that a
/// bracket can be cut until it holds a single one.
fn order_statistic(pairs: &Pairs<'_>, upper: u64, rank: u64) -> f64 {
    /// 8 MB, however long the signal.
    const KEPT: usize = 1 << 20;
    let bracket = Bracket::from_sample(pairs, rank as f64 / upper as f64);
    narrow_down(pairs, bracket, rank, KEPT)
}

/// The extent with this rank, from any bracket, keeping at most so many.
fn narrow_down(pairs: &Pairs<'_>, mut bracket: Bracket, rank: u64, most: usize) -> f64 {
    while bracket.first < bracket.last {
        let scan = Scan::of(pairs, bracket, most);
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

/// Extents from `first` to `last`, both included, as bits.
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
    /// Bins that a bracket is cut into.
    const BINS: usize = 1 << 16;

    /// The extents between which a share of all is likely to be reached.
    fn from_sample(pairs: &Pairs<'_>, share: f64) -> Self {
        const DRAWS: usize = 1 << 16;
        // Successive multiples of these, modulo 1, fill a square evenly (1/p and 1/p^2 with
        // p^3 = p + 1).
        const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
        let n = pairs.states as f64;
        let state = |draw: usize, step: f64| ((draw as f64 * step).fract() * n) as usize;
        let draws = (1..=DRAWS).map(|draw| STEPS.map(|step| state(draw, step)));
        let counted = draws.filter(|[i, j]| pairs.offsets().contains(&i.abs_diff(*j)));
        let mut sample: Vec<u64> = counted.map(|[i, j]| pairs.extent(i, j).to_bits()).collect();
        sample.sort_unstable();
        // Five standard deviations of the number drawn below.
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

    /// Bits of an extent that its place within a bin takes.
    fn shift(self) -> u32 {
        let bins = Self::BINS.ilog2();
        (u64::BITS - (self.last - self.first).leading_zeros()).saturating_sub(bins)
    }

    fn bin(self, bits: u64) -> usize {
        ((bits - self.first) >> self.shift()) as usize
    }
}

/// The extents inside a bracket.
enum Inside {
    /// All of them.
    Kept(Vec<u64>),
    /// How many there are in each bin.
    Binned(Vec<u64>),
}

impl Inside {
    fn add(&mut self, bracket: Bracket, most: usize, bits: u64) {
        match self {
            Self::Kept(kept) if kept.len() < most => kept.push(bits),
            Self::Kept(kept) => {
                let mut bins = vec![0; Bracket::BINS];
                kept.iter().for_each(|&bits| bins[bracket.bin(bits)] += 1);
                bins[bracket.bin(bits)] += 1;
                *self = Self::Binned(bins);
            }
            Self::Binned(bins) => bins[bracket.bin(bits)] += 1,
        }
    }

    fn join(self, other: Self, bracket: Bracket, most: usize) -> Self {
        match (self, other) {
            (Self::Binned(mut a), Self::Binned(b)) => {
                a.iter_mut().zip(b).for_each(|(sum, count)| *sum += count);
                Self::Binned(a)
            }
            (mut sum, Self::Kept(kept)) | (Self::Kept(kept), mut sum) => {
                kept.into_iter()
                    .for_each(|bits| sum.add(bracket, most, bits));
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

    /// The part of the bracket that holds the extent with this rank inside.
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

/// What a pass over all pairs finds.
struct Scan<'a> {
    pairs: &'a Pairs<'a>,
    bracket: Bracket,
    /// Extents kept at most.
    most: usize,
    /// Pairs with an extent below the bracket.
    below: u64,
    inside: Inside,
}

impl<'a> Scan<'a> {
    fn new(pairs: &'a Pairs<'a>, bracket: Bracket, most: usize) -> Self {
        Self {
            pairs,
            bracket,
            most,
            below: 0,
            inside: Inside::Kept(Vec::new()),
        }
    }

    fn of(pairs: &'a Pairs<'a>, bracket: Bracket, most: usize) -> Self {
        let below = bracket.first.checked_sub(1).map_or(-1.0, f64::from_bits);
        let limits = Limits::Two(f64::from_bits(bracket.last), below);
        let new = || Self::new(pairs, bracket, most);
        let scan = |mut scan: Self, piece| {
            pairs.visit(piece, limits, &mut scan);
            scan
        };
        let join = |mut a: Self, b: Self| {
            a.below += b.below;
            a.inside = a.inside.join(b.inside, bracket, most);
            a
        };
        pairs
            .pieces()
            .into_par_iter()
            .fold(new, scan)
            .reduce(new, join)
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
                let extent = self.pairs.extent(i, i + diagonal.offset);
                self.inside.add(self.bracket, self.most, extent.to_bits());
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

    fn rule(norm: Norm, threshold: Threshold, theiler: usize) -> RecurrenceRule {
        RecurrenceRule {
            norm,
            threshold,
            theiler,
        }
    }

    /// All extents of the upper triangle, sorted.
    fn extents(pairs: &Pairs<'_>) -> Vec<f64> {
        let of_offset = |k: usize| (0..pairs.states - k).map(move |i| pairs.extent(i, i + k));
        let mut extents: Vec<f64> = pairs.offsets().flat_map(of_offset).collect();
        extents.sort_by(f64::total_cmp);
        extents
    }

    #[test]
    fn the_distance_of_a_rate_is_the_smallest_that_reaches_it() {
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
                        let wanted = rate * counts.pairs() as f64;
                        let below = reached(distance.next_down()).recurrent;
                        // Pairs come in twos.
                        assert!(counts.recurrent as f64 >= wanted - 1.0, "{by_rate:?}");
                        assert!((below as f64) < wanted + 1.0, "{by_rate:?}");
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

    /// The way over the sample and over the bins, against sorting everything.
    #[test]
    fn order_statistics_are_exact_whatever_the_ties() {
        let rough = noise(4, 520, 1.0);
        let tied: Vec<f64> = rough.iter().map(|x| (3.0 * x).round()).collect();
        let smooth = sines(1.0, 520, &[(0.01, 1.0, 0.0)]);
        for signal in [rough, tied, smooth, vec![0.0; 520]] {
            let vectors = DelayVectors::new(&signal, 3, 4).unwrap();
            let pairs = Pairs::new(&vectors, Norm::Euclidean, 1);
            let extents = extents(&pairs);
            let last = extents.len() - 1;
            for rank in [0, 1, 700, last / 20, last / 2, last - 1, last] {
                let found = order_statistic(&pairs, extents.len() as u64, rank as u64);
                assert_eq!(found, extents[rank], "{rank}");
                // Any bracket leads there, also one that misses.
                for bracket in [Bracket::ALL, Bracket { first: 1, last: 2 }] {
                    let found = narrow_down(&pairs, bracket, rank as u64, 100);
                    assert_eq!(found, extents[rank], "{rank} {bracket:?}");
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
    fn a_fixed_rule_counts_the_same() {
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
    fn each_column_has_its_neighbours() {
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
    fn what_is_out_of_range_is_refused() {
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
