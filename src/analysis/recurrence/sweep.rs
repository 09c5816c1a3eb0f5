//! The recurrent pairs of delay vectors, a diagonal of the plot after the other, as bits.
//!
//! Along a diagonal `j - i = k` the coordinates of all pairs are differences of the same two
//! stretches of the signal, `u[n] - u[n + k]`. Each is squared once (or made positive); the
//! extent of pair `i` is then the sum of those at `i`, `i + lag`, `i + 2 lag`, ...: whatever the
//! dimension, loads and additions of neighbouring numbers.

use std::ops::Range;

use pulp::bytemuck::bytes_of;
use pulp::{Arch, Simd, WithSimd};

use crate::analysis::{DelayVectors, Norm};

/// Diagonals worked on together: their stretches of the signal stay in the nearest cache.
const TOGETHER: usize = 16;
/// States along a diagonal worked on at a time, at least.
const STRETCH: usize = 1024;
/// Vectors worked on at a time: enough to hide the latency of an addition.
const GROUP: usize = 8;

/// Which extents are recurrent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Limits<'a> {
    /// Those up to this one.
    One(f64),
    /// Those up to the first (upper bits) and those up to the second (lower bits).
    Two(f64, f64),
    /// Those up to that of the column: one for each state, and at least 64 that are not used.
    Columns(&'a [f64]),
}

/// The recurrent pairs of one diagonal `k` and of the one before, `k - 1`: bit `i % 64` of word
/// `i / 64` is pair `i` of the diagonal. Beyond the last pair there are zeros, a whole word at
/// least.
pub(super) struct Diagonal<'a> {
    /// `j - i`.
    pub offset: usize,
    /// Pairs `(i, i + k)`: row `i`, column `i + k`.
    pub upper: &'a [u64],
    /// Pairs `(i + k, i)` in the plot; with [`Limits::One`] the same bits.
    pub lower: &'a [u64],
    /// `upper` of the diagonal before; zeros if that one is not counted.
    pub upper_before: &'a [u64],
    /// `lower` of the diagonal before.
    pub lower_before: &'a [u64],
}

/// What is done with the diagonals.
pub(super) trait Visitor {
    /// Takes the next diagonal. To be inlined, for the instructions that the machine has.
    fn visit(&mut self, diagonal: &Diagonal<'_>);
}

/// The pairs of delay vectors outside a Theiler window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pairs<'a> {
    pub samples: &'a [f64],
    lag: usize,
    dimension: usize,
    pub norm: Norm,
    pub states: usize,
    pub theiler: usize,
}

impl<'a> Pairs<'a> {
    pub fn new(vectors: &DelayVectors<'a>, norm: Norm, theiler: usize) -> Self {
        Self {
            samples: vectors.samples(),
            lag: vectors.lag(),
            dimension: vectors.dimension(),
            norm,
            states: vectors.len(),
            theiler,
        }
    }

    /// Extent of the difference between two states.
    pub fn extent(&self, i: usize, j: usize) -> f64 {
        let coordinates = (0..self.dimension).map(|c| c * self.lag);
        let difference = |c: usize| self.samples[i + c] - self.samples[j + c];
        self.norm.extent(coordinates.map(difference))
    }

    /// Appends the extents of the differences between state `j` and others, in order.
    pub fn extents(&self, j: usize, others: Range<usize>, extents: &mut Vec<f64>) {
        let from = extents.len();
        extents.resize(from + others.len(), 0.0);
        let extents = &mut extents[from..];
        Arch::new().dispatch(|| {
            for coordinate in (0..self.dimension).map(|c| c * self.lag) {
                let here = self.samples[j + coordinate];
                let there = &self.samples[others.start + coordinate..];
                let both = extents.iter_mut().zip(there);
                match self.norm {
                    Norm::Euclidean => both.for_each(|(e, x)| *e += (x - here) * (x - here)),
                    Norm::Maximum => both.for_each(|(e, x)| *e = (x - here).abs().max(*e)),
                    Norm::Manhattan => both.for_each(|(e, x)| *e += (x - here).abs()),
                }
            }
        });
    }

    /// The offsets of the upper triangle that are counted, without the line of identity.
    pub fn offsets(&self) -> Range<usize> {
        self.theiler.max(1)..self.states
    }

    /// The offsets of the upper triangle, and as the last one the empty diagonal at which all
    /// lines have ended, in pieces of about equally many pairs. The pieces do not depend on the
    /// number of threads.
    pub fn pieces(&self) -> Vec<Range<usize>> {
        const PIECES: usize = 64;
        let offsets = self.offsets();
        let (first, last) = (offsets.start, self.states + 1);
        if first >= last {
            return Vec::new();
        }
        // From offset k on there are about (n - k)^2 / 2 pairs.
        let bound = |piece: usize| {
            let share = ((PIECES - piece) as f64 / PIECES as f64).sqrt();
            last - (share * (last - first) as f64).round() as usize
        };
        let pieces = (0..PIECES).map(|piece| bound(piece)..bound(piece + 1));
        pieces.filter(|piece| !piece.is_empty()).collect()
    }

    /// Shows the visitor the diagonals with these offsets, in order. Offset `n` is an empty one.
    pub fn visit(&self, offsets: Range<usize>, limits: Limits<'_>, visitor: &mut impl Visitor) {
        let arch = Arch::new();
        match self.norm {
            Norm::Euclidean => arch.dispatch(Sweep(self, offsets, limits, visitor, SumOfSquares)),
            Norm::Maximum => arch.dispatch(Sweep(self, offsets, limits, visitor, Largest)),
            Norm::Manhattan => arch.dispatch(Sweep(self, offsets, limits, visitor, Sum)),
        }
    }

    /// [`Pairs::visit`] with chosen instructions.
    #[cfg(test)]
    pub fn visit_with(
        &self,
        simd: impl Simd,
        offsets: Range<usize>,
        limits: Limits<'_>,
        visitor: &mut impl Visitor,
    ) {
        match self.norm {
            Norm::Euclidean => simd.vectorize(Sweep(self, offsets, limits, visitor, SumOfSquares)),
            Norm::Maximum => simd.vectorize(Sweep(self, offsets, limits, visitor, Largest)),
            Norm::Manhattan => simd.vectorize(Sweep(self, offsets, limits, visitor, Sum)),
        }
    }
}

/// How an extent is put together: [`Norm::extent`] for vectors.
trait Extent: Copy {
    fn of_one<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s;
    fn join<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s;
}

#[derive(Clone, Copy)]
struct SumOfSquares;
#[derive(Clone, Copy)]
struct Largest;
#[derive(Clone, Copy)]
struct Sum;

impl Extent for SumOfSquares {
    #[inline(always)]
    fn of_one<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s {
        simd.mul_f64s(difference, difference)
    }
    #[inline(always)]
    fn join<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.add_f64s(a, b)
    }
}

impl Extent for Largest {
    #[inline(always)]
    fn of_one<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s {
        simd.abs_f64s(difference)
    }
    #[inline(always)]
    fn join<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.max_f64s(a, b)
    }
}

impl Extent for Sum {
    #[inline(always)]
    fn of_one<S: Simd>(self, simd: S, difference: S::f64s) -> S::f64s {
        simd.abs_f64s(difference)
    }
    #[inline(always)]
    fn join<S: Simd>(self, simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.add_f64s(a, b)
    }
}

/// [`Pairs::visit`] with the instructions of a machine.
struct Sweep<'a, V, E>(&'a Pairs<'a>, Range<usize>, Limits<'a>, &'a mut V, E);

impl<V: Visitor, E: Extent> WithSimd for Sweep<'_, V, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(pairs, offsets, limits, visitor, extent) = self;
        let asked = Asked { pairs, limits };
        let mut board = Board::new(pairs);
        // The diagonal before the first, if it counts, is worked out with the first ones.
        let mut known = usize::from(offsets.start <= pairs.theiler);
        let mut first = offsets.start - 1;
        while first + 1 < offsets.end {
            let count = TOGETHER.min(offsets.end - first - 1);
            board.fill(simd, extent, asked, first, known..count + 1);
            known = 1;
            for r in 1..=count {
                visitor.visit(&Diagonal {
                    offset: first + r,
                    upper: &board.upper[board.row(r)],
                    lower: &board.lower[board.row(r)],
                    upper_before: &board.upper[board.row(r - 1)],
                    lower_before: &board.lower[board.row(r - 1)],
                });
            }
            let last = board.row(count);
            board.upper.copy_within(last.clone(), 0);
            board.lower.copy_within(last, 0);
            first += count;
        }
    }
}

/// What is to be compared.
#[derive(Clone, Copy)]
struct Asked<'a> {
    pairs: &'a Pairs<'a>,
    limits: Limits<'a>,
}

/// The bits of successive diagonals.
struct Board {
    /// Words of a row.
    stride: usize,
    /// A row for the diagonal before, then one for each of those worked on together.
    upper: Vec<u64>,
    lower: Vec<u64>,
    /// States along a diagonal worked on at a time.
    stretch: usize,
    /// Workspace: the parts of the extents along a stretch.
    parts: Vec<f64>,
}

impl Board {
    fn new(pairs: &Pairs<'_>) -> Self {
        let span = (pairs.dimension - 1) * pairs.lag;
        let stretch = STRETCH.max(8 * span).min(pairs.states);
        let stretch = stretch.next_multiple_of(64);
        let stride = pairs.states.div_ceil(64) + 1;
        let bits = vec![0; (1 + TOGETHER) * stride];
        Self {
            stride,
            upper: bits.clone(),
            lower: bits,
            stretch,
            parts: vec![0.0; stretch + span],
        }
    }

    #[inline(always)]
    fn row(&self, r: usize) -> Range<usize> {
        r * self.stride..(r + 1) * self.stride
    }

    /// Fills these rows; row `r` with the diagonal `first + r`.
    #[inline(always)]
    fn fill<S: Simd, E: Extent>(
        &mut self,
        simd: S,
        extent: E,
        asked: Asked<'_>,
        first: usize,
        rows: Range<usize>,
    ) {
        let pairs = asked.pairs;
        for start in (0..pairs.states - (first + rows.start)).step_by(self.stretch) {
            for r in rows.clone() {
                let left = (pairs.states - (first + r)).saturating_sub(start);
                let piece = Stretch {
                    offset: first + r,
                    start,
                    length: left.min(self.stretch),
                };
                if piece.length > 0 {
                    let words = self.row(r).start + start / 64..;
                    let upper = &mut self.upper[words.clone()][..piece.length.div_ceil(64)];
                    let lower = &mut self.lower[words][..piece.length.div_ceil(64)];
                    piece.fill(simd, extent, asked, &mut self.parts, [upper, lower]);
                }
            }
        }
        // What a longer diagonal has left behind.
        for r in rows {
            let used = (pairs.states - (first + r)).div_ceil(64);
            let left = self.row(r).start + used..self.row(r).end;
            self.upper[left.clone()].fill(0);
            self.lower[left].fill(0);
        }
    }
}

/// A piece of a diagonal.
struct Stretch {
    offset: usize,
    /// The first pair.
    start: usize,
    /// The number of pairs.
    length: usize,
}

impl Stretch {
    /// Fills words with the bits of the piece; those beyond its end are zero.
    #[inline(always)]
    fn fill<S: Simd, E: Extent>(
        self,
        simd: S,
        extent: E,
        Asked { pairs, limits }: Asked<'_>,
        parts: &mut [f64],
        [upper, lower]: [&mut [u64]; 2],
    ) {
        let Self {
            offset,
            start,
            length,
        } = self;
        let span = (pairs.dimension - 1) * pairs.lag;
        let here = &pairs.samples[start..][..length + span];
        let there = &pairs.samples[start + offset..][..length + span];
        differences(simd, extent, here, there, &mut parts[..length + span]);

        for (word, (upper, lower)) in upper.iter_mut().zip(lower).enumerate() {
            let at = 64 * word;
            (*upper, *lower) = (0, 0);
            for first in (0..64).step_by(GROUP * S::F64_LANES) {
                let mut extents = [simd.splat_f64s(0.0); GROUP];
                for coordinate in 0..pairs.dimension {
                    let from = at + first + coordinate * pairs.lag;
                    let (parts, _) = S::as_simd_f64s(&parts[from..][..GROUP * S::F64_LANES]);
                    for (sum, part) in extents.iter_mut().zip(parts) {
                        *sum = extent.join(simd, *sum, *part);
                    }
                }
                let (u, l) = match limits {
                    Limits::One(limit) => {
                        let bits = bits_within(simd, &extents, &[simd.splat_f64s(limit); GROUP]);
                        (bits, bits)
                    }
                    Limits::Two(u, l) => (
                        bits_within(simd, &extents, &[simd.splat_f64s(u); GROUP]),
                        bits_within(simd, &extents, &[simd.splat_f64s(l); GROUP]),
                    ),
                    Limits::Columns(limits) => {
                        let row = start + at + first;
                        let of = |column: usize| S::as_simd_f64s(&limits[column..]).0;
                        (
                            bits_within(simd, &extents, of(row + offset)),
                            bits_within(simd, &extents, of(row)),
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

/// The parts of the extents: squares or moduli of the differences.
#[inline(always)]
fn differences<S: Simd, E: Extent>(
    simd: S,
    extent: E,
    here: &[f64],
    there: &[f64],
    parts: &mut [f64],
) {
    let (here, here_rest) = S::as_simd_f64s(here);
    let (there, there_rest) = S::as_simd_f64s(there);
    let (parts, parts_rest) = S::as_mut_simd_f64s(parts);
    for ((part, &a), &b) in parts.iter_mut().zip(here).zip(there) {
        *part = extent.of_one(simd, simd.sub_f64s(a, b));
    }
    let (a, b) = (
        simd.partial_load_f64s(here_rest),
        simd.partial_load_f64s(there_rest),
    );
    simd.partial_store_f64s(parts_rest, extent.of_one(simd, simd.sub_f64s(a, b)));
}

/// A bit for every lane of the group, set where the extent is within the limit.
#[inline(always)]
fn bits_within<S: Simd>(simd: S, extents: &[S::f64s; GROUP], limits: &[S::f64s]) -> u64 {
    let mut bits = 0;
    for (v, (&extent, &limit)) in extents.iter().zip(limits).enumerate() {
        let within = simd.less_than_or_equal_f64s(extent, limit);
        bits |= lanes(simd, within) << (v * S::F64_LANES);
    }
    bits
}

/// A bit for every lane of a mask.
#[inline(always)]
fn lanes<S: Simd>(_simd: S, mask: S::m64s) -> u64 {
    match bytes_of(&mask) {
        // One bit a lane already.
        [bits] => u64::from(*bits),
        // Bytes of ones or of zeros.
        bytes => {
            let each = bytes.chunks_exact(bytes.len() / S::F64_LANES).enumerate();
            each.fold(0, |bits, (lane, mask)| {
                bits | u64::from(mask[0] & 1) << lane
            })
        }
    }
}
