//! Long calls of the library: without the interpreter's lock, with progress and Ctrl-C.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::error::raise;

/// Interval at which signals are checked and progress is reported.
pub const POLL: Duration = Duration::from_millis(50);

/// Progress and stop flag of a call.
#[derive(Default)]
pub struct Watch {
    /// Set after Ctrl-C, or when the callback of the progress raises.
    pub stop: Arc<AtomicBool>,
    /// Share of the work that is done, 0 to 1, as the bits of an `f64`.
    share: AtomicU64,
}

impl Watch {
    /// Reports the share of the work that is done, and returns whether to continue.
    pub fn report(&self, share: f64) -> bool {
        self.share.store(share.to_bits(), Ordering::Relaxed);
        !self.stop.load(Ordering::Relaxed)
    }
}

/// Does work on a thread of its own. Meanwhile this thread passes the progress to a callback (if any) and
/// listens to Ctrl-C; both can end the call with their exception once the work has noticed the stop flag.
pub fn long_call<T: Send, E: Error + Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T, E> + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    let done = AtomicBool::new(false);
    let caller = thread::current();
    thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(&watch)));
            done.store(true, Ordering::Release);
            caller.unpark();
            result
        });
        let mut ended = Ok(());
        while !done.load(Ordering::Acquire) {
            py.detach(|| thread::park_timeout(POLL));
            if ended.is_ok() {
                ended = poll(py, progress, &watch);
                watch.stop.store(ended.is_err(), Ordering::Relaxed);
            }
        }
        let result = py.detach(|| worker.join());
        ended?;
        match result.and_then(|result| result) {
            Ok(result) => result.map_err(|error| raise(&error)),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Listens to Ctrl-C and reports the progress.
pub fn poll(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    py.check_signals()?;
    if let Some(progress) = progress {
        progress.call1((f64::from_bits(watch.share.load(Ordering::Relaxed)),))?;
    }
    Ok(())
}
