//! Points and lines counted from the bits of diagonals.
//!
//! Diagonal lines are runs of bits. The vertical lines through the diagonals need no counter for
//! every pair: a line or a gap begins or ends only where a diagonal differs from the one before,
//! and what is remembered of a column is where its last line began and ended.

use super::sweep::{Diagonal, Visitor};
use super::{LineHistogram, RecurrenceCounts};

/// No offset; so many states would have 10^19 pairs.
const NONE: u32 = u32::MAX;

/// The first and the last time something happened, as offsets.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    begin: u32,
    end: u32,
}

const NEVER: Edge = Edge {
    begin: NONE,
    end: NONE,
};

/// One half of every column, above or below the line of identity, as it is passed with growing
/// offset: the offsets at which lines began, and at which they had ended.
#[derive(Clone, Debug)]
struct Half {
    /// The first ones within the offsets counted: what came before them is not known.
    first: Vec<Edge>,
    /// The last ones.
    last: Vec<Edge>,
}

/// Lines of one kind by length; there is room for all lengths that can occur.
type Lines = Vec<u64>;

/// The counts of some successive diagonals, and what is needed to join them with those before
/// and after.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    /// Both triangles hold the same: diagonals of the lower one need not be counted.
    symmetric: bool,
    /// Recurrent points of the lower triangle.
    lower_points: u64,
    /// Recurrent points of the upper triangle by offset, from the first counted.
    by_offset: Vec<u64>,
    diagonal: Lines,
    vertical: Lines,
    gaps: Lines,
    returns: Lines,
    above: Half,
    below: Half,
}

impl Half {
    fn new(states: usize) -> Self {
        Self {
            first: vec![NEVER; states],
            last: vec![NEVER; states],
        }
    }

    /// A line begins in this column; gives where the one before began.
    #[inline(always)]
    fn begin(&mut self, column: usize, offset: u32, gaps: &mut Lines) -> u32 {
        let last = &mut self.last[column];
        if last.end != NONE {
            gaps[(offset - last.end) as usize] += 1;
        }
        if last.begin == NONE {
            self.first[column].begin = offset;
        }
        std::mem::replace(&mut last.begin, offset)
    }

    /// A line has ended in this column; gives where the one before had ended.
    #[inline(always)]
    fn end(&mut self, column: usize, offset: u32, lines: &mut Lines) -> u32 {
        let last = &mut self.last[column];
        if last.begin != NONE {
            lines[(offset - last.begin) as usize] += 1;
        }
        if last.end == NONE {
            self.first[column].end = offset;
        }
        std::mem::replace(&mut last.end, offset)
    }

    /// Joins the diagonals that follow, and counts what only both together tell: a line, a gap
    /// and a return across the joint.
    fn join(&mut self, next: &Self, counts: &mut Joint<'_>) {
        for (c, last) in self.last.iter_mut().enumerate() {
            let (first, next_first, next_last) = (&mut self.first[c], next.first[c], next.last[c]);
            // NONE is larger than any offset.
            if next_first.end < next_first.begin && last.begin != NONE {
                counts.lines[(next_first.end - last.begin) as usize] += 1;
            }
            if next_first.begin < next_first.end && last.end != NONE {
                counts.gaps[(next_first.begin - last.end) as usize] += 1;
            }
            let (before, after) = match counts.returns_from {
                Returns::BeginToBegin => (last.begin, next_first.begin),
                Returns::EndToEnd => (last.end, next_first.end),
            };
            if before != NONE && after != NONE {
                counts.returns[(after - before) as usize] += 1;
            }
            first.begin = first.begin.min(next_first.begin);
            first.end = first.end.min(next_first.end);
            for (last, next) in [
                (&mut last.begin, next_last.begin),
                (&mut last.end, next_last.end),
            ] {
                if next != NONE {
                    *last = next;
                }
            }
        }
    }
}

/// Where lines are entered, read with growing offset: above the line of identity rows are passed
/// upwards, so that a line is entered where it ends.
#[derive(Clone, Copy)]
enum Returns {
    BeginToBegin,
    EndToEnd,
}

/// Where the counts of a joint go.
struct Joint<'a> {
    lines: &'a mut Lines,
    gaps: &'a mut Lines,
    returns: &'a mut Lines,
    returns_from: Returns,
}

impl Tally {
    /// Nothing counted yet of a plot with so many states.
    pub fn new(states: usize, symmetric: bool) -> Self {
        let none = vec![0; states + 1];
        Self {
            symmetric,
            lower_points: 0,
            by_offset: Vec::new(),
            diagonal: none.clone(),
            vertical: none.clone(),
            gaps: none.clone(),
            returns: none,
            above: Half::new(states),
            below: Half::new(states),
        }
    }

    /// Adds the counts of the diagonals that follow.
    pub fn join(mut self, next: Self) -> Self {
        for (sum, next) in [
            (&mut self.diagonal, &next.diagonal),
            (&mut self.vertical, &next.vertical),
            (&mut self.gaps, &next.gaps),
            (&mut self.returns, &next.returns),
        ] {
            sum.iter_mut()
                .zip(next)
                .for_each(|(sum, next)| *sum += next);
        }
        self.lower_points += next.lower_points;
        self.by_offset.extend(next.by_offset);
        for (half, next, returns_from) in [
            (&mut self.above, &next.above, Returns::EndToEnd),
            (&mut self.below, &next.below, Returns::BeginToBegin),
        ] {
            let mut joint = Joint {
                lines: &mut self.vertical,
                gaps: &mut self.gaps,
                returns: &mut self.returns,
                returns_from,
            };
            half.join(next, &mut joint);
        }
        self
    }

    /// All counts, when all diagonals from the first counted to the empty one are in.
    pub fn finish(mut self, theiler: usize) -> RecurrenceCounts {
        let states = self.above.last.len();
        let mut by_offset = vec![0; theiler.max(1).min(states)];
        by_offset.append(&mut self.by_offset);
        by_offset.resize(states, 0);
        let upper_points: u64 = by_offset.iter().sum();
        if self.symmetric {
            self.diagonal.iter_mut().for_each(|lines| *lines *= 2);
        }
        let mut recurrent = upper_points + self.lower_points;
        if theiler == 0 {
            by_offset[0] = states as u64;
            recurrent += states as u64;
            self.diagonal[states] += 1;
            self.join_at_identity();
        }
        RecurrenceCounts {
            rows: states,
            columns: states,
            theiler,
            recurrent,
            diagonal: LineHistogram::from(self.diagonal),
            vertical: LineHistogram::from(self.vertical),
            gaps: LineHistogram::from(self.gaps),
            returns: LineHistogram::from(self.returns),
            by_offset,
        }
    }

    /// The line through the line of identity, which both halves of a column share, and the return
    /// from it: it covers `end` points in either half, the one on the identity in both.
    fn join_at_identity(&mut self) {
        for (above, below) in self.above.first.iter().zip(&self.below.first) {
            self.vertical[(above.end + below.end - 1) as usize] += 1;
            if below.begin != NONE {
                self.returns[(below.begin + above.end - 1) as usize] += 1;
            }
        }
    }
}

impl Visitor for Tally {
    #[inline(always)]
    fn visit(&mut self, diagonal: &Diagonal<'_>) {
        let offset = diagonal.offset as u32;
        // The diagonal before has one pair more.
        let words = (self.above.last.len() + 1 - diagonal.offset).div_ceil(64);
        let Diagonal {
            upper,
            lower,
            upper_before,
            lower_before,
            ..
        } = diagonal;

        self.by_offset.push(points(&upper[..words]));
        count_runs(&upper[..words], &mut self.diagonal);
        if self.symmetric {
            self.lower_points += self.by_offset[self.by_offset.len() - 1];
        } else {
            self.lower_points += points(&lower[..words]);
            count_runs(&lower[..words], &mut self.diagonal);
        }

        // Pair (i + k, i): the same column, i, as before.
        let (gaps, lines, returns) = (&mut self.gaps, &mut self.vertical, &mut self.returns);
        for (word, (&now, &before)) in lower[..words].iter().zip(*lower_before).enumerate() {
            each_bit(now & !before, |bit| {
                let last = self.below.begin(64 * word + bit, offset, gaps);
                if last != NONE {
                    returns[(offset - last) as usize] += 1;
                }
            });
            each_bit(before & !now, |bit| {
                self.below.end(64 * word + bit, offset, lines);
            });
        }

        // Pair (i, i + k): the column of pair i + 1 before, and that of pair 0 is left.
        let mut end = |column| {
            let last = self.above.end(column, offset, lines);
            if last != NONE {
                returns[(offset - last) as usize] += 1;
            }
        };
        if upper_before[0] & 1 == 1 {
            end(diagonal.offset - 1);
        }
        for (word, &now) in upper[..words].iter().enumerate() {
            let before = upper_before[word] >> 1 | upper_before[word + 1] << 63;
            let column = diagonal.offset + 64 * word;
            each_bit(before & !now, |bit| end(column + bit));
        }
        for (word, &now) in upper[..words].iter().enumerate() {
            let before = upper_before[word] >> 1 | upper_before[word + 1] << 63;
            let column = diagonal.offset + 64 * word;
            each_bit(now & !before, |bit| {
                self.above.begin(column + bit, offset, gaps);
            });
        }
    }
}

/// Set bits.
#[inline(always)]
fn points(words: &[u64]) -> u64 {
    words.iter().map(|word| u64::from(word.count_ones())).sum()
}

/// The positions of the set bits, in order.
#[inline(always)]
fn each_bit(mut bits: u64, mut take: impl FnMut(usize)) {
    while bits != 0 {
        take(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// Counts the runs of set bits by length; the last word is zero.
#[inline(always)]
fn count_runs(words: &[u64], lines: &mut Lines) {
    // Where the run that reaches into the word began.
    let mut begin = 0;
    let mut open = 0;
    for (word, &bits) in words.iter().enumerate() {
        // A change from bit to bit is where a run begins or where it has ended.
        let changes = bits ^ (bits << 1 | open);
        let (mut begins, mut ends) = (changes & bits, changes & !bits);
        let at = 64 * word;
        if open == 1 && ends != 0 {
            lines[at + ends.trailing_zeros() as usize - begin] += 1;
            ends &= ends - 1;
        }
        while ends != 0 {
            lines[(ends.trailing_zeros() - begins.trailing_zeros()) as usize] += 1;
            ends &= ends - 1;
            begins &= begins - 1;
        }
        if begins != 0 {
            begin = at + begins.trailing_zeros() as usize;
        }
        open = bits >> 63;
    }
}
