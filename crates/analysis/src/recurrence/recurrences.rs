//! Recurrent pairs of states, Eq. (26).

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use crate::memory::check;
use crate::simd::{lane_bits, vectorised};
use crate::{AnalysisError, DelayVectors, Norm};

/// Vectors of pairs that are compared at a time.
const GROUP: usize = 8;

/// The recurrent pairs of the states of a signal, or of those of two signals:
///
/// ```text
/// Eq. (26):  R_ij(epsilon) = Theta(epsilon - |y_i - y_j|),   Theta(0) = 1
/// ```
///
/// [`RecurrenceCounts`](super::RecurrenceCounts) defines them to the last digit. The plot is not stored.
///
/// ```
/// use squeakscope_analysis::{DelayVectors, Norm, RateBase, RecurrenceCriterion, Recurrences, Threshold};
///
/// let signal: Vec<f64> = (0..500).map(|k| (0.1 * f64::from(k)).sin()).collect();
/// let criterion = RecurrenceCriterion {
///     norm: Norm::Euclidean,
///     threshold: Threshold::Distance(0.2),
///     theiler: 1,
/// };
/// let recurrences = Recurrences::of(&DelayVectors::new(&signal, 16, 2)?, &criterion)?;
/// let measures = recurrences.counts().measures(2, 2, RateBase::Counted);
/// assert_eq!(measures.determinism, Some(1.0));
/// # Ok::<(), squeakscope_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recurrences<'a> {
    pub(super) rows: DelayVectors<'a>,
    pub(super) columns: DelayVectors<'a>,
    pub(super) norm: Norm,
    pub(super) theiler: usize,
    /// Rows and columns are the same states.
    pub(super) same: bool,
    pub(super) distance: Option<f64>,
    /// Limit of the unrooted distance for each column, and 64 unused ones.
    pub(super) limits: Vec<f64>,
}

/// A part of a row, a column or a diagonal of the plot: successive states, each with the same other state, or with
/// successive ones.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    states: DelayVectors<'a>,
    begin: usize,
    length: usize,
    others: DelayVectors<'a>,
    other: usize,
    is_diagonal: bool,
}

impl Line<'_> {
    pub fn length(self) -> usize {
        self.length
    }

    /// Appends the unrooted distances.
    pub fn unrooted(self, norm: Norm, distances: &mut Vec<f64>) {
        let from = distances.len();
        distances.resize(from + self.length, 0.0);
        vectorised(
            #[inline(always)]
            || self.unrooted_part(norm, 0, &mut distances[from..]),
        );
    }

    /// The unrooted distances from pair `from` on.
    #[inline(always)]
    fn unrooted_part(self, norm: Norm, from: usize, distances: &mut [f64]) {
        distances.fill(0.0);
        for c in 0..self.states.dimension() {
            let states = &self.states.coordinate(c)[self.begin + from..][..distances.len()];
            let others = &self.others.coordinate(c)[self.other..];
            if self.is_diagonal {
                let others = &others[from..][..distances.len()];
                norm.add(distances, states.iter().zip(others).map(|(a, b)| a - b));
            } else {
                let other = others[0];
                norm.add(distances, states.iter().map(|a| a - other));
            }
        }
    }
}

impl<'a> Recurrences<'a> {
    /// Distance within which two states are recurrent, in the signal's unit; `None` for a separate one per column
    /// ([`Threshold::Neighbours`](super::Threshold::Neighbours)).
    pub fn distance(&self) -> Option<f64> {
        self.distance
    }

    /// Whether the pairs are recurrent, row by row.
    ///
    /// # Errors
    /// [`AnalysisError::Memory`] for too many pairs.
    pub fn matrix(&self) -> Result<Vec<bool>, AnalysisError> {
        let [rows, columns] = [self.rows, self.columns].map(|states| states.len());
        check((rows as u64).saturating_mul(columns as u64)).map_err(|shortage| {
            AnalysisError::Memory {
                samples: rows + columns,
                shortage,
            }
        })?;
        let mut matrix = Vec::with_capacity(rows * columns);
        let mut distances = Vec::new();
        for i in (0..rows).take_while(|_| !self.rows.is_stopped()) {
            distances.clear();
            self.row(i).unrooted(self.norm, &mut distances);
            let pairs = distances.iter().zip(&self.limits);
            matrix.extend(pairs.map(|(distance, limit)| distance <= limit));
        }
        Ok(matrix)
    }

    /// Rows whose pairs with column `j` are at least `gap` from the line of identity, above and below it.
    pub(super) fn rows_beyond(&self, gap: usize, j: usize) -> [Range<usize>; 2] {
        let n = self.rows.len();
        if self.same && gap > 0 {
            let below = j.saturating_add(gap).min(n)..n;
            [0..(j + 1).saturating_sub(gap), below]
        } else {
            [0..n, n..n]
        }
    }

    pub(super) fn row(&self, i: usize) -> Line<'a> {
        Line {
            states: self.columns,
            begin: 0,
            length: self.columns.len(),
            others: self.rows,
            other: i,
            is_diagonal: false,
        }
    }

    pub(super) fn column(&self, j: usize, rows: Range<usize>) -> Line<'a> {
        Line {
            states: self.rows,
            begin: rows.start,
            length: rows.len(),
            others: self.columns,
            other: j,
            is_diagonal: false,
        }
    }

    /// The diagonal from row `i` and column `j` to the end of the plot.
    pub(super) fn diagonal(&self, [i, j]: [usize; 2]) -> Line<'a> {
        Line {
            states: self.rows,
            begin: i,
            length: (self.rows.len() - i).min(self.columns.len() - j),
            others: self.columns,
            other: j,
            is_diagonal: true,
        }
    }

    /// Sets a bit for each recurrent pair of a column or diagonal. The bits after the last pair are 0.
    pub(super) fn compare(&self, line: Line<'_>, bits: &mut Vec<u64>) {
        bits.clear();
        Arch::new().dispatch(Comparison {
            line,
            norm: self.norm,
            limits: &self.limits[line.other..],
            bits,
        });
    }
}

/// [`Recurrences::compare`] for one instruction set.
struct Comparison<'a> {
    line: Line<'a>,
    norm: Norm,
    limits: &'a [f64],
    bits: &'a mut Vec<u64>,
}

impl WithSimd for Comparison<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.norm {
            Norm::Euclidean => self.run(
                simd,
                #[inline(always)]
                |sum, t| simd.add_f64s(sum, simd.mul_f64s(t, t)),
            ),
            Norm::Maximum => self.run(
                simd,
                #[inline(always)]
                |most, t| simd.max_f64s(most, simd.abs_f64s(t)),
            ),
            Norm::Manhattan => self.run(
                simd,
                #[inline(always)]
                |sum, t| simd.add_f64s(sum, simd.abs_f64s(t)),
            ),
        }
    }
}

impl Comparison<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, add: impl Fn(S::f64s, S::f64s) -> S::f64s + Copy) {
        let Self { line, limits, .. } = self;
        if line.is_diagonal {
            let others = |c: usize, at: usize| {
                let others = &line.others.coordinate(c)[line.other + at..];
                let others = S::as_simd_f64s(&others[..GROUP * S::F64_LANES]).0;
                move |v: usize| others[v]
            };
            let limit = |at: usize| {
                let limits = S::as_simd_f64s(&limits[at..][..GROUP * S::F64_LANES]).0;
                move |v: usize| limits[v]
            };
            line.words(simd, self.bits, add, others, limit);
        } else {
            let others = |c: usize, _| {
                let other = simd.splat_f64s(line.others.coordinate(c)[line.other]);
                move |_| other
            };
            let limit = simd.splat_f64s(limits[0]);
            line.words(simd, self.bits, add, others, |_| move |_| limit);
        }
        // The pairs after the last whole word.
        let from = 64 * self.bits.len();
        let mut rest = [0.0; 64];
        let rest = &mut rest[..line.length - from];
        line.unrooted_part(self.norm, from, rest);
        let within = rest.iter().enumerate().map(|(n, distance)| {
            let limit = limits[if line.is_diagonal { from + n } else { 0 }];
            u64::from(*distance <= limit) << n
        });
        let word = within.fold(0, |word, bit| word | bit);
        self.bits.extend((from < line.length).then_some(word));
    }
}

impl Line<'_> {
    /// Appends the bits of 64 pairs each: coordinates of the other states and limits by position.
    #[inline(always)]
    fn words<S: Simd, O: Fn(usize) -> S::f64s, L: Fn(usize) -> S::f64s>(
        self,
        simd: S,
        bits: &mut Vec<u64>,
        add: impl Fn(S::f64s, S::f64s) -> S::f64s,
        others: impl Fn(usize, usize) -> O,
        limits: impl Fn(usize) -> L,
    ) {
        for word in 0..self.length / 64 {
            let mut within = 0;
            for first in (0..64).step_by(GROUP * S::F64_LANES) {
                let at = 64 * word + first;
                let mut sums = [simd.splat_f64s(0.0); GROUP];
                for c in 0..self.states.dimension() {
                    let states = &self.states.coordinate(c)[self.begin + at..];
                    let states = S::as_simd_f64s(&states[..GROUP * S::F64_LANES]).0;
                    let others = others(c, at);
                    for (v, (sum, state)) in sums.iter_mut().zip(states).enumerate() {
                        *sum = add(*sum, simd.sub_f64s(*state, others(v)));
                    }
                }
                let limits = limits(at);
                for (v, sum) in sums.into_iter().enumerate() {
                    let lanes = lane_bits(simd, simd.less_than_or_equal_f64s(sum, limits(v)));
                    within |= lanes << (first + v * S::F64_LANES);
                }
            }
            bits.push(within);
        }
    }
}

#[cfg(test)]
#[path = "recurrences_tests.rs"]
mod tests;
