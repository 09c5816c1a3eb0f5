//! Instruction set of the vectorised loops.

use std::sync::OnceLock;

use pulp::Arch;

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
