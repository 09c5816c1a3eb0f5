//! Counts of a recurrence plot that grows or slides with the samples.

mod mask;
mod states;

#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use pulp::{Arch, Simd, WithSimd};

use self::mask::{bit, ones, runs, word, word_after, word_before};
use self::states::{Along, States, WORD};
use super::{LineHistogram, RecurrenceCounts, Threshold};
use crate::analysis::{AnalysisError, Norm};

/// The counts of the recurrence plot of a growing or sliding window, updated sample by sample.
///
/// A state that enters adds a row and a column to the plot, one that leaves takes a row and a
/// column with it; only what they change is counted anew. [`RecurrenceWindow::counts`] is at any
/// moment equal to counting the plot of the states held from nothing: see [`RecurrenceCounts`]
/// for what is counted. A line that the edge of the window cuts counts with the length that lies
/// within.
///
/// *Time.* With `N` states held, a state that enters costs `N` distances, and one that leaves
/// another `N` and the search for the ends of the lines and gaps that begin in its row. That search
/// passes a pair once as part of a column and once as part of a diagonal, however often the window
/// moves. So a sample costs a time proportional to `N` on average (measured: 2 to 8 `N` distances
/// in all); a single one may cost up to `N^2`, where a signal has just lost its last state before
/// a whole window of silence.
///
/// *Memory* is proportional to `N` as well: the plot is never stored.
#[derive(Clone, Debug)]
pub struct RecurrenceWindow {
    states: States,
    /// The most states held; `None` if they are never forgotten.
    length: Option<usize>,
    theiler: usize,
    /// The states held are those from `oldest` until before `end`.
    oldest: usize,
    end: usize,
    /// Bit `k`: is state `end - 1 - k` near `end - 1`, the last that entered?
    entered: Vec<u64>,
    /// Bit `k`: was state `oldest - 1 + k` near `oldest - 1`, the last that left, when it did?
    left: Vec<u64>,
    /// Workspace of the two.
    row: Vec<u64>,
    /// The diagonals `j - i = k`, `k = 0, 1, ...`; their lines have places by the row `i`.
    diagonals: Vec<Diagonal>,
    /// The columns of the states held; their lines have places by the row, too.
    columns: VecDeque<Column>,
    by_offset: Vec<u64>,
    /// Lines with both ends in the window, of the upper triangle.
    diagonal: LineHistogram,
    /// Lines with both ends in the window.
    vertical: LineHistogram,
    /// Gaps after such lines.
    gaps: LineHistogram,
    /// From the beginning of such a line to the next.
    returns: LineHistogram,
}

/// The lines of a diagonal that are not in the histogram.
#[derive(Clone, Debug, Default)]
struct Diagonal {
    /// Where the last line begins; it is open as long as the newest pair is recurrent.
    begin: usize,
    /// Where the line ends (the pair after) of which the window has lost the beginning.
    cut: usize,
}

/// The lines of a column that are not in the histogram.
#[derive(Clone, Debug, Default)]
struct Column {
    /// The last line below the Theiler window: its beginning and, unless it is open, its end.
    last: Option<(usize, usize)>,
    /// The end of the line of which the window has lost the beginning.
    cut: usize,
    /// The beginning of the line after that one.
    next: Option<usize>,
}

impl RecurrenceWindow {
    /// A window that holds the last `length` states: pairs within `epsilon` (the signal's unit)
    /// are recurrent, those with `|i - j| < theiler` are left out.
    ///
    /// # Errors
    /// [`AnalysisError::NoDelay`] for a lag or dimension of zero, [`AnalysisError::TooShort`] for
    /// a length of zero, [`AnalysisError::Threshold`] for an `epsilon` that is negative or not a
    /// number.
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

    /// A window that never forgets: as [`RecurrenceWindow::sliding`], but time and memory grow
    /// with the samples.
    ///
    /// # Errors
    /// [`AnalysisError::NoDelay`] for a lag or dimension of zero, [`AnalysisError::Threshold`] for
    /// an `epsilon` that is negative or not a number.
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
            return Err(AnalysisError::NoDelay { lag, dimension });
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
            returns: LineHistogram::default(),
        })
    }

    /// States held.
    pub fn size(&self) -> usize {
        self.end - self.oldest
    }

    /// Takes the next samples, in pieces of any size. The first `(m - 1) tau` of the stream
    /// complete no state; each one after that does.
    pub fn push(&mut self, samples: &[f64]) {
        Arch::new().dispatch(Push {
            window: self,
            samples,
        });
    }

    /// The counts of the states held now, exactly those of [`super::quantify`] on the same states.
    /// Takes a time proportional to the number of states.
    pub fn counts(&self) -> RecurrenceCounts {
        let (oldest, size) = (self.oldest, self.size());
        let mut counts = RecurrenceCounts {
            rows: size,
            columns: size,
            theiler: self.theiler,
            by_offset: self.by_offset[..size].to_vec(),
            vertical: self.vertical.clone(),
            gaps: self.gaps.clone(),
            returns: self.returns.clone(),
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
                    counts.returns.add(next - oldest);
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

    /// State `end` enters: a new end for every diagonal and every column, and a new column.
    #[inline(always)]
    fn enter(&mut self) {
        let newest = self.end;
        self.end += 1;
        let mut row = std::mem::take(&mut self.row);
        self.states
            .near_earlier(self.oldest, newest, self.theiler, &mut row);
        let size = self.size();
        if self.diagonals.len() < size {
            self.diagonals.push(Diagonal::default());
            self.by_offset.push(0);
        }
        for (w, &near) in row.iter().enumerate() {
            ones(w, near).for_each(|offset| self.by_offset[offset] += 1);
            let held = first_ones(size - w * WORD);
            let changed = held & (near ^ word(&self.entered, w));
            for offset in ones(w, changed) {
                self.end_of_diagonal(offset, newest - offset, bit(&row, offset));
            }
            let changed = held & (near ^ word_before(&self.entered, w));
            for offset in ones(w, changed).filter(|&offset| offset > 0) {
                self.end_of_column(newest - offset, newest, bit(&row, offset));
            }
        }
        self.add_column(&row);
        self.row = std::mem::replace(&mut self.entered, row);
    }

    /// A line of the diagonal begins (`near`) or ends at row `row`.
    fn end_of_diagonal(&mut self, offset: usize, row: usize, near: bool) {
        let diagonal = &mut self.diagonals[offset];
        if near {
            diagonal.begin = row;
        } else if diagonal.begin < self.oldest {
            diagonal.cut = row;
        } else {
            self.diagonal.add(row - diagonal.begin);
        }
    }

    /// A line of a column begins (`near`) or ends at row `row`.
    fn end_of_column(&mut self, column: usize, row: usize, near: bool) {
        let column = &mut self.columns[column - self.oldest];
        let whole = |begin: usize| begin >= self.oldest;
        match (&mut column.last, near) {
            (last @ None, _) => *last = Some((row, row)),
            (Some((begin, end)), true) => {
                if whole(*begin) {
                    self.gaps.add(row - *end);
                    self.returns.add(row - *begin);
                } else {
                    column.next = Some(row);
                }
                (*begin, *end) = (row, row);
            }
            (Some((begin, end)), false) => {
                *end = row;
                if whole(*begin) {
                    self.vertical.add(row - *begin);
                } else {
                    (column.cut, column.next) = (row, None);
                }
            }
        }
    }

    /// The column of the newest state, from its pairs by offset.
    fn add_column(&mut self, row: &[u64]) {
        let reach = row.len() * WORD;
        let place = |k: usize| self.end + k - reach;
        let mut last = None;
        for (begin, end) in runs(row.iter().rev().map(|word| word.reverse_bits())) {
            let (begin, end) = (place(begin), place(end));
            if let Some((before, gap)) = last {
                self.gaps.add(begin - gap);
                self.returns.add(begin - before);
            }
            if end < self.end {
                self.vertical.add(end - begin);
            }
            last = Some((begin, end));
        }
        self.columns.push_back(Column {
            // What lies above a Theiler window has nothing to do with what will come below.
            last: last.filter(|_| self.theiler == 0),
            ..Column::default()
        });
    }

    /// State `oldest` leaves: every diagonal and every column loses its first pair, and one
    /// column goes altogether.
    #[inline(always)]
    fn leave(&mut self) {
        let mut row = std::mem::take(&mut self.row);
        self.states
            .near_later(self.oldest, self.end - 1, self.theiler, &mut row);
        self.remove_column(&row);
        for (w, &near) in row.iter().enumerate() {
            ones(w, near).for_each(|offset| self.by_offset[offset] -= 1);
            for offset in ones(w, near & !word(&self.left, w)) {
                self.cut_diagonal(offset);
            }
            for offset in ones(w, near & !word_after(&self.left, w)) {
                self.cut_column(offset);
            }
        }
        self.columns.pop_front();
        self.oldest += 1;
        self.states.forget_before(self.oldest);
        self.row = std::mem::replace(&mut self.left, row);
    }

    /// Takes away the column of the oldest state, given by its pairs by offset.
    fn remove_column(&mut self, row: &[u64]) {
        // The line that the window has cut already is not in the histograms, nor what follows it.
        let is_cut = |begin: usize| begin == 0 && bit(&self.left, 1);
        let mut last = None;
        for (begin, end) in runs(row.iter().copied()) {
            if let Some((before, gap)) = last.filter(|&(before, _)| !is_cut(before)) {
                self.gaps.remove(begin - gap);
                self.returns.remove(begin - before);
            }
            if end < self.size() && !is_cut(begin) {
                self.vertical.remove(end - begin);
            }
            last = Some((begin, end));
        }
    }

    /// The diagonal's line that begins with the state that leaves is no longer whole.
    #[inline(always)]
    fn cut_diagonal(&mut self, offset: usize) {
        let (begin, most) = (self.oldest, self.size() - offset);
        let diagonal = &mut self.diagonals[offset];
        if diagonal.begin == begin && bit(&self.entered, offset) {
            return; // It is open, and in no histogram.
        }
        let length = self
            .states
            .run(true, begin, begin + offset, most, Along::Diagonal);
        self.diagonal.remove(length);
        diagonal.cut = begin + length;
    }

    /// The column's line that begins with the state that leaves is no longer whole.
    #[inline(always)]
    fn cut_column(&mut self, offset: usize) {
        let (begin, state) = (self.oldest, self.oldest + offset);
        // Above the Theiler window, or through the line of identity to the end.
        let most = match self.theiler {
            0 => self.size(),
            theiler => offset + 1 - theiler,
        };
        let open = bit(&self.entered, self.size() - 1 - offset);
        let column = &mut self.columns[offset];
        if offset == 0 || open && column.last.is_some_and(|last| last.0 == begin) {
            return; // The column goes altogether, or the line is open and in no histogram.
        }
        let states = &self.states;
        let length = states.run(true, begin, state, most, Along::Column);
        let end = begin + length;
        let gap = states.run(false, end, state, most - length, Along::Column);
        self.vertical.remove(length);
        column.cut = end;
        column.next = (length + gap < most).then_some(end + gap);
        if column.next.is_some() {
            self.gaps.remove(gap);
            self.returns.remove(length + gap);
        }
    }
}

/// [`RecurrenceWindow::push`], with the vector instructions that the machine has.
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
                    window.leave();
                }
                window.enter();
            }
        }
    }
}

/// A word that begins with so many ones.
fn first_ones(count: usize) -> u64 {
    if count < WORD {
        !(u64::MAX << count)
    } else {
        u64::MAX
    }
}
