//! Ctrl-C, SIGTERM and a closed terminal.
//!
//! As long as nothing has been begun that could be kept (files are read, the joint is made), the first one
//! ends the program at once. From [`work_begins`] on it asks the work to end, and to keep what it has; asked
//! again, it ends the program at once.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::error::CliError;
use super::report;

/// Whether there is work that ends by itself when asked to. Locked while the program is being ended, so that
/// no work begins meanwhile.
static AT_WORK: Mutex<bool> = Mutex::new(false);

/// Catches Ctrl-C and its like from now on; the flag turns true when it comes while there is work.
///
/// # Errors
/// When the operating system refuses a handler.
pub(super) fn catch() -> Result<Arc<AtomicBool>, CliError> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        let at_work = AT_WORK.lock().unwrap_or_else(PoisonError::into_inner);
        if !*at_work {
            if std::io::stderr().is_terminal() {
                // There may be a bar on this line.
                eprintln!();
            }
            report::print_error(&CliError::BeforeWork);
            std::process::exit(130);
        }
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .map_err(|source| CliError::Threads {
        purpose: "Ctrl-C",
        source: source.into(),
    })?;
    Ok(flag)
}

/// From now on there may be something to keep, and whoever calls this looks at the flag. To be called before
/// the first file is opened for writing.
pub(super) fn work_begins() {
    *AT_WORK.lock().unwrap_or_else(PoisonError::into_inner) = true;
}

/// Whether work is to go on by a flag of [`catch`]; asked for the first time, it has begun.
pub(super) fn goes_on(flag: &AtomicBool) -> bool {
    work_begins();
    !flag.load(Ordering::Relaxed)
}
