//! Recurrent pairs of states, Eq. (26).

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use crate::memory::check;
use crate::simd::{lane_bits, vectorised};
use crate::{AnalysisError, delay::DelayVectors, norm::Norm};

/// Pairs of a diagonal that are compared at a time, a multiple of 64. Their terms stay in the L1 cache.
const CHUNK: usize = 2048;
/// Vectors of pairs whose distances are combined at a time, enough to hide the latency of an addition.
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
/// use squeakscope_analysis::{delay::DelayVectors, recurrence::{Norm, RateBase, RecurrenceCriterion, Recurrences, Threshold}};
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

/// Unrooted distances of the vectors in a range from another vector.
pub(super) fn distances(
    norm: Norm,
    vectors: &DelayVectors<'_>,
    range: Range<usize>,
    mut other: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let mut distances = vec![0.0; range.len()];
    vectorised(
        #[inline(always)]
        || {
            for (c, other) in other.by_ref().enumerate() {
                let coordinates = &vectors.coordinate(c)[range.clone()];
                norm.add(&mut distances, coordinates.iter().map(|x| x - other));
            }
        },
    );
    distances
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
        for i in (0..rows).take_while(|_| !self.rows.is_stopped()) {
            let row = distances(self.norm, &self.columns, 0..columns, self.rows.vector(i));
            let pairs = row.iter().zip(&self.limits);
            matrix.extend(pairs.map(|(distance, limit)| distance <= limit));
        }
        Ok(matrix)
    }

    /// Sets a bit for each recurrent pair of the diagonal that starts at row `i` and column `j`. The bits after the last
    /// pair are 0.
    pub(super) fn compare(&self, [i, j]: [usize; 2], bits: &mut [u64]) {
        let (rows, columns, dimension) = (&self.rows, &self.columns, self.rows.dimension());
        let length = (rows.len() - i).min(columns.len() - j);
        for start in (0..length).step_by(CHUNK) {
            let length = CHUNK.min(length - start);
            // Along a diagonal the terms of a coordinate are those of the one before it, a lag later.
            let (series, terms, stride) = if rows.lag() == columns.lag() && rows.lag() < length {
                let lag = rows.lag();
                (1, DelayVectors::samples_for(length, lag, dimension), lag)
            } else {
                (dimension, length, length)
            };
            let mut comparison = Comparison {
                norm: self.norm,
                terms: vec![0.0; (dimension - 1) * stride + length.next_multiple_of(64)],
                stride,
                dimension,
                limits: &self.limits[j + start..],
                bits: &mut bits[start / 64..][..length.div_ceil(64)],
            };
            vectorised(
                #[inline(always)]
                || {
                    for c in 0..series {
                        let row = &rows.samples()[i + start + c * rows.lag()..][..terms];
                        let column = &columns.samples()[j + start + c * columns.lag()..];
                        let differences = row.iter().zip(column).map(|(a, b)| a - b);
                        self.norm
                            .add(&mut comparison.terms[c * stride..][..terms], differences);
                    }
                },
            );
            Arch::new().dispatch(comparison);
            let unused = length.next_multiple_of(64) - length;
            bits[(start + length - 1) / 64] &= u64::MAX >> unused;
        }
    }
}

/// Comparison of unrooted distances with their limits. The distance of pair `n` is combined from the terms at `n`,
/// `n + stride`, `n + 2 stride` and so on.
struct Comparison<'a> {
    norm: Norm,
    terms: Vec<f64>,
    stride: usize,
    dimension: usize,
    limits: &'a [f64],
    bits: &'a mut [u64],
}

impl WithSimd for Comparison<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.norm {
            Norm::Maximum => self.run(
                simd,
                #[inline(always)]
                |a, b| simd.max_f64s(a, b),
            ),
            Norm::Euclidean | Norm::Manhattan => self.run(
                simd,
                #[inline(always)]
                |a, b| simd.add_f64s(a, b),
            ),
        }
    }
}

impl Comparison<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, combine: impl Fn(S::f64s, S::f64s) -> S::f64s) {
        for (word, bits) in self.bits.iter_mut().enumerate() {
            *bits = 0;
            for first in (0..64).step_by(GROUP * S::F64_LANES) {
                let at = 64 * word + first;
                let mut distances = [simd.splat_f64s(0.0); GROUP];
                for c in 0..self.dimension {
                    let terms = &self.terms[at + c * self.stride..][..GROUP * S::F64_LANES];
                    for (distance, term) in distances.iter_mut().zip(S::as_simd_f64s(terms).0) {
                        *distance = combine(*distance, *term);
                    }
                }
                let limits = S::as_simd_f64s(&self.limits[at..][..GROUP * S::F64_LANES]).0;
                for (v, (distance, limit)) in distances.iter().zip(limits).enumerate() {
                    let within = simd.less_than_or_equal_f64s(*distance, *limit);
                    *bits |= lane_bits(simd, within) << (first + v * S::F64_LANES);
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "recurrences_tests.rs"]
mod tests;
