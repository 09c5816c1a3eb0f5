//! Recurrence thresholds.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::Recurrences;
use super::recurrences::distances;
use crate::stats::order_statistic;
use crate::{AnalysisError, delay::DelayVectors, norm::Norm, stats::deviation};

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

/// Most distances that are kept in memory.
const MAX_KEPT: u64 = 1 << 23;

impl<'a> Recurrences<'a> {
    /// The recurrences of a signal.
    ///
    /// The distance of a [`Threshold::Rate`] is that of one of the pairs: the smallest at which at least
    /// `round(rate * pairs)` of the counted pairs are recurrent. Other pairs at the same distance are included.
    /// A rate of less than half a pair gives 0.
    ///
    /// # Errors
    /// [`AnalysisError::Threshold`] for a distance or spread that is negative or NaN, a rate outside 0 to 1, and
    /// 0 neighbours.
    pub fn of(
        vectors: &DelayVectors<'a>,
        criterion: &RecurrenceCriterion,
    ) -> Result<Self, AnalysisError> {
        Self::new([*vectors; 2], criterion, true)
    }

    /// The cross recurrences of two signals of equal dimension: whether a state of the first (row) recurs as one
    /// of the second (column). All pairs count. A spread is that of the first signal, and each state of the second
    /// has its neighbours among those of the first.
    ///
    /// # Errors
    /// As [`Recurrences::of`].
    pub fn cross(
        first: &DelayVectors<'a>,
        second: &DelayVectors<'a>,
        norm: Norm,
        threshold: Threshold,
    ) -> Result<Self, AnalysisError> {
        let criterion = RecurrenceCriterion {
            norm,
            threshold,
            theiler: 0,
        };
        Self::new([*first, *second], &criterion, false)
    }

    fn new(
        [rows, columns]: [DelayVectors<'a>; 2],
        criterion: &RecurrenceCriterion,
        same: bool,
    ) -> Result<Self, AnalysisError> {
        let &RecurrenceCriterion {
            norm,
            threshold,
            theiler,
        } = criterion;
        let mut found = Self {
            rows,
            columns,
            norm,
            theiler,
            same,
            distance: None,
            limits: Vec::new(),
        };
        let invalid = |what| Err(AnalysisError::Threshold { what });
        let distance = match threshold {
            Threshold::Distance(distance) if distance >= 0.0 => distance,
            Threshold::Spread(times) if times >= 0.0 && times.is_finite() => {
                times * deviation(rows.samples())
            }
            Threshold::Rate(rate) if (0.0..=1.0).contains(&rate) => {
                norm.distance_of_unrooted(found.quantile(rate))
            }
            Threshold::Neighbours(count) if count > 0 => {
                let limit = |j| found.nearest(count, j);
                found.limits = (0..columns.len()).into_par_iter().map(limit).collect();
                found.limits.resize(columns.len() + 64, 0.0);
                return Ok(found);
            }
            Threshold::Distance(_) => return invalid("the distance must be at least 0"),
            Threshold::Spread(_) => return invalid("the spread must be finite and at least 0"),
            Threshold::Rate(_) => return invalid("the rate must be from 0 to 1"),
            Threshold::Neighbours(_) => {
                return invalid("the number of neighbours must be at least 1");
            }
        };
        found.distance = Some(distance);
        found.limits = vec![norm.unrooted_limit(distance); columns.len() + 64];
        Ok(found)
    }

    /// The unrooted distance that contains `count` rows outside the Theiler window of column `j`, or all of them if
    /// there are fewer.
    fn nearest(&self, count: usize, j: usize) -> f64 {
        let all = 0..self.rows.len();
        let mut distances = distances(self.norm, &self.rows, all, self.columns.vector(j));
        if self.same {
            let gap = self.theiler.max(1);
            distances
                .drain((j + 1).saturating_sub(gap)..j.saturating_add(gap).min(distances.len()));
        }
        order_statistic(distances, count)
    }

    /// The unrooted distance for a recurrence rate, as defined in [`Recurrences::of`]: a histogram of the leading 16 bits tells
    /// those of the distance, and only distances with these are kept. If they are too many, the next 16 bits follow.
    fn quantile(&self, rate: f64) -> f64 {
        let [rows, columns] = [self.rows, self.columns].map(|states| states.len());
        let gap = self.theiler.max(1);
        let first = |i: usize| if self.same { i.saturating_add(gap) } else { 0 };
        let counted = |i: usize| first(i).min(columns)..columns;
        let row = |i: usize| {
            if self.rows.is_stopped() {
                Vec::new()
            } else {
                distances(self.norm, &self.columns, counted(i), self.rows.vector(i))
            }
        };
        // Numbers of at least 0 are ordered as their bits are. The known leading bits, and the number of unknown ones.
        let (mut leading, mut unknown) = (0, u64::BITS);
        let mut wanted = None;
        loop {
            let has_leading =
                move |d: &f64| d.to_bits().checked_shr(unknown).unwrap_or(0) == leading;
            let rest = unknown - 16;
            let enter = |mut histogram: Vec<u64>, i: usize| {
                for distance in row(i).iter().filter(|d| has_leading(d)) {
                    histogram[(distance.to_bits() >> rest) as usize & 0xffff] += 1;
                }
                histogram
            };
            let sum = |mut a: Vec<u64>, b: Vec<u64>| {
                a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                a
            };
            let empty = || vec![0; 1 << 16];
            let histogram = (0..rows).into_par_iter().fold(empty, enter);
            let histogram = histogram.reduce(empty, sum);
            let wanted = wanted.get_or_insert_with(|| {
                let pairs = histogram.iter().sum::<u64>() as f64;
                // The line of identity is recurrent at any distance.
                let identity = if self.same && self.theiler == 0 {
                    rows as f64
                } else {
                    0.0
                };
                (0.5 * (rate * (2.0 * pairs + identity) - identity)).round() as u64
            });
            let mut class = 0;
            while class < 0xffff && *wanted > histogram[class] {
                *wanted -= histogram[class];
                class += 1;
            }
            (leading, unknown) = (leading << 16 | class as u64, rest);
            if unknown == 0 {
                return f64::from_bits(leading);
            }
            if histogram[class] <= MAX_KEPT {
                let of_class = |i| {
                    row(i)
                        .into_iter()
                        .filter(move |d| d.to_bits() >> rest == leading)
                };
                let kept: Vec<f64> = (0..rows).into_par_iter().flat_map_iter(of_class).collect();
                return order_statistic(kept, *wanted as usize);
            }
        }
    }
}

#[cfg(test)]
#[path = "threshold_tests.rs"]
mod tests;
