//! What is counted in a recurrence plot: points and lines, by length.

/// How many lines there are of each length.
///
/// ```
/// use squeakscope::analysis::LineHistogram;
///
/// let mut lines: LineHistogram = [3, 3, 1].into_iter().collect();
/// assert_eq!(lines.iter().collect::<Vec<_>>(), [(1, 1), (3, 2)]);
/// assert_eq!((lines.lines(), lines.points(), lines.longest()), (3, 7, 3));
/// // A line of three loses a point.
/// lines.remove(3);
/// lines.add(2);
/// assert_eq!(lines, LineHistogram::from(vec![0, 1, 1, 1]));
/// ```
#[derive(Clone, Debug, Default)]
pub struct LineHistogram {
    /// `counts[l]` lines of length `l`; `counts[0]`, if there, is zero.
    counts: Vec<u64>,
}

impl LineHistogram {
    /// Adds a line; one of length 0 is none.
    pub fn add(&mut self, length: usize) {
        self.add_many(length, 1);
    }

    /// Adds so many lines of the same length.
    pub fn add_many(&mut self, length: usize, lines: u64) {
        if length == 0 {
            return;
        }
        if self.counts.len() <= length {
            self.counts.resize(length + 1, 0);
        }
        self.counts[length] += lines;
    }

    /// Takes a line away; one of length 0 is none.
    ///
    /// # Panics
    /// If there is no line of this length.
    pub fn remove(&mut self, length: usize) {
        if length > 0 {
            let count = self.counts.get_mut(length).filter(|count| **count > 0);
            *count.expect("a line that is taken away has been added") -= 1;
        }
    }

    /// Adds all lines of another histogram.
    pub fn merge(&mut self, other: &Self) {
        if self.counts.len() < other.counts.len() {
            self.counts.resize(other.counts.len(), 0);
        }
        for (sum, count) in self.counts.iter_mut().zip(&other.counts) {
            *sum += count;
        }
    }

    /// Lines of length `l`.
    pub fn of_length(&self, length: usize) -> u64 {
        self.counts.get(length).copied().unwrap_or(0)
    }

    /// All lengths that occur with their number, shortest first.
    pub fn iter(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let all = self.counts.iter().copied().enumerate();
        all.filter(|&(_, count)| count > 0)
    }

    /// The number of lines.
    pub fn lines(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The sum of all lengths.
    pub fn points(&self) -> u64 {
        self.iter()
            .map(|(length, count)| length as u64 * count)
            .sum()
    }

    /// The length of the longest line; 0 if there is none.
    pub fn longest(&self) -> usize {
        let counts = &self.counts;
        counts.iter().rposition(|&count| count > 0).unwrap_or(0)
    }
}

/// Two are equal that hold the same lines.
impl PartialEq for LineHistogram {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Eq for LineHistogram {}

/// From the number of lines of each length, the length being the index; what stands at 0 is
/// ignored.
impl From<Vec<u64>> for LineHistogram {
    fn from(mut counts: Vec<u64>) -> Self {
        if let Some(zero) = counts.first_mut() {
            *zero = 0;
        }
        Self { counts }
    }
}

/// From the lengths of lines.
impl FromIterator<usize> for LineHistogram {
    fn from_iter<I: IntoIterator<Item = usize>>(lengths: I) -> Self {
        let mut lines = Self::default();
        lengths.into_iter().for_each(|length| lines.add(length));
        lines
    }
}

/// All that is counted in a recurrence plot; integers, so that every way of counting agrees to
/// the last bit.
///
/// # Definitions
///
/// *Recurrent pairs.* `R_ij = 1` if `d(y_i, y_j) <= epsilon`: row `i`, column `j`; a pair at
/// exactly the threshold is recurrent. So that a pair is recurrent in every way of counting or in
/// none, the distance is computed in double precision, coordinate by coordinate from the oldest
/// (`t_c = y_i[c] - y_j[c]`, every operation rounded by itself, no fused multiply-add):
///
/// | norm | recurrent if |
/// |---|---|
/// | Euclidean | `((t_0 t_0 + t_1 t_1) + t_2 t_2) + ... <= epsilon epsilon` |
/// | maximum | the largest `\|t_c\| <= epsilon` |
/// | Manhattan | `((\|t_0\| + \|t_1\|) + \|t_2\|) + ... <= epsilon` |
///
/// *Theiler window* `w` (Theiler, Phys. Rev. A 34, 2427, 1986). Pairs with `|i - j| < w` are left
/// out: they are not recurrent points, they break lines and belong to none. `w = 0` keeps
/// everything; `w = 1`, the usual choice, leaves out the line of identity, which is recurrent
/// whatever the signal and would say of every signal that it is deterministic for as long as it
/// lasts.
///
/// *Diagonal lines* are the longest unbroken runs of recurrent pairs along `j - i = k`, for
/// positive and negative `k`: in both triangles, so that each occurs twice in a symmetric plot;
/// the line of identity, if it is kept, once.
///
/// *Vertical lines* are the longest unbroken runs of recurrent pairs down a column `j`, over all
/// rows `i`.
///
/// *Gaps* (white vertical lines) are the runs of non-recurrent pairs in a column between one
/// vertical line and the next; a run that reaches the edge of the plot or into the Theiler window
/// is none, for nobody knows how long it is.
///
/// *Recurrence times* (Gao, Phys. Rev. Lett. 83, 3178, 1999; Marwan et al., Phys. Rep. 438, 237,
/// 2007): of the first type, `T1`, from a recurrent point of a column to the next, 1 within a
/// line; of the second type, `T2`, from the beginning of a vertical line to the beginning of the
/// next: how long until the system *comes back*, once it has left. Both only across gaps as
/// defined above.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecurrenceCounts {
    /// Rows `i`: the number of states, `N`.
    pub rows: usize,
    /// Columns `j`: `N` again, unless two signals are compared (cross recurrence).
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
    /// From the beginning of a vertical line to that of the next, across one gap: recurrence
    /// times of the second type.
    pub returns: LineHistogram,
    /// Recurrent points on the diagonals `j - i = k`, `k = 0, 1, ..., columns - 1` (upper
    /// triangle); 0 within the Theiler window.
    pub by_offset: Vec<u64>,
}

impl RecurrenceCounts {
    /// Counts a plot that is given point by point: `recurrent(i, j)` for row `i` and column `j`.
    /// The plot needs neither be square nor symmetric.
    ///
    /// This is the definition above in code, for plots of one's own and as the reference for all
    /// faster ways; [`quantify`](super::quantify) counts delay vectors.
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
            // The lines of the column so far, from `begin` until before `end`; the Theiler
            // window separates what is above it from what is below.
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
                                counts.returns.add(i - begin);
                            }
                            last = Some((i, i + 1));
                        }
                    }
                    if i + 1 == rows || !counted(i + 1, j) {
                        let (begin, end) = last.expect("a line is open");
                        counts.vertical.add(end - begin);
                    }
                }
            }
        }
        counts
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The hand-drawn matrix of RecurrenceAnalysis.jl (`test/rqa_rna_analytic.jl`), 10 rows by
    /// 11 columns.
    pub fn hand_drawn(theiler: usize) -> RecurrenceCounts {
        const ROWS: [&str; 10] = [
            "x...x...x..",
            ".x.xxx.....",
            ".x..xxx...x",
            "...x...x...",
            "....x...x..",
            ".xx..x.....",
            ".xx..x..x.x",
            ".x....x....",
            "....x...xx.",
            "..x.xx...x.",
        ];
        RecurrenceCounts::of_matrix(10, 11, theiler, |i, j| ROWS[i].as_bytes()[j] == b'x')
    }

    /// Lines of length 1, 2, ...
    fn lines<const L: usize>(counts: [u64; L]) -> LineHistogram {
        LineHistogram::from([&[0], &counts[..]].concat())
    }

    #[test]
    fn hand_drawn_matrix_is_counted_as_published() {
        let counts = hand_drawn(0);
        assert_eq!(counts.recurrent, 33);
        assert_eq!(counts.diagonal, lines([11, 7, 1, 0, 1]));
        assert_eq!(counts.vertical, lines([15, 6, 2]));
        // By hand; the published ones follow another definition.
        assert_eq!(counts.gaps, lines([4, 4, 3, 1]));
        assert_eq!(counts.returns, lines([0, 3, 0, 8, 1]));
        assert_eq!(counts.by_offset, [7, 1, 3, 2, 6, 0, 0, 0, 2, 0, 0]);
        // Every line but the last of a column has a gap after it.
        assert_eq!(counts.gaps.lines() + 11, counts.vertical.lines());
    }

    #[test]
    fn hand_drawn_matrix_with_a_theiler_window_is_counted_as_published() {
        let counts = hand_drawn(2);
        assert_eq!(counts.recurrent, 22);
        assert_eq!(counts.diagonal, lines([9, 4, 0, 0, 1]));
        assert_eq!(counts.vertical, lines([10, 3, 2]));
        assert_eq!(counts.by_offset, [0, 0, 3, 2, 6, 0, 0, 0, 2, 0, 0]);
        // By hand: in columns 3, 9 and 11, counted from 1; in the others the window is between.
        assert_eq!(counts.gaps, lines([1, 1, 2]));
        assert_eq!(counts.returns, lines([0, 1, 0, 3]));
    }

    #[test]
    fn a_full_matrix_is_lines_from_edge_to_edge() {
        let counts = RecurrenceCounts::of_matrix(5, 5, 0, |_, _| true);
        assert_eq!(counts.recurrent, 25);
        assert_eq!(counts.diagonal, lines([2, 2, 2, 2, 1]));
        assert_eq!(counts.vertical, lines([0, 0, 0, 0, 5]));
        assert_eq!(counts.gaps, LineHistogram::default());
        let counts = RecurrenceCounts::of_matrix(5, 5, 1, |_, _| true);
        assert_eq!(counts.recurrent, 20);
        assert_eq!(counts.diagonal, lines([2, 2, 2, 2]));
        assert_eq!(counts.vertical, lines([2, 2, 2, 2]));
        assert_eq!(counts.gaps, LineHistogram::default());
    }

    #[test]
    fn lines_come_and_go() {
        let mut a = lines([3, 0, 1]);
        let b = lines([1, 1]);
        a.merge(&b);
        assert_eq!(a, lines([4, 1, 1]));
        assert_eq!((a.lines(), a.points(), a.longest()), (6, 9, 3));
        a.remove(3);
        assert_eq!(a, lines([4, 1]));
        assert_eq!(a.longest(), 2);
        a.add(0);
        a.remove(0);
        a.add_many(2, 2);
        assert_eq!(a, [2, 1, 2, 1, 1, 1, 2].into_iter().collect());
        assert_eq!(a.of_length(7), 0);
        assert_eq!(LineHistogram::from(vec![9, 4, 3]), a);
        assert_eq!(LineHistogram::default().longest(), 0);
    }

    #[test]
    #[should_panic(expected = "has been added")]
    fn a_line_that_is_not_there_cannot_be_taken_away() {
        lines([0, 1]).remove(1);
    }
}
