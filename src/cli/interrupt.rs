//! Ctrl-C, SIGTERM and a closed terminal.
//!
//! Before [`start_work`] (scenes are read, the joint is assembled) an interrupt ends the program at once.
//! After it, the first interrupt sets a flag: the computation stops and saves its results. A second interrupt
//! ends the program at once.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::console;
use super::error::CliError;
use crate::study::Stopped;

/// Whether a computation is running that checks the flag. The handler holds the lock while it ends the
/// program, which prevents work from starting in the meantime.
static WORKING: Mutex<bool> = Mutex::new(false);

/// Installs the handler and returns the flag that an interrupt sets during work.
///
/// # Errors
/// If the operating system refuses a handler.
pub(super) fn install_handler() -> Result<Arc<AtomicBool>, CliError> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        let working = WORKING.lock().unwrap_or_else(PoisonError::into_inner);
        if !*working {
            if std::io::stderr().is_terminal() {
                // A progress bar may occupy this line.
                eprintln!();
            }
            console::print_error(&CliError::BeforeWork);
            std::process::exit(130);
        }
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .map_err(|source| CliError::Threads("Ctrl-C", source.into()))?;
    Ok(flag)
}

/// Makes interrupts set the flag from now on; the caller must check the flag. Call this before the first file
/// is opened for writing.
pub(super) fn start_work() {
    *WORKING.lock().unwrap_or_else(PoisonError::into_inner) = true;
}

/// Starts work, and checks the flag of [`install_handler`].
pub(super) fn check(flag: &AtomicBool) -> Result<(), Stopped> {
    start_work();
    if flag.load(Ordering::Relaxed) {
        return Err(Stopped);
    }
    Ok(())
}
