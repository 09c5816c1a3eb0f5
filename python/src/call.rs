//! Long calls of the library: without the interpreter's lock, with progress and Ctrl-C.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyBool;

use squeakscope::study::Stopped;

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
    /// With a stop flag that others have, too.
    pub fn with_stop(stop: &Arc<AtomicBool>) -> Self {
        Self {
            stop: Arc::clone(stop),
            ..Self::default()
        }
    }

    /// Sets the share of the work that is done.
    pub fn show(&self, share: f64) {
        self.share.store(share.to_bits(), Ordering::Relaxed);
    }

    /// Reports the share of the work that is done.
    ///
    /// # Errors
    /// If the caller has stopped the work.
    pub fn report(&self, share: f64) -> Result<(), Stopped> {
        self.show(share);
        if self.stop.load(Ordering::Relaxed) {
            return Err(Stopped);
        }
        Ok(())
    }
}

/// Does work on a thread of its own. Meanwhile this thread passes the progress to a callback (if any) and
/// listens to Ctrl-C; both can end the call with their exception once the work has noticed the stop flag.
pub fn long_call<T: Send, E: Error + Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T, E> + Send,
) -> PyResult<T> {
    watched_call(py, progress, &Watch::default(), work)
}

/// [`long_call`] with a watch.
pub fn watched_call<T: Send, E: Error + Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    watch: &Watch,
    work: impl FnOnce(&Watch) -> Result<T, E> + Send,
) -> PyResult<T> {
    let progress = reporter(py, progress)?;
    let done = AtomicBool::new(false);
    let caller = thread::current();
    thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(watch)));
            done.store(true, Ordering::Release);
            caller.unpark();
            result
        });
        let mut ended = Ok(());
        while !done.load(Ordering::Acquire) {
            py.detach(|| thread::park_timeout(POLL));
            if ended.is_ok() {
                ended = poll(py, progress.as_ref(), watch);
                watch.stop.fetch_or(ended.is_err(), Ordering::Relaxed);
            }
        }
        let result = py.detach(|| worker.join());
        ended?;
        match result.and_then(|result| result) {
            Ok(Ok(result)) => {
                watch.show(1.0);
                poll(py, progress.as_ref(), watch)?;
                Ok(result)
            }
            Ok(Err(error)) => Err(raise(&error)),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// The function of a progress; True is a bar.
pub fn reporter<'py>(
    py: Python<'py>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let is_bar = progress.and_then(|progress| progress.cast::<PyBool>().ok());
    match is_bar.map(|is_bar| is_bar.is_true()) {
        Some(true) => {
            let module = py.import("squeakscope._result")?;
            module.call_method0("progress_bar").map(Some)
        }
        Some(false) => Ok(None),
        None => Ok(progress.cloned()),
    }
}

/// Listens to Ctrl-C and reports the progress.
pub fn poll(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    py.check_signals()?;
    if let Some(progress) = progress {
        let share = f64::from_bits(watch.share.load(Ordering::Relaxed));
        progress.call1((share.min(1.0),))?;
    }
    Ok(())
}
