//! States of a window, and tests for their recurrence.

use crate::analysis::Norm;

/// Number of pairs whose distances are computed together.
const LANES: usize = 8;

/// Bits per word of a mask.
pub(super) const WORD: usize = u64::BITS as usize;

/// Direction from one pair of states to the next.
#[derive(Clone, Copy)]
pub(super) enum Along {
    /// `(i, j)`, `(i + 1, j)`, ...
    Column,
    /// `(i, j)`, `(i + 1, j + 1)`, ...
    Diagonal,
}

/// Delay vectors of the newest samples of a stream, numbered from its start.
#[derive(Clone, Debug)]
pub(super) struct States {
    /// Padded with zeros: [`LANES`] values can be read from any sample.
    samples: Vec<f64>,
    /// The state whose oldest coordinate is `samples[0]`.
    first: usize,
    lag: usize,
    dimension: usize,
    norm: Norm,
    /// Largest unrooted distance (see [`Norm`]) of a recurrent pair.
    limit: f64,
    /// Number of distances computed so far.
    #[cfg(test)]
    pub evaluations: std::cell::Cell<u64>,
}

impl States {
    /// No states; pairs within `epsilon` will be recurrent.
    pub fn new(lag: usize, dimension: usize, norm: Norm, epsilon: f64) -> Self {
        Self {
            samples: vec![0.0; LANES],
            first: 0,
            lag,
            dimension,
            norm,
            limit: norm.unrooted_limit(epsilon),
            #[cfg(test)]
            evaluations: std::cell::Cell::new(0),
        }
    }

    /// Appends a sample. Returns the number of states since the start of the stream.
    pub fn push(&mut self, sample: f64) -> usize {
        let kept = self.samples.len() - LANES;
        self.samples[kept] = sample;
        self.samples.push(0.0);
        (self.first + kept + 1).saturating_sub((self.dimension - 1).saturating_mul(self.lag))
    }

    /// Drops samples used only by states before `oldest`, once they are more than half of the buffer. A
    /// sample is moved less than once on average.
    pub fn drop_before(&mut self, oldest: usize) {
        let unused = oldest - self.first;
        if 2 * unused > self.samples.len() {
            self.samples.drain(..unused);
            self.first = oldest;
        }
    }

    /// Bit `k` of `mask`: is `newest - k` recurrent with `newest`, for `k` from `min_offset` up to
    /// `oldest`.
    #[inline(always)]
    pub fn recurrent_earlier(
        &self,
        oldest: usize,
        newest: usize,
        min_offset: usize,
        mask: &mut Vec<u64>,
    ) {
        mask.clear();
        let in_window = newest - oldest + 1;
        for offset in (0..in_window).step_by(WORD) {
            let count = WORD.min(in_window - offset);
            let rows = self.recurrent(newest + 1 - offset - count, newest, count, Along::Column);
            mask.push((rows << (WORD - count)).reverse_bits());
        }
        clear_below(min_offset, mask);
    }

    /// Bit `k` of `mask`: is `oldest + k` recurrent with `oldest`, for `k` from `min_offset` up to
    /// `newest`.
    #[inline(always)]
    pub fn recurrent_later(
        &self,
        oldest: usize,
        newest: usize,
        min_offset: usize,
        mask: &mut Vec<u64>,
    ) {
        mask.clear();
        let in_window = newest - oldest + 1;
        for offset in (0..in_window).step_by(WORD) {
            let count = WORD.min(in_window - offset);
            mask.push(self.recurrent(oldest + offset, oldest, count, Along::Column));
        }
        clear_below(min_offset, mask);
    }

    /// Length of the run of recurrent (or of non-recurrent) pairs that starts at `(i, j)`, at most
    /// `max_length`.
    #[inline(always)]
    pub fn run(
        &self,
        recurrent: bool,
        i: usize,
        j: usize,
        max_length: usize,
        along: Along,
    ) -> usize {
        let mut length = 0;
        // The block size doubles for long runs; a block is at most twice as long as needed.
        let mut stride = LANES;
        while length < max_length {
            let count = stride.min(max_length - length);
            let j = match along {
                Along::Column => j,
                Along::Diagonal => j + length,
            };
            let word = self.recurrent(i + length, j, count, along);
            let same = if recurrent { word } else { !word };
            let same = (same.trailing_ones() as usize).min(count);
            length += same;
            if same < count {
                break;
            }
            stride = WORD.min(2 * stride);
        }
        length
    }

    /// Bits of the recurrent ones among `count` pairs (at most 64) from `(i, j)`.
    #[inline(always)]
    fn recurrent(&self, i: usize, j: usize, count: usize, along: Along) -> u64 {
        #[cfg(test)]
        self.evaluations.set(self.evaluations.get() + count as u64);
        match self.norm {
            Norm::Euclidean => self.compare(i, j, count, along, |sum, d| sum + d * d),
            Norm::Maximum => self.compare(i, j, count, along, |largest, d| {
                if d.abs() > largest { d.abs() } else { largest }
            }),
            Norm::Manhattan => self.compare(i, j, count, along, |sum, d| sum + d.abs()),
        }
    }

    /// [`States::recurrent`] for a norm that accumulates coordinate differences.
    #[inline(always)]
    fn compare(
        &self,
        i: usize,
        j: usize,
        count: usize,
        along: Along,
        add: impl Fn(f64, f64) -> f64 + Copy,
    ) -> u64 {
        if count == WORD {
            return self.block::<WORD>(i, j, along, add);
        }
        let mut bits = 0;
        for start in (0..count).step_by(LANES) {
            let there = match along {
                Along::Column => j,
                Along::Diagonal => j + start,
            };
            bits |= self.block::<LANES>(i + start, there, along, add) << start;
        }
        // Clear the lanes after the last pair.
        bits & (u64::MAX >> (WORD - count))
    }

    /// Bits of the recurrent ones among `N` pairs from `(i, j)`.
    #[inline(always)]
    fn block<const N: usize>(
        &self,
        i: usize,
        j: usize,
        along: Along,
        add: impl Fn(f64, f64) -> f64,
    ) -> u64 {
        let mut sums = [0.0; N];
        for c in 0..self.dimension {
            let from = |state: usize| &self.samples[state - self.first + c * self.lag..];
            let here: &[f64; N] = from(i).first_chunk().expect("padded");
            match along {
                Along::Column => {
                    let there = from(j)[0];
                    for (sum, here) in sums.iter_mut().zip(here) {
                        *sum = add(*sum, here - there);
                    }
                }
                Along::Diagonal => {
                    let there: &[f64; N] = from(j).first_chunk().expect("padded");
                    for (sum, (here, there)) in sums.iter_mut().zip(here.iter().zip(there)) {
                        *sum = add(*sum, here - there);
                    }
                }
            }
        }
        let mut bits = 0;
        for (lane, &sum) in sums.iter().enumerate() {
            bits |= u64::from(sum <= self.limit) << lane;
        }
        bits
    }
}

/// Clears the bits below `min_offset`.
fn clear_below(min_offset: usize, mask: &mut [u64]) {
    let full_words = (min_offset / WORD).min(mask.len());
    mask[..full_words].fill(0);
    if let Some(word) = mask.get_mut(full_words) {
        *word &= u64::MAX << (min_offset % WORD);
    }
}
