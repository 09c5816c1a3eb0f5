//! The states a window holds, and which of them are near one another.

use crate::analysis::Norm;

/// Pairs whose distances are evaluated together.
const LANES: usize = 8;

/// Bits in a word of a mask.
pub(super) const WORD: usize = u64::BITS as usize;

/// The way from one pair of states to the next.
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
    /// Followed by zeros, so that [`LANES`] can be read wherever there is one.
    samples: Vec<f64>,
    /// The state whose oldest coordinate is `samples[0]`.
    first: usize,
    lag: usize,
    dimension: usize,
    norm: Norm,
    /// The largest extent (see [`Norm`]) of a recurrent pair.
    limit: f64,
    /// Distances asked for so far.
    #[cfg(test)]
    pub evaluations: std::cell::Cell<u64>,
}

impl States {
    /// No states yet, near one another at `epsilon` or less.
    pub fn new(lag: usize, dimension: usize, norm: Norm, epsilon: f64) -> Self {
        Self {
            samples: vec![0.0; LANES],
            first: 0,
            lag,
            dimension,
            norm,
            limit: norm.extent_within(epsilon),
            #[cfg(test)]
            evaluations: std::cell::Cell::new(0),
        }
    }

    /// Takes a sample, and tells how many states there have been since the start.
    pub fn push(&mut self, sample: f64) -> usize {
        let kept = self.samples.len() - LANES;
        self.samples[kept] = sample;
        self.samples.push(0.0);
        (self.first + kept + 1).saturating_sub((self.dimension - 1).saturating_mul(self.lag))
    }

    /// Drops what only states before `oldest` are made of, once that is most of what is kept: a
    /// sample is moved less than once on average.
    pub fn forget_before(&mut self, oldest: usize) {
        let dead = oldest - self.first;
        if 2 * dead > self.samples.len() {
            self.samples.drain(..dead);
            self.first = oldest;
        }
    }

    /// Bit `k` of `mask`: is `newest - k` near `newest`, for `k` from `least` on until the state
    /// before `oldest`.
    #[inline(always)]
    pub fn near_earlier(&self, oldest: usize, newest: usize, least: usize, mask: &mut Vec<u64>) {
        mask.clear();
        let held = newest - oldest + 1;
        for offset in (0..held).step_by(WORD) {
            let count = WORD.min(held - offset);
            let rows = self.near(newest + 1 - offset - count, newest, count, Along::Column);
            mask.push((rows << (WORD - count)).reverse_bits());
        }
        clear_below(least, mask);
    }

    /// Bit `k` of `mask`: is `oldest + k` near `oldest`, for `k` from `least` on until the state
    /// after `newest`.
    #[inline(always)]
    pub fn near_later(&self, oldest: usize, newest: usize, least: usize, mask: &mut Vec<u64>) {
        mask.clear();
        let held = newest - oldest + 1;
        for offset in (0..held).step_by(WORD) {
            let count = WORD.min(held - offset);
            mask.push(self.near(oldest + offset, oldest, count, Along::Column));
        }
        clear_below(least, mask);
    }

    /// How many pairs from `(i, j)` on, at most `most`, are near without a break (or not near
    /// without a break).
    #[inline(always)]
    pub fn run(&self, near: bool, i: usize, j: usize, most: usize, along: Along) -> usize {
        let mut length = 0;
        // Long runs are measured in longer and longer strides, none longer than twice the way.
        let mut stride = LANES;
        while length < most {
            let count = stride.min(most - length);
            let j = match along {
                Along::Column => j,
                Along::Diagonal => j + length,
            };
            let word = self.near(i + length, j, count, along);
            let same = if near { word } else { !word };
            let same = (same.trailing_ones() as usize).min(count);
            length += same;
            if same < count {
                break;
            }
            stride = WORD.min(2 * stride);
        }
        length
    }

    /// Which of `count` pairs (at most 64) from `(i, j)` on are near.
    #[inline(always)]
    fn near(&self, i: usize, j: usize, count: usize, along: Along) -> u64 {
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

    /// [`States::near`] in a norm that is made of the coordinates' differences one by one.
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
        // The last lanes may be of pairs that were not asked for.
        bits & (u64::MAX >> (WORD - count))
    }

    /// Which of `N` pairs from `(i, j)` on are near.
    #[inline(always)]
    fn block<const N: usize>(
        &self,
        i: usize,
        j: usize,
        along: Along,
        add: impl Fn(f64, f64) -> f64,
    ) -> u64 {
        let mut extents = [0.0; N];
        for c in 0..self.dimension {
            let from = |state: usize| &self.samples[state - self.first + c * self.lag..];
            let here: &[f64; N] = from(i).first_chunk().expect("padded");
            match along {
                Along::Column => {
                    let there = from(j)[0];
                    for (extent, here) in extents.iter_mut().zip(here) {
                        *extent = add(*extent, here - there);
                    }
                }
                Along::Diagonal => {
                    let there: &[f64; N] = from(j).first_chunk().expect("padded");
                    for (extent, (here, there)) in extents.iter_mut().zip(here.iter().zip(there)) {
                        *extent = add(*extent, here - there);
                    }
                }
            }
        }
        let mut bits = 0;
        for (lane, &extent) in extents.iter().enumerate() {
            bits |= u64::from(extent <= self.limit) << lane;
        }
        bits
    }
}

/// Clears the bits below `least`.
fn clear_below(least: usize, mask: &mut [u64]) {
    let whole = (least / WORD).min(mask.len());
    mask[..whole].fill(0);
    if let Some(word) = mask.get_mut(whole) {
        *word &= u64::MAX << (least % WORD);
    }
}
