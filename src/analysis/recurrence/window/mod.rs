//! Counts of the recurrence plot of a growing or sliding window.

mod mask;
mod states;

#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use pulp::{Simd, WithSimd};

use self::mask::{bit, ones, runs, word, word_after, word_before};
use self::states::{Along, States, WORD};
use super::{LineHistogram, RecurrenceCounts, Threshold};
use crate::analysis::{AnalysisError, Norm};
use crate::instruction_set::instruction_set;

/// Counts of the recurrence plot of a growing or sliding window, updated sample by sample.
///
/// A new state adds a row and a column to the plot, a state that leaves removes them. Only the changes
/// are counted. [`RecurrenceWindow::counts`] always equals a full count of the plot of the current
/// states; see [`RecurrenceCounts`] for the definitions. A line cut by the edge of the window counts
/// with its length inside the window.
///
/// *Time.* With `N` states in the window, a new state costs `N` distances. A state that leaves costs `N`
/// distances and the search for the ends of the lines and gaps that start in its row. That search visits
/// a pair once as part of a column and once as part of a diagonal, independent of the number of window
/// shifts. A sample therefore takes a time proportional to `N` on average (measured: 2 to 8 `N`
/// distances in all). A single sample can take `N^2`: when the last state before a full window of
/// constant signal leaves.
///
/// *Memory* is proportional to `N`: the plot is never stored.
#[derive(Clone, Debug)]
pub struct RecurrenceWindow {
    states: States,
    /// Maximum number of states; `None` for a growing window.
    length: Option<usize>,
    theiler: usize,
    /// The window contains the states from `oldest` to `end` (exclusive).
    oldest: usize,
    end: usize,
    /// Bit `k`: is state `end - 1 - k` recurrent with `end - 1`, the newest state?
    entered: Vec<u64>,
    /// Bit `k`: was state `oldest - 1 + k` recurrent with `oldest - 1`, the last state that left, at
    /// that time?
    left: Vec<u64>,
    /// Workspace for `entered` and `left`.
    row: Vec<u64>,
    /// Diagonals `j - i = k`, `k = 0, 1, ...`. Positions of their lines are rows `i`.
    diagonals: Vec<Diagonal>,
    /// Columns of the states in the window. Positions of their lines are rows.
    columns: VecDeque<Column>,
    by_offset: Vec<u64>,
    /// Lines with both ends in the window, upper triangle.
    diagonal: LineHistogram,
    /// Lines with both ends in the window.
    vertical: LineHistogram,
    /// Gaps after such lines.
    gaps: LineHistogram,
    /// Recurrence times from the start of such a line to the start of the next.
    recurrence_times: LineHistogram,
}

/// Lines of a diagonal that are not in the histogram.
#[derive(Clone, Debug, Default)]
struct Diagonal {
    /// Start of the last line, which is open while the newest pair is recurrent.
    begin: usize,
    /// End (exclusive) of the line whose start has left the window.
    cut: usize,
}

/// Lines of a column that are not in the histogram.
#[derive(Clone, Debug, Default)]
struct Column {
    /// Start and, unless it is open, end of the last line below the Theiler window.
    last: Option<(usize, usize)>,
    /// End of the line whose start has left the window.
    cut: usize,
    /// Start of the line after that one.
    next: Option<usize>,
}

impl RecurrenceWindow {
    /// Creates a window of the last `length` states. Pairs within `epsilon` (signal's unit) are
    /// recurrent; those with `|i - j| < theiler` are excluded.
    ///
    /// # Errors
    /// [`AnalysisError::InvalidDelay`] for a lag or dimension of 0; [`AnalysisError::TooShort`] for a
    /// length of 0; [`AnalysisError::Threshold`] for an `epsilon` that is negative or NaN.
    pub fn sliding(
        length: usize,
        lag: usize,
        dimension: usize,
        norm: Norm,
        epsilon: f64,
        theiler: usize,
    ) -> Result<Self, AnalysisError> {
        if length == 0 {
            return Err(AnalysisError::TooShort {
                what: "recurrence window",
                have: 0,
                need: 1,
            });
        }
        Self::new(Some(length), lag, dimension, norm, epsilon, theiler)
    }

    /// Creates a window that keeps all states. Like [`RecurrenceWindow::sliding`], but time and memory
    /// grow with the number of samples.
    ///
    /// # Errors
    /// [`AnalysisError::InvalidDelay`] for a lag or dimension of 0; [`AnalysisError::Threshold`] for an
    /// `epsilon` that is negative or NaN.
    pub fn growing(
        lag: usize,
        dimension: usize,
        norm: Norm,
        epsilon: f64,
        theiler: usize,
    ) -> Result<Self, AnalysisError> {
        Self::new(None, lag, dimension, norm, epsilon, theiler)
    }

    fn new(
        length: Option<usize>,
        lag: usize,
        dimension: usize,
        norm: Norm,
        epsilon: f64,
        theiler: usize,
    ) -> Result<Self, AnalysisError> {
        if lag == 0 || dimension == 0 {
            return Err(AnalysisError::InvalidDelay { lag, dimension });
        }
        Threshold::Distance(epsilon).check()?;
        Ok(Self {
            states: States::new(lag, dimension, norm, epsilon),
            length,
            theiler,
            oldest: 0,
            end: 0,
            entered: Vec::new(),
            left: Vec::new(),
            row: Vec::new(),
            diagonals: Vec::new(),
            columns: VecDeque::new(),
            by_offset: Vec::new(),
            diagonal: LineHistogram::default(),
            vertical: LineHistogram::default(),
            gaps: LineHistogram::default(),
            recurrence_times: LineHistogram::default(),
        })
    }

    /// Number of states in the window.
    pub fn size(&self) -> usize {
        self.end - self.oldest
    }

    /// Appends samples, in blocks of any size. The first `(m - 1) tau` samples of the stream complete no
    /// state; each later one completes one.
    pub fn push(&mut self, samples: &[f64]) {
        instruction_set().dispatch(Push {
            window: self,
            samples,
        });
    }

    /// Counts of the current states, equal to those of [`super::quantify`] on the same states. Takes a
    /// time proportional to the number of states.
    pub fn counts(&self) -> RecurrenceCounts {
        let (oldest, size) = (self.oldest, self.size());
        let mut counts = RecurrenceCounts {
            rows: size,
            columns: size,
            theiler: self.theiler,
            by_offset: self.by_offset[..size].to_vec(),
            vertical: self.vertical.clone(),
            gaps: self.gaps.clone(),
            recurrence_times: self.recurrence_times.clone(),
            ..RecurrenceCounts::default()
        };
        let mut upper = self.diagonal.clone();
        for (offset, diagonal) in self.diagonals.iter().enumerate().take(size).skip(1) {
            upper.add(diagonal.cut.saturating_sub(oldest));
            if bit(&self.entered, offset) {
                upper.add(self.end - offset - diagonal.begin.max(oldest));
            }
        }
        for (length, lines) in upper.iter() {
            counts.diagonal.add_many(length, 2 * lines);
        }
        if self.theiler == 0 {
            counts.diagonal.add(size);
        }
        for (column, offset) in self.columns.iter().zip((0..size).rev()) {
            if column.cut > oldest {
                counts.vertical.add(column.cut - oldest);
                if let Some(next) = column.next {
                    counts.gaps.add(next - column.cut);
                    counts.recurrence_times.add(next - oldest);
                }
            }
            if let (true, Some((begin, _))) = (bit(&self.entered, offset), column.last) {
                counts.vertical.add(self.end - begin.max(oldest));
            }
        }
        let upper: u64 = counts.by_offset.iter().sum();
        counts.recurrent = 2 * upper - counts.by_offset.first().unwrap_or(&0);
        counts
    }

    /// Adds state `end`: extends every diagonal and every column and adds a column.
    #[inline(always)]
    fn add_newest(&mut self) {
        let newest = self.end;
        self.end += 1;
        let mut row = std::mem::take(&mut self.row);
        self.states
            .recurrent_earlier(self.oldest, newest, self.theiler, &mut row);
        let size = self.size();
        if self.diagonals.len() < size {
            self.diagonals.push(Diagonal::default());
            self.by_offset.push(0);
        }
        for (w, &recurrent) in row.iter().enumerate() {
            ones(w, recurrent).for_each(|offset| self.by_offset[offset] += 1);
            let in_window = first_ones(size - w * WORD);
            let changed = in_window & (recurrent ^ word(&self.entered, w));
            for offset in ones(w, changed) {
                self.update_diagonal(offset, newest - offset, bit(&row, offset));
            }
            let changed = in_window & (recurrent ^ word_before(&self.entered, w));
            for offset in ones(w, changed).filter(|&offset| offset > 0) {
                self.update_column(newest - offset, newest, bit(&row, offset));
            }
        }
        self.add_column(&row);
        self.row = std::mem::replace(&mut self.entered, row);
    }

    /// A line of the diagonal starts (`recurrent`) or ends at row `row`.
    fn update_diagonal(&mut self, offset: usize, row: usize, recurrent: bool) {
        let diagonal = &mut self.diagonals[offset];
        if recurrent {
            diagonal.begin = row;
        } else if diagonal.begin < self.oldest {
            diagonal.cut = row;
        } else {
            self.diagonal.add(row - diagonal.begin);
        }
    }

    /// A line of a column starts (`recurrent`) or ends at row `row`.
    fn update_column(&mut self, column: usize, row: usize, recurrent: bool) {
        let column = &mut self.columns[column - self.oldest];
        let complete = |begin: usize| begin >= self.oldest;
        match (&mut column.last, recurrent) {
            (last @ None, _) => *last = Some((row, row)),
            (Some((begin, end)), true) => {
                if complete(*begin) {
                    self.gaps.add(row - *end);
                    self.recurrence_times.add(row - *begin);
                } else {
                    column.next = Some(row);
                }
                (*begin, *end) = (row, row);
            }
            (Some((begin, end)), false) => {
                *end = row;
                if complete(*begin) {
                    self.vertical.add(row - *begin);
                } else {
                    (column.cut, column.next) = (row, None);
                }
            }
        }
    }

    /// Adds the column of the newest state, from its pairs by offset.
    fn add_column(&mut self, row: &[u64]) {
        let width = row.len() * WORD;
        let position = |k: usize| self.end + k - width;
        let mut last = None;
        for (begin, end) in runs(row.iter().rev().map(|word| word.reverse_bits())) {
            let (begin, end) = (position(begin), position(end));
            if let Some((before, gap)) = last {
                self.gaps.add(begin - gap);
                self.recurrence_times.add(begin - before);
            }
            if end < self.end {
                self.vertical.add(end - begin);
            }
            last = Some((begin, end));
        }
        self.columns.push_back(Column {
            // Lines above a Theiler window do not continue below it.
            last: last.filter(|_| self.theiler == 0),
            ..Column::default()
        });
    }

    /// Removes state `oldest`: the first pair of every diagonal and every column, and one column.
    #[inline(always)]
    fn remove_oldest(&mut self) {
        let mut row = std::mem::take(&mut self.row);
        self.states
            .recurrent_later(self.oldest, self.end - 1, self.theiler, &mut row);
        self.remove_column(&row);
        for (w, &recurrent) in row.iter().enumerate() {
            ones(w, recurrent).for_each(|offset| self.by_offset[offset] -= 1);
            for offset in ones(w, recurrent & !word(&self.left, w)) {
                self.cut_diagonal(offset);
            }
            for offset in ones(w, recurrent & !word_after(&self.left, w)) {
                self.cut_column(offset);
            }
        }
        self.columns.pop_front();
        self.oldest += 1;
        self.states.drop_before(self.oldest);
        self.row = std::mem::replace(&mut self.left, row);
    }

    /// Removes the column of the oldest state, given by its pairs by offset.
    fn remove_column(&mut self, row: &[u64]) {
        // The line already cut by the window, and the gap after it, are not in the histograms.
        let is_cut = |begin: usize| begin == 0 && bit(&self.left, 1);
        let mut last = None;
        for (begin, end) in runs(row.iter().copied()) {
            if let Some((before, gap)) = last.filter(|&(before, _)| !is_cut(before)) {
                self.gaps.remove(begin - gap);
                self.recurrence_times.remove(begin - before);
            }
            if end < self.size() && !is_cut(begin) {
                self.vertical.remove(end - begin);
            }
            last = Some((begin, end));
        }
    }

    /// Removes the diagonal's line that starts at the leaving state from the histogram of complete
    /// lines.
    #[inline(always)]
    fn cut_diagonal(&mut self, offset: usize) {
        let (begin, max_length) = (self.oldest, self.size() - offset);
        let diagonal = &mut self.diagonals[offset];
        if diagonal.begin == begin && bit(&self.entered, offset) {
            return; // The line is open and in no histogram.
        }
        let length = self
            .states
            .run(true, begin, begin + offset, max_length, Along::Diagonal);
        self.diagonal.remove(length);
        diagonal.cut = begin + length;
    }

    /// Removes the column's line that starts at the leaving state from the histogram of complete lines.
    #[inline(always)]
    fn cut_column(&mut self, offset: usize) {
        let (begin, state) = (self.oldest, self.oldest + offset);
        // Up to the Theiler window, or through the line of identity to the end.
        let max_length = match self.theiler {
            0 => self.size(),
            theiler => offset + 1 - theiler,
        };
        let open = bit(&self.entered, self.size() - 1 - offset);
        let column = &mut self.columns[offset];
        if offset == 0 || open && column.last.is_some_and(|last| last.0 == begin) {
            return; // The column is removed, or the line is open and in no histogram.
        }
        let states = &self.states;
        let length = states.run(true, begin, state, max_length, Along::Column);
        let end = begin + length;
        let gap = states.run(false, end, state, max_length - length, Along::Column);
        self.vertical.remove(length);
        column.cut = end;
        column.next = (length + gap < max_length).then_some(end + gap);
        if column.next.is_some() {
            self.gaps.remove(gap);
            self.recurrence_times.remove(length + gap);
        }
    }
}

/// [`RecurrenceWindow::push`], compiled for the instruction set of the machine.
struct Push<'a> {
    window: &'a mut RecurrenceWindow,
    samples: &'a [f64],
}

impl WithSimd for Push<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { window, samples } = self;
        for &sample in samples {
            if window.states.push(sample) > window.end {
                if window.length == Some(window.size()) {
                    window.remove_oldest();
                }
                window.add_newest();
            }
        }
    }
}

/// A word with the first `count` bits set.
fn first_ones(count: usize) -> u64 {
    if count < WORD {
        !(u64::MAX << count)
    } else {
        u64::MAX
    }
}
