//! Linear combinations of slopes, in the widest available SIMD vectors.
//!
//! Slopes are stored in rows of whole vectors that begin at a boundary of the cache lines, so that no load crosses
//! one. [`IntegratingFactor`](super::integrating_factor::IntegratingFactor) defines the order of the components in a row.
//!
//! Sums are not fused with products: the result is the same on every machine.

use std::ops::{Deref, DerefMut};

use pulp::{Arch, Simd, WithSimd};

/// Maximum number of lanes of a vector. Outputs that are written in whole vectors have as many numbers more.
pub(super) const MAX_LANES: usize = 8;

/// Numbers that begin at a boundary of [`MAX_LANES`] numbers in memory.
#[derive(Debug)]
pub(super) struct Aligned {
    numbers: Vec<f64>,
    first: usize,
    len: usize,
}

impl Aligned {
    /// Zeros.
    pub fn zeros(len: usize) -> Self {
        let numbers = vec![0.0; len + MAX_LANES];
        let line = MAX_LANES * size_of::<f64>();
        let first = numbers.as_ptr().align_offset(line).min(MAX_LANES);
        Self {
            numbers,
            first,
            len,
        }
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        // Another allocation begins elsewhere.
        let mut copy = Self::zeros(self.len);
        copy.copy_from_slice(self);
        copy
    }
}

impl Deref for Aligned {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        &self.numbers[self.first..][..self.len]
    }
}

impl DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.first..][..self.len]
    }
}

/// Number of lanes of the vectors of a machine.
pub(super) fn lanes(arch: Arch) -> usize {
    struct Lanes;
    impl WithSimd for Lanes {
        type Output = usize;

        #[inline(always)]
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F64_LANES
        }
    }
    arch.dispatch(Lanes)
}

/// `start + h sum_j weights[j] slopes[j]`. The slopes are rows of the length of `start`; the last one may still have to be
/// written.
pub(super) struct Combination<'a> {
    pub start: &'a [f64],
    /// Length of the step, s.
    pub h: f64,
    pub slopes: &'a mut [f64],
    pub weights: &'a [f64],
}

impl Combination<'_> {
    /// `N` adjacent vectors of the row from the vector `first` on.
    #[inline(always)]
    pub fn vectors<S: Simd, const N: usize>(&self, simd: S, first: usize) -> [S::f64s; N] {
        let mut sums = [simd.splat_f64s(0.0); N];
        let mut rows = &*self.slopes;
        for &weight in self.weights {
            let (row, rest) = rows.split_at(self.start.len());
            rows = rest;
            let row = &S::as_simd_f64s(row).0[first..first + N];
            let weight = simd.splat_f64s(weight);
            for k in 0..N {
                sums[k] = simd.add_f64s(sums[k], simd.mul_f64s(weight, row[k]));
            }
        }
        let start = &S::as_simd_f64s(self.start).0[first..first + N];
        let h = simd.splat_f64s(self.h);
        for k in 0..N {
            sums[k] = simd.add_f64s(start[k], simd.mul_f64s(h, sums[k]));
        }
        sums
    }

    /// Writes the vectors of the row from `first` on to `out`.
    #[inline(always)]
    pub fn write<S: Simd>(&self, simd: S, first: usize, out: &mut [f64]) {
        let count = self.start.len() / S::F64_LANES;
        let out = S::as_mut_simd_f64s(out).0;
        let mut at = first;
        while at + 2 <= count {
            out[at - first..][..2].copy_from_slice(&self.vectors::<S, 2>(simd, at));
            at += 2;
        }
        if at < count {
            [out[at - first]] = self.vectors::<S, 1>(simd, at);
        }
    }
}
