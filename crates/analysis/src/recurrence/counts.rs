//! Counts of a recurrence plot: recurrent points, and lines by length.

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
    /// Adds the lines of other counts.
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
        self
    }
}

/// Words of bits that are compared before their columns are counted: 1 MB.
const BLOCK: usize = 1 << 17;

/// Place of the row and of the column in the position of a pair: the lines along it are counted.
const ROWS: usize = 0;
const COLUMNS: usize = 1;

/// The last line of each of 64 columns, along successive diagonals counted from 1.
#[derive(Clone)]
struct Columns {
    /// Recurrent pairs of the last diagonal.
    recurrent: u64,
    /// Diagonal at which the line began.
    begin: [u32; 64],
    /// Diagonal at which it had ended; 0 for no line that has ended.
    end: [u32; 64],
}

impl Columns {
    /// Counts the lines that end, and the gaps before those that begin, on a diagonal. Columns are read downwards or
    /// upwards.
    #[inline(always)]
    fn count(
        &mut self,
        recurrent: u64,
        diagonal: u32,
        upwards: bool,
        counts: &mut RecurrenceCounts,
    ) {
        each_bit(recurrent & !self.recurrent, |column| {
            let (begin, end) = (&mut self.begin[column], self.end[column]);
            if end > 0 {
                counts.gaps.add((diagonal - end) as usize, 1);
                if !upwards {
                    let time = diagonal - *begin;
                    counts.recurrence_times.add(time as usize, 1);
                }
            }
            *begin = diagonal;
        });
        each_bit(self.recurrent & !recurrent, |column| {
            let (begin, end) = (self.begin[column], &mut self.end[column]);
            counts.vertical.add((diagonal - begin) as usize, 1);
            if upwards && *end > 0 {
                // Upwards, the start of a line is its end.
                counts.recurrence_times.add((diagonal - *end) as usize, 1);
            }
            *end = diagonal;
        });
        self.recurrent = recurrent;
    }
}

impl Recurrences<'_> {
    /// Counts the points and lines.
    ///
    /// Diagonals are compared in blocks and not stored: time is proportional to the number of pairs, memory to the number
    /// of states. The computation uses all cores; the counts do not depend on their number.
    pub fn counts(&self) -> RecurrenceCounts {
        let [rows, columns] = [self.rows, self.columns].map(|states| states.len());
        let counts = RecurrenceCounts {
            rows,
            columns,
            theiler: self.theiler,
            by_offset: vec![0; columns + 1],
            ..RecurrenceCounts::default()
        };
        // The diagonals `i - j`, with the empty one at which all lines have ended. A Theiler window separates the columns.
        let (n, gap) = (columns as isize, self.theiler.min(columns) as isize);
        let mut counts = if gap == 0 {
            self.count((1 - n..=rows as isize).collect(), &[COLUMNS], counts)
        } else if self.distance.is_some() {
            self.count((gap..=n).collect(), &[COLUMNS, ROWS], counts)
        } else {
            let counts = self.count((gap..=n).collect(), &[COLUMNS], counts);
            self.count((-n..=-gap).rev().collect(), &[COLUMNS], counts)
        };
        counts.by_offset.pop();
        counts.recurrent = counts.vertical.points();
        counts
    }

    /// Adds the counts of successive diagonals `i - j`. Those of a symmetric plot stand for their mirror images, too, if
    /// the lines along the rows are counted, which are the vertical lines of the mirror image.
    fn count(
        &self,
        diagonals: Vec<isize>,
        directions: &[usize],
        mut counts: RecurrenceCounts,
    ) -> RecurrenceCounts {
        let descends = diagonals.last() < diagonals.first();
        let images = directions.len() as u64;
        // A word of zeros precedes the bits of a diagonal.
        let groups = self.columns.len().div_ceil(64);
        let stride = 1 + groups;
        let mut bits = vec![0; stride * diagonals.len().min((BLOCK / stride).max(1))];
        let none = Columns {
            recurrent: 0,
            begin: [0; 64],
            end: [0; 64],
        };
        let mut columns = vec![vec![none; groups]; directions.len()];
        let mut first = 1;
        for diagonals in diagonals.chunks(bits.len() / stride) {
            let starts: Vec<[usize; 2]> = diagonals
                .iter()
                .map(|&k| [k, -k].map(|from| from.max(0) as usize))
                .collect();
            let rows = bits.par_chunks_mut(stride).zip(&starts);
            let found = rows.fold(RecurrenceCounts::default, |mut counts, (bits, &start)| {
                let bits = &mut bits[1..];
                bits.fill(0);
                if !self.rows.is_stopped() {
                    self.compare(start, bits);
                }
                each_run(bits, |begin, end| counts.diagonal.add(end - begin, images));
                counts
            });
            counts =
                counts.append(found.reduce(RecurrenceCounts::default, RecurrenceCounts::append));
            for (bits, &[i, j]) in bits.chunks(stride).zip(&starts) {
                if i == 0 || images == 2 {
                    counts.by_offset[i + j] =
                        bits.iter().map(|word| u64::from(word.count_ones())).sum();
                }
            }
            for (&direction, columns) in directions.iter().zip(&mut columns) {
                let upwards = descends || direction == ROWS;
                let groups = columns.par_iter_mut().enumerate();
                let found =
                    groups.fold(RecurrenceCounts::default, |mut counts, (group, columns)| {
                        let diagonals = bits.chunks(stride).zip(&starts).zip(first..);
                        for ((bits, start), diagonal) in diagonals {
                            // The first pair stands in this column.
                            let (words, shift) = (start[direction] / 64, start[direction] % 64);
                            let recurrent = group.checked_sub(words).map_or(0, |word| {
                                bits[word + 1] << shift | bits[word] >> 1 >> (63 - shift)
                            });
                            columns.count(recurrent, diagonal, upwards, &mut counts);
                        }
                        counts
                    });
                counts = counts
                    .append(found.reduce(RecurrenceCounts::default, RecurrenceCounts::append));
            }
            first += diagonals.len() as u32;
        }
        counts
    }
}

/// Calls `take` with the positions of the set bits, in order.
#[inline(always)]
fn each_bit(mut bits: u64, mut take: impl FnMut(usize)) {
    while bits != 0 {
        take(bits.trailing_zeros() as usize);
        bits &= bits - 1;
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
