//! A pool of threads for independent jobs, with results delivered one by one on the caller's thread.

use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use crossbeam_channel::{RecvTimeoutError, bounded};

use super::{Stopped, StudyError};

/// Number of threads: as requested, or the number of cores.
pub fn threads(asked: Option<NonZero<usize>>) -> usize {
    let cores = || thread::available_parallelism().ok();
    asked.or_else(cores).map_or(1, NonZero::get)
}

/// Interval between progress calls.
const TICK: Duration = Duration::from_millis(50);

/// Passes on a result of a job, if there is one. It stops the job with an error.
pub(super) type Emit<'a, R> = &'a mut (dyn FnMut(Option<R>) -> Result<(), Stopped> + Send);

/// Runs the jobs in order on `threads` threads (at least one), or on fewer if the system cannot start more.
///
/// A job receives its index and the callback for its results. `on_event` is called with each result, in any order, and with
/// `None` after an interval without one.
///
/// # Errors
/// The error of `on_event`, after which no job is started. [`StudyError::Threads`].
pub(super) fn run_jobs<R: Send, E: From<StudyError>>(
    jobs: usize,
    threads: usize,
    job: impl Fn(usize, Emit<'_, R>) + Sync,
    mut on_event: impl FnMut(Option<R>) -> Result<(), E>,
) -> Result<(), E> {
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    thread::scope(|scope| {
        let (sender, receiver) = bounded(threads.max(1));
        let mut workers = Vec::new();
        for thread in 0..threads.clamp(1, jobs.max(1)) {
            let (sender, next, stop, job) = (sender.clone(), &next, &stop, &job);
            let worker = move || {
                let _watch = StopOnPanic(stop);
                let mut emit = |result: Option<R>| {
                    let sent = result.is_none_or(|result| sender.send(result).is_ok());
                    if sent && !stop.load(Ordering::Relaxed) {
                        Ok(())
                    } else {
                        Err(Stopped)
                    }
                };
                while emit(None).is_ok() {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= jobs {
                        break;
                    }
                    job(place, &mut emit);
                }
            };
            let named = thread::Builder::new().name(format!("study {thread}"));
            match named.spawn_scoped(scope, worker) {
                Ok(worker) => workers.push(worker),
                // The results do not depend on the number of threads.
                Err(fault) if workers.is_empty() => {
                    return Err(StudyError::Threads(fault.to_string()).into());
                }
                Err(_) => break,
            }
        }
        drop(sender);
        let mut outcome = Ok(());
        loop {
            let event = match receiver.recv_timeout(TICK) {
                Ok(result) => Some(result),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            // After an error, remaining events are dropped.
            if outcome.is_ok() {
                outcome = on_event(event);
                stop.fetch_or(outcome.is_err(), Ordering::Relaxed);
            }
        }
        for worker in workers {
            if let Err(panic) = worker.join() {
                resume_unwind(panic);
            }
        }
        outcome
    })
}

/// Stops all threads if its own thread panics, since their results would be discarded.
struct StopOnPanic<'a>(&'a AtomicBool);

impl Drop for StopOnPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use super::*;

    /// An error of the caller.
    #[derive(Debug, PartialEq)]
    struct Fault(&'static str);

    impl From<StudyError> for Fault {
        fn from(_: StudyError) -> Self {
            Self("no thread")
        }
    }

    #[test]
    fn every_job_runs_once() {
        for threads in [0, 1, 3, 50] {
            let mut results = Vec::new();
            let job = |place: usize, emit: Emit<'_, usize>| {
                let _ = emit(Some(place));
            };
            let done = run_jobs(20, threads, job, |event| {
                if let Some(result) = event {
                    results.push(result);
                }
                Ok::<_, Fault>(())
            });
            results.sort_unstable();
            assert_eq!((done, results), (Ok(()), (0..20).collect()));
        }
        let none = run_jobs(0, 2, |_, _: Emit<'_, ()>| (), |_| Ok::<_, Fault>(()));
        assert_eq!(none, Ok(()));
    }

    #[test]
    fn the_pool_stops_on_request_and_on_an_error() {
        let job = |place: usize, emit: Emit<'_, usize>| {
            let _ = emit(Some(place));
        };
        let mut events = 0;
        let stopped = run_jobs(1000, 2, job, |_| {
            events += 1;
            if events < 5 {
                Ok(())
            } else {
                Err(Fault("stopped"))
            }
        });
        assert_eq!(stopped, Err(Fault("stopped")));
        assert!(events < 20, "{events}");
        let failed = run_jobs(1000, 2, job, |_| Err(Fault("full")));
        assert_eq!(failed, Err(Fault("full")));
    }

    #[test]
    #[should_panic(expected = "the third")]
    fn a_panic_in_a_job_is_propagated_to_the_caller() {
        let job = |place: usize, _: Emit<'_, ()>| {
            assert!(place != 2, "the third");
        };
        let _ = run_jobs(5, 2, job, |_| Ok::<_, Fault>(()));
    }

    #[test]
    fn a_panic_in_a_job_stops_the_others() {
        let begun = AtomicUsize::new(0);
        let job = |place: usize, _: Emit<'_, ()>| {
            begun.fetch_add(1, Ordering::Relaxed);
            assert!(place != 2, "the third");
            thread::sleep(Duration::from_millis(5));
        };
        let all = AssertUnwindSafe(|| run_jobs(1000, 2, job, |_| Ok::<_, Fault>(())));
        assert!(catch_unwind(all).is_err());
        assert!(begun.into_inner() < 100);
    }
}
