//! Ctrl-C, SIGTERM and a closed terminal: each asks the run to end at the next frame; asked again, ends
//! the program at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::error::CliError;

/// Catches Ctrl-C and its like from now on; the flag turns true when it comes.
///
/// # Errors
/// When the operating system refuses a handler.
pub(super) fn catch() -> Result<Arc<AtomicBool>, CliError> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .map_err(|source| CliError::Run {
        doing: "set-up of Ctrl-C",
        source: source.into(),
    })?;
    Ok(flag)
}
