//! Recurrence quantification: measures from counts.

use super::{LineHistogram, RecurrenceCounts};

/// Which pairs the recurrence rate is a share of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RateBase {
    /// Those outside the Theiler window: the ones that are counted.
    #[default]
    Counted,
    /// All `N^2` (rows times columns).
    All,
}

/// Measures of recurrence quantification analysis (Marwan et al., Phys. Rep. 438, 237, 2007).
/// `None` where there is nothing to measure.
///
/// `P(l)` is the number of diagonal lines of length `l`, `P(v)` that of vertical lines of length
/// `v`, as defined with [`RecurrenceCounts`]; sums from `l_min` or `v_min` on unless said
/// otherwise.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Measures {
    /// Recurrence rate RR: recurrent points over pairs, 0 to 1; 0 if there is no pair.
    pub recurrence_rate: f64,
    /// Determinism `DET = sum l P(l) / recurrent points`: the share that lies on diagonal lines,
    /// 0 to 1.
    pub determinism: Option<f64>,
    /// Mean diagonal line `L = sum l P(l) / sum P(l)`, samples: for how long two pieces of the
    /// motion run alongside.
    pub mean_diagonal: Option<f64>,
    /// Longest diagonal line `Lmax` of any length, samples; the line of identity counts only with
    /// a Theiler window of 0. 0 if there is none.
    pub longest_diagonal: usize,
    /// Divergence `DIV = 1 / Lmax`, 1/samples.
    pub divergence: Option<f64>,
    /// Shannon entropy of the diagonal lengths, `ENTR = -sum p(l) ln p(l)` with
    /// `p(l) = P(l) / sum P(l)`, nats.
    pub entropy: Option<f64>,
    /// TREND: slope of the recurrence rate along the diagonal, `RR_k = by_offset[k] / (N - k)`,
    /// over the offset `k`, per thousand samples; away from 0 the signal drifts. Straight line of
    /// least squares from the first counted offset beyond the line of identity on; the last tenth
    /// of the offsets, whose diagonals are short, is left out (Webber and Zbilut, 2005).
    pub trend: Option<f64>,
    /// Laminarity `LAM = sum v P(v) / recurrent points`: the share that lies on vertical lines, 0
    /// to 1.
    pub laminarity: Option<f64>,
    /// Trapping time `TT = sum v P(v) / sum P(v)`, samples: for how long a state hardly changes.
    pub trapping_time: Option<f64>,
    /// Longest vertical line `Vmax` of any length, samples; 0 if there is none.
    pub longest_vertical: usize,
    /// Mean recurrence time of the first type, from a recurrent point of a column to the next,
    /// samples.
    pub recurrence_time_1: Option<f64>,
    /// Mean recurrence time of the second type, from the beginning of a vertical line to that of
    /// the next, samples.
    pub recurrence_time_2: Option<f64>,
}

impl RecurrenceCounts {
    /// The measures, from diagonal lines of at least `least_diagonal` points (`l_min`) and
    /// vertical ones of at least `least_vertical` (`v_min`); 2 is usual for both.
    pub fn measures(
        &self,
        least_diagonal: usize,
        least_vertical: usize,
        base: RateBase,
    ) -> Measures {
        let pairs = match base {
            RateBase::Counted => self.pairs(),
            RateBase::All => self.rows as u64 * self.columns as u64,
        };
        let diagonal = Lines::of(&self.diagonal, least_diagonal);
        let vertical = Lines::of(&self.vertical, least_vertical);
        let longest_diagonal = self.diagonal.longest();
        // Within a line the next point is 1 away, across a gap of `g` it is `g + 1` away.
        let within = self.recurrent - self.vertical.lines();
        let gaps = self.gaps.lines();
        Measures {
            recurrence_rate: ratio(self.recurrent, pairs).unwrap_or(0.0),
            determinism: ratio(diagonal.points, self.recurrent),
            mean_diagonal: ratio(diagonal.points, diagonal.lines),
            longest_diagonal,
            divergence: ratio(1, longest_diagonal as u64),
            entropy: diagonal.entropy,
            trend: self.trend(),
            laminarity: ratio(vertical.points, self.recurrent),
            trapping_time: ratio(vertical.points, vertical.lines),
            longest_vertical: self.vertical.longest(),
            recurrence_time_1: ratio(within + self.gaps.points() + gaps, within + gaps),
            recurrence_time_2: ratio(self.returns.points(), self.returns.lines()),
        }
    }

    /// The pairs outside the Theiler window, both triangles.
    pub fn pairs(&self) -> u64 {
        let diagonal = |offset, from: usize, to: usize| from.min(to - offset) as u64;
        let right = (self.theiler..self.columns).map(|k| diagonal(k, self.rows, self.columns));
        let left = self.theiler.max(1)..self.rows;
        let left = left.map(|k| diagonal(k, self.columns, self.rows));
        right.chain(left).sum()
    }

    /// The recurrence rate along the diagonal `j - i = offset`, 0 to 1; 0 if it has no point.
    pub fn rate_at(&self, offset: usize) -> f64 {
        let length = self.columns.saturating_sub(offset).min(self.rows);
        let recurrent = self.by_offset.get(offset).copied().unwrap_or(0);
        ratio(recurrent, length as u64).unwrap_or(0.0)
    }

    /// Offsets beyond the line of identity that are counted and whose diagonals are not short.
    pub(super) fn reliable_offsets(&self) -> std::ops::Range<usize> {
        self.theiler.max(1)..(9 * self.columns).div_ceil(10)
    }

    fn trend(&self) -> Option<f64> {
        let offsets = self.reliable_offsets();
        if offsets.len() < 2 {
            return None;
        }
        let middle = 0.5 * (offsets.start + offsets.end - 1) as f64;
        let (mut product, mut square) = (0.0, 0.0);
        for k in offsets {
            let distance = k as f64 - middle;
            product += distance * self.rate_at(k);
            square += distance * distance;
        }
        Some(1000.0 * product / square)
    }
}

/// What lines of at least a given length come to.
struct Lines {
    lines: u64,
    points: u64,
    entropy: Option<f64>,
}

impl Lines {
    fn of(all: &LineHistogram, least: usize) -> Self {
        let long = || all.iter().filter(|&(length, _)| length >= least);
        let lines = long().map(|(_, count)| count).sum();
        let information = |(_, count)| {
            let share = count as f64 / lines as f64;
            -share * share.ln()
        };
        Self {
            lines,
            points: long().map(|(length, count)| length as u64 * count).sum(),
            // A sum that starts at -0, as an empty one does, would show its sign.
            entropy: (lines > 0).then(|| 0.0 + long().map(information).sum::<f64>()),
        }
    }
}

/// `None` over nothing.
fn ratio(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::super::counts::tests::hand_drawn;
    use super::*;

    #[test]
    fn measures_of_the_hand_drawn_matrix_are_the_published_ones() {
        let all = hand_drawn(0).measures(1, 1, RateBase::Counted);
        assert_eq!(all.recurrence_rate, 33.0 / 110.0);
        assert_eq!(all.determinism, Some(1.0));
        assert_eq!(all.mean_diagonal, Some(33.0 / 20.0));
        assert_eq!(all.longest_diagonal, 5);
        assert_eq!(all.divergence, Some(0.2));
        assert!((all.entropy.unwrap() - 0.996).abs() < 1e-3);
        assert_eq!(all.laminarity, Some(1.0));
        assert_eq!(all.trapping_time, Some(33.0 / 23.0));
        assert_eq!(all.longest_vertical, 3);
        // By hand, from the gaps and returns counted by hand.
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
    fn measures_outside_a_theiler_window_are_the_published_ones() {
        let counts = hand_drawn(2);
        let two = counts.measures(2, 2, RateBase::All);
        assert_eq!(two.recurrence_rate, 22.0 / 110.0);
        assert_eq!(two.determinism, Some(13.0 / 22.0));
        assert_eq!(two.mean_diagonal, Some(13.0 / 5.0));
        assert_eq!(two.longest_diagonal, 5);
        assert!((two.entropy.unwrap() - 0.5).abs() < 1e-3);
        assert_eq!(two.laminarity, Some(12.0 / 22.0));
        assert_eq!(two.trapping_time, Some(12.0 / 5.0));
        let one = counts.measures(1, 1, RateBase::Counted);
        assert!((one.entropy.unwrap() - 0.830).abs() < 1e-3);
        // Three diagonals of 10, 10 and 9 points are left out.
        assert_eq!(one.recurrence_rate, 22.0 / 81.0);
    }

    #[test]
    fn counted_pairs_are_counted() {
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
    fn an_empty_plot_has_nothing_to_measure() {
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
