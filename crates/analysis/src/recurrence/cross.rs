//! Cross recurrence of two signals.

use super::{RecurrenceCounts, Threshold};
use crate::memory::check;
use crate::{AnalysisError, DelayVectors, Norm, deviation};

/// The cross recurrence plot of two signals: whether state `i` of one recurs as state `j` of the other. All pairs count.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossRecurrence {
    /// States of the first signal.
    pub rows: usize,
    /// States of the second one.
    pub columns: usize,
    /// Whether two states are recurrent, row by row.
    pub recurrent: Vec<bool>,
    /// Distance of the threshold; `None` for a separate one per column ([`Threshold::Neighbours`]).
    pub distance: Option<f64>,
}

impl CrossRecurrence {
    /// Compares all states of two signals of equal dimension. A spread is that of the first signal, a rate that of all
    /// pairs, and each state of the second signal has its neighbours among those of the first.
    ///
    /// # Errors
    /// [`AnalysisError::Threshold`] for a threshold out of range, [`AnalysisError::Memory`] for too many pairs.
    pub fn new(
        first: &DelayVectors<'_>,
        second: &DelayVectors<'_>,
        norm: Norm,
        threshold: Threshold,
    ) -> Result<Self, AnalysisError> {
        let (rows, columns) = (first.len(), second.len());
        // A distance, the copy that is sorted, and the pixel of each pair.
        let pairs = (rows as u64).saturating_mul(columns as u64);
        check(pairs.saturating_mul(17)).map_err(|shortage| AnalysisError::Memory {
            samples: rows + columns,
            shortage,
        })?;
        let unrooted = |i: usize, j: usize| {
            let pair = first.vector(i).zip(second.vector(j));
            norm.unrooted(pair.map(|(a, b)| a - b))
        };
        let pairs = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let all: Vec<f64> = pairs.map(|(i, j)| unrooted(i, j)).collect();
        let nth = |mut values: Vec<f64>, count: usize| {
            let last = count.min(values.len()).checked_sub(1);
            last.map_or(0.0, |last| {
                *values.select_nth_unstable_by(last, f64::total_cmp).1
            })
        };
        let distance = match threshold.check()? {
            Threshold::Distance(distance) => Some(distance),
            Threshold::Spread(times) => Some(times * deviation(first.samples())),
            Threshold::Rate(rate) => {
                let count = (rate * all.len() as f64).round() as usize;
                Some(norm.distance_of_unrooted(nth(all.clone(), count)))
            }
            Threshold::Neighbours(_) => None,
        };
        let limits: Vec<f64> = match (threshold, distance) {
            (Threshold::Neighbours(count), _) => {
                let column = |j: usize| all.iter().skip(j).step_by(columns).copied().collect();
                (0..columns).map(|j| nth(column(j), count)).collect()
            }
            (_, distance) => vec![norm.unrooted_limit(distance.unwrap_or(0.0)); columns],
        };
        let limits = limits.iter().cycle();
        Ok(Self {
            rows,
            columns,
            recurrent: all
                .iter()
                .zip(limits)
                .map(|(d, limit)| d <= limit)
                .collect(),
            distance,
        })
    }

    /// The counts of the plot.
    pub fn counts(&self) -> RecurrenceCounts {
        let recurrent = |i: usize, j: usize| self.recurrent[i * self.columns + j];
        RecurrenceCounts::of_matrix(self.rows, self.columns, 0, recurrent)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RecurrenceCriterion, quantify};
    use super::*;
    use crate::test_signals::noise;

    /// The plot of a signal with itself is its recurrence plot with the line of identity.
    #[test]
    fn a_signal_recurs_with_itself_as_in_its_own_plot() {
        let signal = noise(3, 120, 1.0);
        let vectors = DelayVectors::new(&signal, 2, 3).unwrap();
        for threshold in [
            Threshold::Distance(0.9),
            Threshold::Spread(0.6),
            Threshold::Neighbours(7),
        ] {
            let norm = Norm::Euclidean;
            let cross = CrossRecurrence::new(&vectors, &vectors, norm, threshold).unwrap();
            let rule = RecurrenceCriterion {
                norm,
                threshold,
                theiler: 0,
            };
            let own = quantify(&vectors, &rule).unwrap();
            let neighbours = matches!(threshold, Threshold::Neighbours(_));
            // A state is its own nearest neighbour, which the plot of one signal does not count.
            assert_eq!(cross.counts() == own, !neighbours);
            assert_eq!(
                cross.counts().recurrent,
                if neighbours { 7 * 116 } else { own.recurrent }
            );
        }
    }

    #[test]
    fn a_rate_is_that_of_all_pairs() {
        let (a, b) = (noise(1, 50, 1.0), noise(2, 80, 1.0));
        let [a, b] = [&a, &b].map(|x| DelayVectors::new(x, 1, 1).unwrap());
        let plot = CrossRecurrence::new(&a, &b, Norm::Maximum, Threshold::Rate(0.1)).unwrap();
        assert_eq!((plot.rows, plot.columns), (50, 80));
        assert_eq!(plot.recurrent.iter().filter(|x| **x).count(), 400);
    }
}
