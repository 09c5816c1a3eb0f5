//! What work needs of the system, asked for before it begins: threads and memory.

use super::error::CliError;

/// Address space of the threads of a run or a study, bytes: the allocator reserves 64 MB for each, and ends the
/// program where it finds no more.
const THREADS_SPACE: usize = 300_000_000;

/// Starts the threads that analyses share, unless they run: started by the first analysis, they would panic where the
/// system gives none. Called after what needs much memory at once, since each thread reserves some.
pub(super) fn start_pool() -> Result<(), CliError> {
    if !crate::memory::is_granted(THREADS_SPACE) {
        return Err(CliError::Threads {
            purpose: "the analyses",
            source: format!(
                "they need {} MB of address space, which the system refuses; raise the limit (`ulimit -v`)",
                THREADS_SPACE / 1_000_000
            )
            .into(),
        });
    }
    let pool = rayon::ThreadPoolBuilder::new().thread_name(|k| format!("analysis {k}"));
    match pool.build_global() {
        // A second call has no cause.
        Err(fault) if std::error::Error::source(&fault).is_some() => Err(CliError::Threads {
            purpose: "the analyses",
            // Its own source says the same again.
            source: fault.to_string().into(),
        }),
        _ => Ok(()),
    }
}

/// Makes sure, before any work, that there is memory for a recording.
pub(super) fn check_memory() -> Result<(), CliError> {
    crate::record::check_memory().map_err(|source| CliError::Run {
        doing: "recording",
        source: source.into(),
    })
}
