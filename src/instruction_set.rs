//! Instruction set of the vectorised loops.

use std::sync::OnceLock;

use pulp::{Arch, Simd, WithSimd};

/// The widest instruction set of this machine. If the environment variable `SQUEAKSCOPE_SIMD` is `avx2`, AVX-512 is
/// not used, so that a machine that has it also shows the speed and the results of one that does not.
pub(crate) fn instruction_set() -> Arch {
    static SET: OnceLock<Arch> = OnceLock::new();
    *SET.get_or_init(|| {
        #[cfg(target_arch = "x86_64")]
        if std::env::var_os("SQUEAKSCOPE_SIMD").is_some_and(|set| set == "avx2")
            && let Some(avx2) = pulp::x86::V3::try_new()
        {
            return Arch::V3(avx2);
        }
        Arch::new()
    })
}

/// Runs a closure that is compiled for the widest instruction set of this machine. The closure must be marked
/// `#[inline(always)]`; otherwise it may be compiled for the baseline.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnMut() -> R) -> R {
    instruction_set().dispatch(Vectorised(work))
}

/// A closure to run once.
///
/// A closure that is passed as [`FnOnce`] is called through a function of its own, which is compiled for the baseline.
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
