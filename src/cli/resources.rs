//! Threads and memory, checked before work starts.

use super::error::CliError;

/// Address space for the threads of a run or a study, bytes. The allocator reserves 64 MB per thread and
/// aborts the program if it cannot.
const THREADS_SPACE: usize = 300_000_000;

/// Starts the shared thread pool of the analyses, unless it runs. An analysis that started the pool itself
/// would panic if the system refused a thread. Call this after large allocations, because each thread
/// reserves memory.
pub(super) fn start_thread_pool() -> Result<(), CliError> {
    if !crate::memory::can_reserve(THREADS_SPACE) {
        let shortage = format!(
            "they need {} MB of address space, which the system does not grant; raise the limit (`ulimit -v`)",
            THREADS_SPACE / 1_000_000
        );
        return Err(CliError::Threads("the analyses", shortage.into()));
    }
    let pool = rayon::ThreadPoolBuilder::new().thread_name(|k| format!("analysis {k}"));
    match pool.build_global() {
        // The error of a second call has no source.
        Err(fault) if std::error::Error::source(&fault).is_some() => {
            // The source of `fault` repeats its message.
            Err(CliError::Threads("the analyses", fault.to_string().into()))
        }
        _ => Ok(()),
    }
}

/// Checks that there is enough memory for a recording.
pub(super) fn check_memory() -> Result<(), CliError> {
    crate::record::check_memory().map_err(CliError::during("recording"))
}
