use super::*;

impl LineHistogram {
    /// Number of lines of a length.
    pub fn of_length(&self, length: usize) -> u64 {
        self.counts.get(length).copied().unwrap_or(0)
    }

    /// Adds a line unless its length is 0.
    fn add_line(&mut self, length: usize) {
        if length > 0 {
            self.add(length, 1);
        }
    }
}

impl RecurrenceCounts {
    /// Counts a plot given point by point: `recurrent(i, j)` for row `i` and column `j`. The plot may be
    /// rectangular and asymmetric.
    ///
    /// This is the definition in code.
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
                    counts.diagonal.add_line(length);
                    length = 0;
                }
            }
            counts.diagonal.add_line(length);
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
                                counts.gaps.add(i - end, 1);
                                counts.recurrence_times.add(i - begin, 1);
                            }
                            last = Some((i, i + 1));
                        }
                    }
                    if i + 1 == rows || !counted(i + 1, j) {
                        let (begin, end) = last.expect("a line has started");
                        counts.vertical.add(end - begin, 1);
                    }
                }
            }
        }
        counts
    }
}

/// The hand-drawn matrix of RecurrenceAnalysis.jl (`test/rqa_rna_analytic.jl`), 10 rows by 11
/// columns.
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

/// Number of lines of length 1, 2, ...
fn lines<const L: usize>(counts: [u64; L]) -> LineHistogram {
    LineHistogram {
        counts: [&[0], &counts[..]].concat(),
    }
}

#[test]
fn the_hand_drawn_matrix_has_the_published_counts() {
    let counts = hand_drawn(0);
    assert_eq!(counts.recurrent, 33);
    assert_eq!(counts.diagonal, lines([11, 7, 1, 0, 1]));
    assert_eq!(counts.vertical, lines([15, 6, 2]));
    // Counted by hand; the published values use another definition.
    assert_eq!(counts.gaps, lines([4, 4, 3, 1]));
    assert_eq!(counts.recurrence_times, lines([0, 3, 0, 8, 1]));
    assert_eq!(counts.by_offset, [7, 1, 3, 2, 6, 0, 0, 0, 2, 0, 0]);
    // Every line but the last of a column is followed by a gap.
    assert_eq!(counts.gaps.lines() + 11, counts.vertical.lines());
}

#[test]
fn the_hand_drawn_matrix_with_a_theiler_window_has_the_published_counts() {
    let counts = hand_drawn(2);
    assert_eq!(counts.recurrent, 22);
    assert_eq!(counts.diagonal, lines([9, 4, 0, 0, 1]));
    assert_eq!(counts.vertical, lines([10, 3, 2]));
    assert_eq!(counts.by_offset, [0, 0, 3, 2, 6, 0, 0, 0, 2, 0, 0]);
    // Counted by hand: columns 3, 9 and 11, counted from 1. In the others the Theiler window
    // separates the lines.
    assert_eq!(counts.gaps, lines([1, 1, 2]));
    assert_eq!(counts.recurrence_times, lines([0, 1, 0, 3]));
}

#[test]
fn a_full_matrix_has_lines_from_edge_to_edge() {
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
