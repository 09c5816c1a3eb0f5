//! Counts points and lines from the bits of diagonals.
//!
//! Diagonal lines are runs of bits. Vertical lines across the diagonals need no counter per pair: a line
//! or a gap starts or ends only where a diagonal differs from the previous one, and per column only the
//! start and end of its last line are stored.

use super::diagonals::Diagonal;
use super::{LineHistogram, RecurrenceCounts};

/// Marks an absent offset. It cannot occur: so many states would have 10^19 pairs.
const NO_OFFSET: u32 = u32::MAX;

/// Offsets of one start and one end of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    begin: u32,
    end: u32,
}

const NO_EDGE: Edge = Edge {
    begin: NO_OFFSET,
    end: NO_OFFSET,
};

/// One half of every column, above or below the line of identity, scanned in order of increasing offset:
/// the offsets at which lines started, and at which they had ended.
#[derive(Clone, Debug)]
struct HalfColumns {
    /// First start and end within the counted offsets. Earlier ones are unknown.
    first: Vec<Edge>,
    /// Last start and end.
    last: Vec<Edge>,
}

/// Number of lines by length, allocated for all possible lengths.
type Lines = Vec<u64>;

/// Counts of some successive diagonals, and the data needed to append the following ones.
#[derive(Clone, Debug)]
pub(super) struct LineCounter {
    /// Both triangles are equal: diagonals of the lower one need not be counted.
    symmetric: bool,
    /// Recurrent points of the lower triangle.
    lower_points: u64,
    /// Recurrent points of the upper triangle by offset, starting with the first counted.
    by_offset: Vec<u64>,
    diagonal: Lines,
    vertical: Lines,
    gaps: Lines,
    recurrence_times: Lines,
    above: HalfColumns,
    below: HalfColumns,
}

impl HalfColumns {
    fn new(states: usize) -> Self {
        Self {
            first: vec![NO_EDGE; states],
            last: vec![NO_EDGE; states],
        }
    }

    /// Records the start of a line in this column. Returns the previous start.
    #[inline(always)]
    fn begin(&mut self, column: usize, offset: u32, gaps: &mut Lines) -> u32 {
        let last = &mut self.last[column];
        if last.end != NO_OFFSET {
            gaps[(offset - last.end) as usize] += 1;
        }
        if last.begin == NO_OFFSET {
            self.first[column].begin = offset;
        }
        std::mem::replace(&mut last.begin, offset)
    }

    /// Records the end of a line in this column. Returns the previous end.
    #[inline(always)]
    fn end(&mut self, column: usize, offset: u32, lines: &mut Lines) -> u32 {
        let last = &mut self.last[column];
        if last.begin != NO_OFFSET {
            lines[(offset - last.begin) as usize] += 1;
        }
        if last.end == NO_OFFSET {
            self.first[column].end = offset;
        }
        std::mem::replace(&mut last.end, offset)
    }

    /// Appends the diagonals that follow, and counts a line, a gap and a recurrence time across the
    /// boundary.
    fn append(&mut self, next: &Self, counts: &mut Boundary<'_>) {
        for (c, last) in self.last.iter_mut().enumerate() {
            let (first, next_first, next_last) = (&mut self.first[c], next.first[c], next.last[c]);
            // NO_OFFSET is larger than any offset.
            if next_first.end < next_first.begin && last.begin != NO_OFFSET {
                counts.lines[(next_first.end - last.begin) as usize] += 1;
            }
            if next_first.begin < next_first.end && last.end != NO_OFFSET {
                counts.gaps[(next_first.begin - last.end) as usize] += 1;
            }
            let (before, after) = match counts.returns_from {
                Returns::BeginToBegin => (last.begin, next_first.begin),
                Returns::EndToEnd => (last.end, next_first.end),
            };
            if before != NO_OFFSET && after != NO_OFFSET {
                counts.recurrence_times[(after - before) as usize] += 1;
            }
            first.begin = first.begin.min(next_first.begin);
            first.end = first.end.min(next_first.end);
            for (last, next) in [
                (&mut last.begin, next_last.begin),
                (&mut last.end, next_last.end),
            ] {
                if next != NO_OFFSET {
                    *last = next;
                }
            }
        }
    }
}

/// How lines are entered with increasing offset. Above the line of identity rows are scanned upwards, so
/// a line is entered at its end.
#[derive(Clone, Copy)]
enum Returns {
    BeginToBegin,
    EndToEnd,
}

/// Destination of the counts at a boundary.
struct Boundary<'a> {
    lines: &'a mut Lines,
    gaps: &'a mut Lines,
    recurrence_times: &'a mut Lines,
    returns_from: Returns,
}

impl LineCounter {
    /// Counter without diagonals for a plot with `states` states.
    pub fn new(states: usize, symmetric: bool) -> Self {
        let none = vec![0; states + 1];
        Self {
            symmetric,
            lower_points: 0,
            by_offset: Vec::new(),
            diagonal: none.clone(),
            vertical: none.clone(),
            gaps: none.clone(),
            recurrence_times: none,
            above: HalfColumns::new(states),
            below: HalfColumns::new(states),
        }
    }

    /// Appends the counts of the diagonals that follow.
    pub fn append(mut self, next: Self) -> Self {
        for (sum, next) in [
            (&mut self.diagonal, &next.diagonal),
            (&mut self.vertical, &next.vertical),
            (&mut self.gaps, &next.gaps),
            (&mut self.recurrence_times, &next.recurrence_times),
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
            let mut boundary = Boundary {
                lines: &mut self.vertical,
                gaps: &mut self.gaps,
                recurrence_times: &mut self.recurrence_times,
                returns_from,
            };
            half.append(next, &mut boundary);
        }
        self
    }

    /// Final counts, once all diagonals from the first counted to the empty one are included.
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
            self.count_line_through_identity();
        }
        RecurrenceCounts {
            rows: states,
            columns: states,
            theiler,
            recurrent,
            diagonal: LineHistogram::from(self.diagonal),
            vertical: LineHistogram::from(self.vertical),
            gaps: LineHistogram::from(self.gaps),
            recurrence_times: LineHistogram::from(self.recurrence_times),
            by_offset,
        }
    }

    /// Counts the vertical line through the line of identity, which both halves of a column share, and
    /// its recurrence time. The line has `end` points in either half, with the identity point in both.
    fn count_line_through_identity(&mut self) {
        for (above, below) in self.above.first.iter().zip(&self.below.first) {
            self.vertical[(above.end + below.end - 1) as usize] += 1;
            if below.begin != NO_OFFSET {
                self.recurrence_times[(below.begin + above.end - 1) as usize] += 1;
            }
        }
    }
}

impl LineCounter {
    /// Counts the next diagonal. Inlined for the instruction set of the machine.
    #[inline(always)]
    pub fn count(&mut self, diagonal: &Diagonal<'_>) {
        let offset = diagonal.offset as u32;
        // The previous diagonal has one more pair.
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

        // Pair (i + k, i) has the same column, i, as before.
        let (gaps, lines, recurrence_times) = (
            &mut self.gaps,
            &mut self.vertical,
            &mut self.recurrence_times,
        );
        for (word, (&now, &before)) in lower[..words].iter().zip(*lower_before).enumerate() {
            each_bit(now & !before, |bit| {
                let last = self.below.begin(64 * word + bit, offset, gaps);
                if last != NO_OFFSET {
                    recurrence_times[(offset - last) as usize] += 1;
                }
            });
            each_bit(before & !now, |bit| {
                self.below.end(64 * word + bit, offset, lines);
            });
        }

        // Pair (i, i + k) has the column of pair i + 1 of the previous diagonal, whose pair 0 remains.
        let mut end = |column| {
            let last = self.above.end(column, offset, lines);
            if last != NO_OFFSET {
                recurrence_times[(offset - last) as usize] += 1;
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

/// Number of set bits.
#[inline(always)]
fn points(words: &[u64]) -> u64 {
    words.iter().map(|word| u64::from(word.count_ones())).sum()
}

/// Calls `take` with the positions of the set bits, in order.
#[inline(always)]
fn each_bit(mut bits: u64, mut take: impl FnMut(usize)) {
    while bits != 0 {
        take(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// Counts the runs of set bits by length. The last word is zero.
#[inline(always)]
fn count_runs(words: &[u64], lines: &mut Lines) {
    // Start of the run that extends into the word.
    let mut begin = 0;
    let mut open = 0;
    for (word, &bits) in words.iter().enumerate() {
        // A change between adjacent bits marks the start of a run or the position after its end.
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
