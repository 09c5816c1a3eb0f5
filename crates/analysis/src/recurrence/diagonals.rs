//! Recurrent pairs of delay vectors as bits, one diagonal of the plot at a time.
//!
//! Along a diagonal `j - i = k` the coordinates of all pairs are differences of the same two sections of
//! the signal, `u[n] - u[n + k]`. Each difference is squared (or its absolute value taken) once. The
//! unrooted distance of pair `i` is the sum of the terms at `i`, `i + lag`, `i + 2 lag`, ... In any
//! dimension this takes only loads and additions of contiguous numbers.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::line_counter::LineCounter;
use crate::simd::{lane_bits, vectorised};
use crate::{DelayVectors, Norm};

/// Diagonals processed together. Their sections of the signal stay in the L1 cache.
const DIAGONALS_PER_BLOCK: usize = 16;
/// Minimum number of states per chunk of a diagonal.
const MIN_CHUNK: usize = 1024;
/// Vectors processed at a time, enough to hide the latency of an addition.
const GROUP: usize = 8;

/// Limits of the unrooted distance of recurrent pairs.
#[derive(Clone, Copy, Debug)]
pub(super) enum Limits<'a> {
    /// The same limit for all pairs.
    One(f64),
    /// One limit per column (state), padded with at least 64 unused values.
    Columns(&'a [f64]),
}

/// Recurrent pairs of one diagonal `k` and of the previous one, `k - 1`. Bit `i % 64` of word `i / 64`
/// is pair `i` of the diagonal. At least one whole word of zeros follows the last pair.
pub(super) struct Diagonal<'a> {
    /// `j - i`.
    pub offset: usize,
    /// Pairs `(i, i + k)`: row `i`, column `i + k`.
    pub upper: &'a [u64],
    /// Pairs `(i + k, i)` in the plot; with [`Limits::One`] the same bits.
    pub lower: &'a [u64],
    /// `upper` of the previous diagonal; zeros if that one is not counted.
    pub upper_before: &'a [u64],
    /// `lower` of the previous diagonal.
    pub lower_before: &'a [u64],
}

/// The pairs of delay vectors outside a Theiler window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pairs<'a> {
    pub vectors: DelayVectors<'a>,
    pub norm: Norm,
    pub states: usize,
    pub theiler: usize,
}

impl<'a> Pairs<'a> {
    pub fn new(vectors: &DelayVectors<'a>, norm: Norm, theiler: usize) -> Self {
        Self {
            vectors: *vectors,
            norm,
            states: vectors.len(),
            theiler,
        }
    }

    /// Appends the unrooted distances between state `j` and others, in order.
    pub fn unrooted_row(&self, j: usize, others: Range<usize>, sums: &mut Vec<f64>) {
        let from = sums.len();
        sums.resize(from + others.len(), 0.0);
        let sums = &mut sums[from..];
        vectorised(
            #[inline(always)]
            || {
                for coordinate in (0..self.vectors.dimension()).map(|c| c * self.vectors.lag()) {
                    let here = self.vectors.samples()[j + coordinate];
                    let there = &self.vectors.samples()[others.start + coordinate..];
                    let both = sums.iter_mut().zip(there);
                    match self.norm {
                        Norm::Euclidean => both.for_each(|(e, x)| *e += (x - here) * (x - here)),
                        Norm::Maximum => both.for_each(|(e, x)| *e = (x - here).abs().max(*e)),
                        Norm::Manhattan => both.for_each(|(e, x)| *e += (x - here).abs()),
                    }
                }
            },
        );
    }

    /// Counted offsets of the upper triangle, without the line of identity.
    pub fn offsets(&self) -> Range<usize> {
        self.theiler.max(1)..self.states
    }

    /// Offsets of the upper triangle in blocks of about equally many pairs. The last offset is the empty
    /// diagonal at which all lines have ended. The blocks do not depend on the number of threads.
    pub fn blocks(&self) -> Vec<Range<usize>> {
        const BLOCKS: usize = 64;
        let offsets = self.offsets();
        let (first, last) = (offsets.start, self.states + 1);
        if first >= last {
            return Vec::new();
        }
        // From offset k on there are about (n - k)^2 / 2 pairs.
        let bound = |block: usize| {
            let share = ((BLOCKS - block) as f64 / BLOCKS as f64).sqrt();
            last - (share * (last - first) as f64).round() as usize
        };
        let blocks = (0..BLOCKS).map(|block| bound(block)..bound(block + 1));
        blocks.filter(|block| !block.is_empty()).collect()
    }

    /// Counts the diagonals with these offsets, in order. Offset `n` is an empty diagonal.
    pub fn count(&self, offsets: Range<usize>, limits: Limits<'_>, counter: &mut LineCounter) {
        let arch = Arch::new();
        match self.norm {
            Norm::Euclidean => arch.dispatch(Sweep(self, offsets, limits, counter, SumOfSquares)),
            Norm::Maximum => arch.dispatch(Sweep(self, offsets, limits, counter, Maximum)),
            Norm::Manhattan => {
                arch.dispatch(Sweep(self, offsets, limits, counter, SumOfMagnitudes))
            }
        }
    }
}

/// Vectorised [`Norm::unrooted`].
pub(super) trait VectorNorm: Copy {
    fn term<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s;
    fn combine<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s;
}

#[derive(Clone, Copy)]
pub(super) struct SumOfSquares;
#[derive(Clone, Copy)]
pub(super) struct Maximum;
#[derive(Clone, Copy)]
pub(super) struct SumOfMagnitudes;

impl VectorNorm for SumOfSquares {
    #[inline(always)]
    fn term<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s {
        simd.mul_f64s(difference, difference)
    }
    #[inline(always)]
    fn combine<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.add_f64s(a, b)
    }
}

impl VectorNorm for Maximum {
    #[inline(always)]
    fn term<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s {
        simd.abs_f64s(difference)
    }
    #[inline(always)]
    fn combine<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.max_f64s(a, b)
    }
}

impl VectorNorm for SumOfMagnitudes {
    #[inline(always)]
    fn term<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s {
        simd.abs_f64s(difference)
    }
    #[inline(always)]
    fn combine<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.add_f64s(a, b)
    }
}

/// [`Pairs::count`] for one instruction set.
pub(super) struct Sweep<'a, E>(
    pub &'a Pairs<'a>,
    pub Range<usize>,
    pub Limits<'a>,
    pub &'a mut LineCounter,
    pub E,
);

impl<E: VectorNorm> WithSimd for Sweep<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(pairs, offsets, limits, counter, norm) = self;
        let comparison = Comparison { pairs, limits };
        let mut bits = BitRows::new(pairs);
        // If the diagonal before the first counts, it is computed with the first block.
        let mut known = usize::from(offsets.start <= pairs.theiler);
        let mut first = offsets.start - 1;
        while first + 1 < offsets.end && !pairs.vectors.is_stopped() {
            let count = DIAGONALS_PER_BLOCK.min(offsets.end - first - 1);
            bits.fill(simd, norm, comparison, first, known..count + 1);
            known = 1;
            for r in 1..=count {
                counter.count(&Diagonal {
                    offset: first + r,
                    upper: &bits.upper[bits.row(r)],
                    lower: &bits.lower[bits.row(r)],
                    upper_before: &bits.upper[bits.row(r - 1)],
                    lower_before: &bits.lower[bits.row(r - 1)],
                });
            }
            let last = bits.row(count);
            bits.upper.copy_within(last.clone(), 0);
            bits.lower.copy_within(last, 0);
            first += count;
        }
    }
}

/// Pairs and limits to compare.
#[derive(Clone, Copy)]
struct Comparison<'a> {
    pairs: &'a Pairs<'a>,
    limits: Limits<'a>,
}

/// Bits of successive diagonals.
struct BitRows {
    /// Words per row.
    stride: usize,
    /// One row for the previous diagonal, then one for each diagonal processed together.
    upper: Vec<u64>,
    lower: Vec<u64>,
    /// States per chunk of a diagonal.
    chunk: usize,
    /// Workspace: the terms of the unrooted distances along a chunk.
    terms: Vec<f64>,
}

impl BitRows {
    fn new(pairs: &Pairs<'_>) -> Self {
        let span = (pairs.vectors.dimension() - 1) * pairs.vectors.lag();
        let chunk = MIN_CHUNK.max(8 * span).min(pairs.states);
        let chunk = chunk.next_multiple_of(64);
        let stride = pairs.states.div_ceil(64) + 1;
        let bits = vec![0; (1 + DIAGONALS_PER_BLOCK) * stride];
        Self {
            stride,
            upper: bits.clone(),
            lower: bits,
            chunk,
            terms: vec![0.0; chunk + span],
        }
    }

    #[inline(always)]
    fn row(&self, r: usize) -> Range<usize> {
        r * self.stride..(r + 1) * self.stride
    }

    /// Fills these rows: row `r` with the diagonal `first + r`.
    #[inline(always)]
    fn fill<S: Simd, E: VectorNorm>(
        &mut self,
        simd: S,
        norm: E,
        comparison: Comparison<'_>,
        first: usize,
        rows: Range<usize>,
    ) {
        let pairs = comparison.pairs;
        for start in (0..pairs.states - (first + rows.start)).step_by(self.chunk) {
            for r in rows.clone() {
                let left = (pairs.states - (first + r)).saturating_sub(start);
                let block = Chunk {
                    offset: first + r,
                    start,
                    length: left.min(self.chunk),
                };
                if block.length > 0 {
                    let words = self.row(r).start + start / 64..;
                    let upper = &mut self.upper[words.clone()][..block.length.div_ceil(64)];
                    let lower = &mut self.lower[words][..block.length.div_ceil(64)];
                    block.fill(simd, norm, comparison, &mut self.terms, [upper, lower]);
                }
            }
        }
        // Clear the bits of a longer previous diagonal.
        for r in rows {
            let used = (pairs.states - (first + r)).div_ceil(64);
            let left = self.row(r).start + used..self.row(r).end;
            self.upper[left.clone()].fill(0);
            self.lower[left].fill(0);
        }
    }
}

/// Part of a diagonal.
struct Chunk {
    offset: usize,
    /// Index of the first pair.
    start: usize,
    /// Number of pairs.
    length: usize,
}

impl Chunk {
    /// Fills words with the bits of the chunk. Bits after its end are zero.
    #[inline(always)]
    fn fill<S: Simd, E: VectorNorm>(
        self,
        simd: S,
        norm: E,
        Comparison { pairs, limits }: Comparison<'_>,
        terms: &mut [f64],
        [upper, lower]: [&mut [u64]; 2],
    ) {
        let Self {
            offset,
            start,
            length,
        } = self;
        let span = (pairs.vectors.dimension() - 1) * pairs.vectors.lag();
        let here = &pairs.vectors.samples()[start..][..length + span];
        let there = &pairs.vectors.samples()[start + offset..][..length + span];
        differences(simd, norm, here, there, &mut terms[..length + span]);

        for (word, (upper, lower)) in upper.iter_mut().zip(lower).enumerate() {
            let at = 64 * word;
            (*upper, *lower) = (0, 0);
            for first in (0..64).step_by(GROUP * S::F64_LANES) {
                let mut sums = [simd.splat_f64s(0.0); GROUP];
                for coordinate in 0..pairs.vectors.dimension() {
                    let from = at + first + coordinate * pairs.vectors.lag();
                    let (terms, _) = S::as_simd_f64s(&terms[from..][..GROUP * S::F64_LANES]);
                    for (sum, term) in sums.iter_mut().zip(terms) {
                        *sum = norm.combine(simd, *sum, *term);
                    }
                }
                let (u, l) = match limits {
                    Limits::One(limit) => {
                        let limit = simd.splat_f64s(limit);
                        let bits = bits_within(simd, &sums, |_| limit);
                        (bits, bits)
                    }
                    Limits::Columns(limits) => {
                        let row = start + at + first;
                        let of = |column: usize| {
                            let limits = S::as_simd_f64s(&limits[column..]).0;
                            move |v: usize| limits[v]
                        };
                        (
                            bits_within(simd, &sums, of(row + offset)),
                            bits_within(simd, &sums, of(row)),
                        )
                    }
                };
                *upper |= u << first;
                *lower |= l << first;
            }
            if length - at < 64 {
                let inside = (1 << (length - at)) - 1;
                *upper &= inside;
                *lower &= inside;
            }
        }
    }
}

/// Terms of the unrooted distances: squares or absolute values of the differences.
#[inline(always)]
fn differences<S: Simd, E: VectorNorm>(
    simd: S,
    norm: E,
    here: &[f64],
    there: &[f64],
    terms: &mut [f64],
) {
    let (here, here_rest) = S::as_simd_f64s(here);
    let (there, there_rest) = S::as_simd_f64s(there);
    let (terms, terms_rest) = S::as_mut_simd_f64s(terms);
    for ((term, &a), &b) in terms.iter_mut().zip(here).zip(there) {
        *term = norm.term(simd, simd.sub_f64s(a, b));
    }
    let (a, b) = (
        simd.partial_load_f64s(here_rest),
        simd.partial_load_f64s(there_rest),
    );
    simd.partial_store_f64s(terms_rest, norm.term(simd, simd.sub_f64s(a, b)));
}

/// One bit per lane of the group, set where the unrooted distance is within the limit.
#[inline(always)]
fn bits_within<S: Simd>(simd: S, sums: &[S::f64s; GROUP], limit: impl Fn(usize) -> S::f64s) -> u64 {
    let mut bits = 0;
    for (v, &sum) in sums.iter().enumerate() {
        let within = simd.less_than_or_equal_f64s(sum, limit(v));
        bits |= lane_bits(simd, within) << (v * S::F64_LANES);
    }
    bits
}
