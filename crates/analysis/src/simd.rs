//! Vectorised loops.

use pulp::{Arch, Simd, WithSimd};

/// Runs a closure that is compiled for the widest instruction set of this machine. The closure must be marked
/// `#[inline(always)]`; otherwise it may be compiled for the baseline.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnMut() -> R) -> R {
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

/// One bit per lane of a mask.
#[inline(always)]
pub(crate) fn lane_bits<S: Simd>(_simd: S, mask: S::m64s) -> u64 {
    match pulp::bytemuck::bytes_of(&mask) {
        // The mask already has one bit per lane.
        [bits] => u64::from(*bits),
        // The mask has bytes of ones or zeros.
        bytes => {
            let each = bytes.chunks_exact(bytes.len() / S::F64_LANES).enumerate();
            each.fold(0, |bits, (lane, mask)| {
                bits | u64::from(mask[0] & 1) << lane
            })
        }
    }
}
