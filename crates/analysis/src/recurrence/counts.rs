//! Counts of a recurrence plot: recurrent points, and lines by length.

use std::ops::Range;

use rayon::prelude::*;

use super::Recurrences;

/// Histogram of the line lengths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineHistogram {
    /// `counts[l]` lines of length `l`, up to the longest.
    counts: Vec<u64>,
}

impl LineHistogram {
    /// Lengths that occur, with their numbers, shortest first.
    pub fn iter(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let all = self.counts.iter().copied().enumerate();
        all.filter(|&(_, count)| count > 0)
    }

    fn add(&mut self, length: usize, count: u64) {
        if self.counts.len() <= length {
            self.counts.resize(length + 1, 0);
        }
        self.counts[length] += count;
    }

    /// Number of lines.
    pub fn lines(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Sum of all lengths.
    pub fn points(&self) -> u64 {
        self.iter()
            .map(|(length, count)| length as u64 * count)
            .sum()
    }

    /// Length of the longest line; 0 for no lines.
    pub fn longest(&self) -> usize {
        self.counts.len().saturating_sub(1)
    }
}

/// All counts of a recurrence plot. They are exact: every pair is compared, and every line is counted.
///
/// # Definitions
///
/// *Recurrent pairs.* `R_ij = 1` if `d(y_i, y_j) <= epsilon`, with row `i` and column `j`. A pair
/// exactly at the threshold is recurrent. The distance is computed in double precision, coordinate by
/// coordinate from the oldest (`t_c = y_i[c] - y_j[c]`, each operation rounded separately, no fused
/// multiply-add):
///
/// | norm | recurrent if |
/// |---|---|
/// | Euclidean | `((t_0 t_0 + t_1 t_1) + t_2 t_2) + ... <= epsilon epsilon` |
/// | maximum | the largest `\|t_c\| <= epsilon` |
/// | Manhattan | `((\|t_0\| + \|t_1\|) + \|t_2\|) + ... <= epsilon` |
///
/// *Theiler window* `w` (Theiler, Phys. Rev. A 34, 2427, 1986). Pairs with `|i - j| < w` are excluded:
/// they are not recurrent points, they end lines and belong to none. `w = 0` excludes nothing. `w = 1`,
/// the usual choice, excludes the line of identity, which is recurrent for every signal and would make
/// every signal look deterministic over its full length.
///
/// *Diagonal lines* are the longest unbroken runs of recurrent pairs along `j - i = k`, for positive and
/// negative `k`. Both triangles count, so each line occurs twice in a symmetric plot; the line of
/// identity, if included, occurs once.
///
/// *Vertical lines* are the longest unbroken runs of recurrent pairs in a column `j`, over all rows `i`.
///
/// *Gaps* (white vertical lines) are the runs of non-recurrent pairs in a column between successive
/// vertical lines. A run that touches the edge of the plot or the Theiler window is not counted because
/// its full length is unknown.
///
/// *Recurrence times* (Gao, Phys. Rev. Lett. 83, 3178, 1999; Marwan et al., Phys. Rep. 438, 237, 2007).
/// The first type, `T1`, is the time from a recurrent point of a column to the next, 1 within a line.
/// The second type, `T2`, is the time from the start of a vertical line to the start of the next: the
/// time between entries into the neighbourhood. Both are counted only across gaps as defined above.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecurrenceCounts {
    /// Rows `i`: the number of states `N`.
    pub rows: usize,
    /// Columns `j`: `N`, except for a cross recurrence plot of two signals.
    pub columns: usize,
    /// Theiler window: pairs with `|i - j|` below it are not counted.
    pub theiler: usize,
    /// Recurrent points outside the Theiler window, both triangles.
    pub recurrent: u64,
    /// Diagonal lines, both triangles.
    pub diagonal: LineHistogram,
    /// Vertical lines.
    pub vertical: LineHistogram,
    /// Gaps between vertical lines (white vertical lines).
    pub gaps: LineHistogram,
    /// Recurrence times of the second type: from the start of a vertical line to the start of the next,
    /// across one gap.
    pub recurrence_times: LineHistogram,
    /// Recurrent points on the diagonals `j - i = k`, `k = 0, 1, ..., columns - 1` (upper triangle); 0
    /// within the Theiler window.
    pub by_offset: Vec<u64>,
}

impl RecurrenceCounts {
    fn append(mut self, other: Self) -> Self {
        for (sum, lines) in [
            (&mut self.diagonal, &other.diagonal),
            (&mut self.vertical, &other.vertical),
            (&mut self.gaps, &other.gaps),
            (&mut self.recurrence_times, &other.recurrence_times),
        ] {
            lines
                .iter()
                .for_each(|(length, count)| sum.add(length, count));
        }
        self.by_offset.extend(other.by_offset);
        self
    }
}

impl Recurrences<'_> {
    /// Counts the points and lines.
    ///
    /// Columns and diagonals are compared one by one and not stored: time is proportional to the number of
    /// pairs, memory to the number of states. The computation uses all cores; the counts do not depend on
    /// their number.
    pub fn counts(&self) -> RecurrenceCounts {
        let [rows, columns] = [self.rows, self.columns].map(|states| states.len());
        let vertical = self.count(0..columns, |counts, bits, j| {
            for rows in self.rows_beyond(self.theiler, j) {
                self.compare(self.column(j, rows), bits);
                let mut last = None;
                each_run(bits, |begin, end| {
                    counts.vertical.add(end - begin, 1);
                    if let Some((last_begin, last_end)) = last.replace((begin, end)) {
                        counts.gaps.add(begin - last_end, 1);
                        counts.recurrence_times.add(begin - last_begin, 1);
                    }
                });
            }
        });
        // Both triangles of a symmetric plot have the same diagonals.
        let symmetric = self.same && self.distance.is_some();
        let upper = self.count(self.theiler..columns, |counts, bits, k| {
            self.compare(self.diagonal([0, k]), bits);
            let lines = if symmetric && k > 0 { 2 } else { 1 };
            each_run(bits, |begin, end| counts.diagonal.add(end - begin, lines));
            let points = bits.iter().map(|word| u64::from(word.count_ones()));
            counts.by_offset.push(points.sum());
        });
        let lower = if symmetric { 0 } else { rows };
        let lower = self.count(self.theiler.max(1)..lower, |counts, bits, k| {
            self.compare(self.diagonal([k, 0]), bits);
            each_run(bits, |begin, end| counts.diagonal.add(end - begin, 1));
        });
        let counts = RecurrenceCounts {
            rows,
            columns,
            theiler: self.theiler,
            recurrent: vertical.vertical.points(),
            by_offset: vec![0; self.theiler.min(columns)],
            ..RecurrenceCounts::default()
        };
        counts.append(vertical).append(upper).append(lower)
    }

    /// Counts lines one by one, with a workspace for their bits.
    fn count(
        &self,
        lines: Range<usize>,
        add: impl Fn(&mut RecurrenceCounts, &mut Vec<u64>, usize) + Sync,
    ) -> RecurrenceCounts {
        let new = <(RecurrenceCounts, Vec<u64>)>::default;
        lines
            .into_par_iter()
            .fold(new, |(mut counts, mut bits), line| {
                if !self.rows.is_stopped() {
                    add(&mut counts, &mut bits, line);
                }
                (counts, bits)
            })
            .map(|(counts, _)| counts)
            .reduce(RecurrenceCounts::default, RecurrenceCounts::append)
    }
}

/// Calls `take` with the begin and end (exclusive) of the runs of set bits, in order.
#[inline(always)]
fn each_run(bits: &[u64], mut take: impl FnMut(usize, usize)) {
    let (mut begin, mut open) = (0, 0);
    for (word, &bits) in bits.iter().enumerate() {
        let mut changes = bits ^ (bits << 1 | open);
        while changes != 0 {
            let bit = changes.trailing_zeros() as usize;
            if bits >> bit & 1 == 1 {
                begin = 64 * word + bit;
            } else {
                take(begin, 64 * word + bit);
            }
            changes &= changes - 1;
        }
        open = bits >> 63;
    }
    if open == 1 {
        take(begin, 64 * bits.len());
    }
}

#[cfg(test)]
#[path = "counts_tests.rs"]
pub(super) mod tests;
