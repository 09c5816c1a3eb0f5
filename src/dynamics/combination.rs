//! Linear combinations of slopes, in the widest available SIMD vectors.
//!
//! A kernel writes to other arrays than it reads. The last vector of an array may therefore overlap its
//! predecessor, which avoids partial vectors; only arrays shorter than one vector need them.
//!
//! Sums are not fused with products: the result is the same on every machine.

use std::ops::Range;

use pulp::{Simd, WithSimd};

/// `start + h sum_j weights[j] slopes[j]`. The slopes are rows of the length of the state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Combination<'a> {
    pub start: &'a [f64],
    /// Length of the step, s.
    pub h: f64,
    pub slopes: &'a [f64],
    pub weights: &'a [f64],
}

impl Combination<'_> {
    /// The vector at a position within a range of the components.
    #[inline(always)]
    pub fn vector<S: Simd>(&self, simd: S, components: Range<usize>, at: usize) -> S::f64s {
        let rows = self.slopes.chunks_exact(self.start.len());
        let mut sum = simd.splat_f64s(0.0);
        for (slope, &weight) in rows.zip(self.weights) {
            let slope = load(simd, &slope[components.clone()], at);
            sum = simd.add_f64s(sum, simd.mul_f64s(simd.splat_f64s(weight), slope));
        }
        let start = load(simd, &self.start[components], at);
        simd.add_f64s(start, simd.mul_f64s(simd.splat_f64s(self.h), sum))
    }

    /// Writes a range of the components to the same range of `out`.
    #[inline(always)]
    pub fn write<S: Simd>(&self, simd: S, components: Range<usize>, out: &mut [f64]) {
        for at in positions::<S>(components.len()) {
            let sum = self.vector(simd, components.clone(), at);
            store(simd, &mut out[components.clone()], at, sum);
        }
    }
}

/// The kernel that writes all components of a combination to `out`.
pub(super) struct Write<'a> {
    pub combination: Combination<'a>,
    pub out: &'a mut [f64],
}

impl WithSimd for Write<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.combination.write(simd, 0..self.out.len(), self.out);
    }
}

/// Positions of the vectors that cover `count` numbers.
#[inline(always)]
pub(super) fn positions<S: Simd>(count: usize) -> impl Iterator<Item = usize> {
    let last = count.saturating_sub(S::F64_LANES);
    (0..count).step_by(S::F64_LANES).map(move |at| at.min(last))
}

/// Loads the vector at a position.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, numbers: &[f64], at: usize) -> S::f64s {
    match numbers.get(at..at + S::F64_LANES) {
        Some(whole) => S::as_simd_f64s(whole).0[0],
        None => simd.partial_load_f64s(numbers),
    }
}

/// Stores the vector at a position.
#[inline(always)]
pub(super) fn store<S: Simd>(simd: S, numbers: &mut [f64], at: usize, vector: S::f64s) {
    match numbers.get_mut(at..at + S::F64_LANES) {
        Some(whole) => S::as_mut_simd_f64s(whole).0[0] = vector,
        None => simd.partial_store_f64s(numbers, vector),
    }
}
