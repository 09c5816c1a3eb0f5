//! Measures of recurrence quantification analysis, computed from counts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{LineHistogram, RecurrenceCounts};
use crate::stats::trend;

/// Number of pairs that the recurrence rate refers to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RateBase {
    /// Pairs outside the Theiler window.
    #[default]
    Counted,
    /// All `N^2` pairs (rows times columns).
    All,
}

/// Measures of recurrence quantification analysis (Marwan et al., Phys. Rep. 438, 237, 2007). `None` if
/// the measure is undefined.
///
/// `P(l)` is the number of diagonal lines of length `l`, `P(v)` that of vertical lines of length `v`, as
/// defined in [`RecurrenceCounts`]. Sums start at `l_min` or `v_min` unless stated otherwise.
///
/// Lengths and times are counted in states. [`in_seconds`](Measures::in_seconds) converts them to times,
/// the unit used in output.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Measures {
    /// Recurrence rate RR: recurrent points over pairs, 0 to 1; 0 without pairs.
    pub recurrence_rate: f64,
    /// Determinism `DET = sum l P(l) / recurrent points`: share of recurrent points on diagonal lines, 0
    /// to 1.
    pub determinism: Option<f64>,
    /// Mean diagonal line length `L = sum l P(l) / sum P(l)`, states (s in output): mean time over which
    /// two sections of the trajectory stay close.
    #[serde(rename = "mean_diagonal_s")]
    pub mean_diagonal: Option<f64>,
    /// Length of the longest diagonal line `Lmax`, states (s in output); 0 without lines. The line of
    /// identity counts only with a Theiler window of 0.
    #[serde(rename = "longest_diagonal_s")]
    pub longest_diagonal: f64,
    /// Divergence `DIV = 1 / Lmax`, 1/states (1/s in output).
    #[serde(rename = "divergence_per_s")]
    pub divergence: Option<f64>,
    /// Shannon entropy of the diagonal line lengths, `ENTR = -sum p(l) ln p(l)` with
    /// `p(l) = P(l) / sum P(l)`, nats.
    #[serde(rename = "entropy_nats")]
    pub entropy: Option<f64>,
    /// TREND: slope of the recurrence rate along the diagonal, `RR_k = by_offset[k] / (N - k)`, over the
    /// offset `k`, per thousand states. A non-zero value indicates drift. It is fitted by least
    /// squares from the first counted offset beyond the line of identity. The last tenth of the offsets,
    /// with short diagonals, is excluded (Webber and Zbilut, 2005).
    #[serde(rename = "trend_per_1000_states")]
    pub trend: Option<f64>,
    /// Laminarity `LAM = sum v P(v) / recurrent points`: share of recurrent points on vertical lines, 0
    /// to 1.
    pub laminarity: Option<f64>,
    /// Trapping time `TT = sum v P(v) / sum P(v)`, states (s in output): mean time over which a state
    /// hardly changes.
    #[serde(rename = "trapping_time_s")]
    pub trapping_time: Option<f64>,
    /// Length of the longest vertical line `Vmax`, states (s in output); 0 without lines.
    #[serde(rename = "longest_vertical_s")]
    pub longest_vertical: f64,
    /// Mean recurrence time of the first type: from a recurrent point of a column to the next, states
    /// (s in output).
    #[serde(rename = "recurrence_time_1_s")]
    pub recurrence_time_1: Option<f64>,
    /// Mean recurrence time of the second type: from the start of a vertical line to the start of the
    /// next, states (s in output).
    #[serde(rename = "recurrence_time_2_s")]
    pub recurrence_time_2: Option<f64>,
}

impl Measures {
    /// Converts lengths to times. `state` is the time between successive states, s. The trend stays per
    /// thousand states.
    pub fn in_seconds(self, state: f64) -> Self {
        let time = |states: Option<f64>| states.map(|states| states * state);
        Self {
            mean_diagonal: time(self.mean_diagonal),
            longest_diagonal: self.longest_diagonal * state,
            divergence: self.divergence.map(|per_state| per_state / state),
            trapping_time: time(self.trapping_time),
            longest_vertical: self.longest_vertical * state,
            recurrence_time_1: time(self.recurrence_time_1),
            recurrence_time_2: time(self.recurrence_time_2),
            ..self
        }
    }
}

impl RecurrenceCounts {
    /// Computes the measures from diagonal lines of at least `min_diagonal` points (`l_min`) and
    /// vertical lines of at least `min_vertical` points (`v_min`). Both are usually 2.
    pub fn measures(&self, min_diagonal: usize, min_vertical: usize, base: RateBase) -> Measures {
        let pairs = match base {
            RateBase::Counted => self.pairs(),
            RateBase::All => self.rows as u64 * self.columns as u64,
        };
        let (diagonals, diagonal_points, entropy) = totals(&self.diagonal, min_diagonal);
        let (verticals, vertical_points, _) = totals(&self.vertical, min_vertical);
        let longest_diagonal = self.diagonal.longest();
        // The distance to the next point is 1 within a line and `g + 1` across a gap of `g`.
        let within = self.recurrent - self.vertical.lines();
        let gaps = self.gaps.lines();
        Measures {
            recurrence_rate: ratio(self.recurrent, pairs).unwrap_or(0.0),
            determinism: ratio(diagonal_points, self.recurrent),
            mean_diagonal: ratio(diagonal_points, diagonals),
            longest_diagonal: longest_diagonal as f64,
            divergence: ratio(1, longest_diagonal as u64),
            entropy,
            trend: self.trend(),
            laminarity: ratio(vertical_points, self.recurrent),
            trapping_time: ratio(vertical_points, verticals),
            longest_vertical: self.vertical.longest() as f64,
            recurrence_time_1: ratio(within + self.gaps.points() + gaps, within + gaps),
            recurrence_time_2: ratio(
                self.recurrence_times.points(),
                self.recurrence_times.lines(),
            ),
        }
    }

    /// Number of pairs outside the Theiler window, both triangles.
    pub fn pairs(&self) -> u64 {
        let diagonal = |offset, from: usize, to: usize| from.min(to - offset) as u64;
        let right = (self.theiler..self.columns).map(|k| diagonal(k, self.rows, self.columns));
        let left = self.theiler.max(1)..self.rows;
        let left = left.map(|k| diagonal(k, self.columns, self.rows));
        right.chain(left).sum()
    }

    /// Recurrence rate along the diagonal `j - i = offset`, 0 to 1; 0 for an empty diagonal.
    pub fn rate_at(&self, offset: usize) -> f64 {
        let length = self.columns.saturating_sub(offset).min(self.rows);
        let recurrent = self.by_offset.get(offset).copied().unwrap_or(0);
        ratio(recurrent, length as u64).unwrap_or(0.0)
    }

    /// Counted offsets beyond the line of identity, without the short diagonals at the end.
    pub(super) fn reliable_offsets(&self) -> std::ops::Range<usize> {
        self.theiler.max(1)..(9 * self.columns).div_ceil(10)
    }

    fn trend(&self) -> Option<f64> {
        let offsets = self.reliable_offsets();
        if offsets.len() < 2 {
            return None;
        }
        let rates: Vec<f64> = offsets.map(|k| self.rate_at(k)).collect();
        Some(1000.0 * trend(&rates)[0])
    }
}

/// Number of the lines of at least a minimum length, number of their points, and entropy of their lengths.
fn totals(all: &LineHistogram, min_length: usize) -> (u64, u64, Option<f64>) {
    let long = || all.iter().filter(|&(length, _)| length >= min_length);
    let lines = long().map(|(_, count)| count).sum();
    let points = long().map(|(length, count)| length as u64 * count).sum();
    let information = |(_, count)| {
        let share = count as f64 / lines as f64;
        -share * share.ln()
    };
    // An empty sum is -0, which would print with its sign.
    let entropy = (lines > 0).then(|| 0.0 + long().map(information).sum::<f64>());
    (lines, points, entropy)
}

/// Ratio of two counts; `None` for a denominator of 0.
fn ratio(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::super::counts::tests::hand_drawn;
    use super::*;

    #[test]
    fn the_hand_drawn_matrix_has_the_published_measures() {
        let all = hand_drawn(0).measures(1, 1, RateBase::Counted);
        assert_eq!(all.recurrence_rate, 33.0 / 110.0);
        assert_eq!(all.determinism, Some(1.0));
        assert_eq!(all.mean_diagonal, Some(33.0 / 20.0));
        assert_eq!(all.longest_diagonal, 5.0);
        assert_eq!(all.divergence, Some(0.2));
        assert!((all.entropy.unwrap() - 0.996).abs() < 1e-3);
        assert_eq!(all.laminarity, Some(1.0));
        assert_eq!(all.trapping_time, Some(33.0 / 23.0));
        assert_eq!(all.longest_vertical, 3.0);
        // Computed from the gaps and recurrence times counted by hand.
        assert_eq!(all.recurrence_time_1, Some((10 + 25 + 12) as f64 / 22.0));
        assert_eq!(all.recurrence_time_2, Some(43.0 / 12.0));

        let two = hand_drawn(0).measures(2, 2, RateBase::All);
        assert_eq!(two.recurrence_rate, 33.0 / 110.0);
        assert_eq!(two.determinism, Some(22.0 / 33.0));
        assert_eq!(two.mean_diagonal, Some(22.0 / 9.0));
        assert!((two.entropy.unwrap() - 0.684).abs() < 1e-3);
        assert_eq!(two.laminarity, Some(18.0 / 33.0));
        assert_eq!(two.trapping_time, Some(18.0 / 8.0));
    }

    #[test]
    fn the_hand_drawn_matrix_with_a_theiler_window_has_the_published_measures() {
        let counts = hand_drawn(2);
        let two = counts.measures(2, 2, RateBase::All);
        assert_eq!(two.recurrence_rate, 22.0 / 110.0);
        assert_eq!(two.determinism, Some(13.0 / 22.0));
        assert_eq!(two.mean_diagonal, Some(13.0 / 5.0));
        assert_eq!(two.longest_diagonal, 5.0);
        assert!((two.entropy.unwrap() - 0.5).abs() < 1e-3);
        assert_eq!(two.laminarity, Some(12.0 / 22.0));
        assert_eq!(two.trapping_time, Some(12.0 / 5.0));
        let one = counts.measures(1, 1, RateBase::Counted);
        assert!((one.entropy.unwrap() - 0.830).abs() < 1e-3);
        // Three diagonals of 10, 10 and 9 points are excluded.
        assert_eq!(one.recurrence_rate, 22.0 / 81.0);
    }

    #[test]
    fn pairs_match_a_full_plot() {
        for (rows, columns) in [(0, 0), (1, 1), (7, 7), (4, 9), (9, 4)] {
            for theiler in [0, 1, 2, 5, 20] {
                let counts = RecurrenceCounts::of_matrix(rows, columns, theiler, |_, _| true);
                assert_eq!(
                    counts.pairs(),
                    counts.recurrent,
                    "{rows} {columns} {theiler}"
                );
                let rate = counts.measures(2, 2, RateBase::Counted).recurrence_rate;
                assert_eq!(rate, if counts.recurrent > 0 { 1.0 } else { 0.0 });
            }
        }
    }

    #[test]
    fn trend_is_the_slope_per_thousand_samples() {
        // Rates along the diagonals 1, 2 and 3: 1, 1/2 and 0.
        let counts = RecurrenceCounts {
            rows: 4,
            columns: 4,
            theiler: 1,
            by_offset: vec![0, 3, 1, 0],
            ..RecurrenceCounts::default()
        };
        assert_eq!(counts.trend(), Some(-500.0));
        let full = RecurrenceCounts::of_matrix(50, 50, 1, |_, _| true);
        assert!(full.trend().unwrap().abs() < 1e-12);
        assert_eq!(
            RecurrenceCounts::of_matrix(2, 2, 1, |_, _| true).trend(),
            None
        );
    }

    #[test]
    fn an_empty_plot_has_undefined_measures() {
        let counts = RecurrenceCounts::of_matrix(6, 6, 1, |_, _| false);
        let expected = Measures {
            trend: Some(0.0),
            ..Measures::default()
        };
        assert_eq!(counts.measures(2, 2, RateBase::Counted), expected);
        let nothing = RecurrenceCounts::default();
        assert_eq!(
            nothing.measures(2, 2, RateBase::Counted),
            Measures::default()
        );
    }
}
