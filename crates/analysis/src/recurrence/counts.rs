//! Counts of a recurrence plot: recurrent points, and lines by length.

/// Histogram of the line lengths.
///
/// ```
/// use squeakscope_analysis::LineHistogram;
///
/// let lines = LineHistogram::from(vec![0, 1, 0, 2]);
/// assert_eq!(lines.iter().collect::<Vec<_>>(), [(1, 1), (3, 2)]);
/// assert_eq!((lines.lines(), lines.points(), lines.longest()), (3, 7, 3));
/// ```
#[derive(Clone, Debug, Default)]
pub struct LineHistogram {
    /// `counts[l]` lines of length `l`. `counts[0]` is zero or absent.
    counts: Vec<u64>,
}

impl LineHistogram {
    /// Lengths that occur, with their numbers, shortest first.
    pub fn iter(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let all = self.counts.iter().copied().enumerate();
        all.filter(|&(_, count)| count > 0)
    }

    /// Adds a line. Ignores length 0.
    fn add(&mut self, length: usize) {
        if length == 0 {
            return;
        }
        if self.counts.len() <= length {
            self.counts.resize(length + 1, 0);
        }
        self.counts[length] += 1;
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
        let counts = &self.counts;
        counts.iter().rposition(|&count| count > 0).unwrap_or(0)
    }
}

/// Histograms are equal if they contain the same lines.
impl PartialEq for LineHistogram {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Eq for LineHistogram {}

/// From the number of lines of each length, indexed by length. Index 0 is ignored.
impl From<Vec<u64>> for LineHistogram {
    fn from(mut counts: Vec<u64>) -> Self {
        if let Some(zero) = counts.first_mut() {
            *zero = 0;
        }
        Self { counts }
    }
}

/// All counts of a recurrence plot. They are integers, so all algorithms agree to the last bit.
///
/// # Definitions
///
/// *Recurrent pairs.* `R_ij = 1` if `d(y_i, y_j) <= epsilon`, with row `i` and column `j`. A pair
/// exactly at the threshold is recurrent. All algorithms classify every pair equally because they
/// compute the distance in double precision, coordinate by coordinate from the oldest
/// (`t_c = y_i[c] - y_j[c]`, each operation rounded separately, no fused multiply-add):
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
    /// Counts a plot given point by point: `recurrent(i, j)` for row `i` and column `j`. The plot may be
    /// rectangular and asymmetric.
    ///
    /// This is the definition in code, which the faster algorithm of one signal is tested against.
    pub fn of_matrix(
        rows: usize,
        columns: usize,
        theiler: usize,
        recurrent: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let mut counts = Self {
            rows,
            columns,
            theiler,
            by_offset: vec![0; columns],
            ..Self::default()
        };
        let outside = |i: usize, j: usize| i.abs_diff(j) >= theiler;
        let counted = |i: usize, j: usize| outside(i, j) && recurrent(i, j);

        for i in 0..rows {
            for j in (0..columns).filter(|&j| counted(i, j)) {
                counts.recurrent += 1;
                if let Some(offset) = j.checked_sub(i) {
                    counts.by_offset[offset] += 1;
                }
            }
        }

        let left_edge = (1..rows).map(|i| (i, 0));
        let top_edge = (0..columns).map(|j| (0, j));
        for (i, j) in left_edge.chain(top_edge) {
            let mut length = 0;
            for step in 0..(rows - i).min(columns - j) {
                if counted(i + step, j + step) {
                    length += 1;
                } else {
                    counts.diagonal.add(length);
                    length = 0;
                }
            }
            counts.diagonal.add(length);
        }

        for j in 0..columns {
            // Start and end (exclusive) of the last line of the column. The Theiler window separates the
            // parts above and below it.
            let mut last: Option<(usize, usize)> = None;
            for i in 0..rows {
                if !outside(i, j) {
                    last = None;
                } else if recurrent(i, j) {
                    match &mut last {
                        Some((_, end)) if *end == i => *end += 1,
                        _ => {
                            if let Some((begin, end)) = last {
                                counts.gaps.add(i - end);
                                counts.recurrence_times.add(i - begin);
                            }
                            last = Some((i, i + 1));
                        }
                    }
                    if i + 1 == rows || !counted(i + 1, j) {
                        let (begin, end) = last.expect("a line has started");
                        counts.vertical.add(end - begin);
                    }
                }
            }
        }
        counts
    }
}

#[cfg(test)]
#[path = "counts_tests.rs"]
pub(super) mod tests;
