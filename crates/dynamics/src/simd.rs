//! Vectorised loops.

use pulp::{Arch, Simd, WithSimd};

/// Runs a closure that is compiled for the widest instruction set of this machine. The closure must be marked
/// `#[inline(always)]`; otherwise it may be compiled for the baseline.
#[inline(always)]
pub fn vectorised<R>(work: impl FnMut() -> R) -> R {
    Arch::new().dispatch(Vectorised(work))
}

/// A closure to run once. `pulp` would run it as an [`FnOnce`], through a function of its own that is compiled for
/// the baseline.
struct Vectorised<F>(F);

impl<R, F: FnMut() -> R> WithSimd for Vectorised<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> R {
        (self.0)()
    }
}
