//! What is counted in a recurrence plot: points and lines, by length.

/// How many lines there are of each length.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineHistogram {
    /// `counts[l]` lines of length `l`; the last entry is not zero; `counts[0]` is.
    counts: Vec<u64>,
}

impl LineHistogram {
    /// Lines of length `l`.
    pub fn of_length(&self, length: usize) -> u64 {
        self.counts.get(length).copied().unwrap_or(0)
    }

    /// All lengths that occur with their number, shortest first.
    pub fn iter(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let all = self.counts.iter().copied().enumerate();
        all.filter(|&(_, count)| count > 0)
    }
}

/// All that is counted in a recurrence plot; integers, so that every way of counting agrees to
/// the last bit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecurrenceCounts {
    /// States along a side, `N`.
    pub size: usize,
    /// Theiler window: pairs with `|i - j|` below it are not counted.
    pub theiler: usize,
    /// Recurrent points outside the Theiler window, both triangles.
    pub recurrent: u64,
    /// Diagonal lines, both triangles.
    pub diagonal: LineHistogram,
    /// Vertical lines.
    pub vertical: LineHistogram,
    /// Gaps between vertical lines (white vertical lines, recurrence times of the second type).
    pub gaps: LineHistogram,
    /// Recurrent points on the diagonals `j - i = k`, `k = 0, 1, ...` (upper triangle).
    pub by_offset: Vec<u64>,
}
