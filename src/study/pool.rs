//! Independent jobs on several threads, their results told one by one on the caller's own; a job in
//! another process.

use std::io;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::process::Child;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{RecvTimeoutError, Sender, bounded};

/// The number of threads asked for, or as many as there are cores.
pub fn threads(asked: Option<NonZero<usize>>) -> usize {
    let cores = || thread::available_parallelism().ok();
    asked.or_else(cores).map_or(1, NonZero::get)
}

/// How often the caller is asked whether to go on.
const TICK: Duration = Duration::from_millis(50);

/// Waits for another process, and ends it where `goes_on` says no.
///
/// # Errors
/// What the system says.
pub fn wait_for(process: &mut Child, goes_on: &mut dyn FnMut() -> bool) -> io::Result<()> {
    while process.try_wait()?.is_none() {
        if !goes_on() {
            process.kill()?;
        }
        thread::sleep(TICK);
    }
    Ok(())
}

/// Says when the caller is to be asked: by the clock, since what is done between two questions may take
/// microseconds or seconds.
#[derive(Debug, Default)]
pub(super) struct Heed {
    last: Option<Instant>,
}

impl Heed {
    /// Whether the last time was a while ago, or there was none.
    pub fn is_due(&mut self) -> bool {
        let due = self.last.is_none_or(|last| last.elapsed() >= TICK);
        if due {
            self.last = Some(Instant::now());
        }
        due
    }
}

/// Not one thread can be started.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no thread can be started ({0}); raise the limit of processes (ulimit -u) or free some memory"
)]
pub struct NoThread(String);

/// What the caller is told.
pub(super) enum Event<R> {
    /// A result; they come in any order.
    Result(R),
    /// Nothing but that some time has passed.
    Tick,
}

/// Where a thread hands its results over, and learns whether to go on.
pub(super) struct Hand<'a, R> {
    sender: &'a Sender<R>,
    stop: &'a AtomicBool,
}

impl<R> Hand<'_, R> {
    /// Hands a result over; whether to go on.
    pub fn over(&self, result: R) -> bool {
        self.sender.send(result).is_ok() && self.goes_on()
    }

    /// Whether to go on.
    pub fn goes_on(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }
}

/// Does the jobs in their order, on so many threads (at least one), or fewer if the system gives no more. A job takes what its thread keeps
/// from one job to the next, at first its default; the job's place; and where it hands its results
/// over. `tell` answers whether to go on, and is asked every now and then.
///
/// Whether it always said so.
///
/// # Errors
/// What `tell` says; no job is begun after that. [`NoThread`].
pub(super) fn work<K: Default, R: Send, E: From<NoThread>>(
    jobs: usize,
    threads: usize,
    job: impl Fn(&mut K, usize, usize, &Hand<'_, R>) + Sync,
    mut tell: impl FnMut(Event<R>) -> Result<bool, E>,
) -> Result<bool, E> {
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    thread::scope(|scope| {
        let (sender, receiver) = bounded(threads.max(1));
        let mut workers = Vec::new();
        for thread in 0..threads.clamp(1, jobs.max(1)) {
            let (sender, next, stop, job) = (sender.clone(), &next, &stop, &job);
            let worker = move || {
                let _watch = StopOnPanic(stop);
                let hand = Hand {
                    sender: &sender,
                    stop,
                };
                let mut kept = K::default();
                while hand.goes_on() {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= jobs {
                        break;
                    }
                    job(&mut kept, thread, place, &hand);
                }
            };
            let named = thread::Builder::new().name(format!("study {thread}"));
            match named.spawn_scoped(scope, worker) {
                Ok(worker) => workers.push(worker),
                // The results do not depend on how many there are.
                Err(fault) if workers.is_empty() => return Err(NoThread(fault.to_string()).into()),
                Err(_) => break,
            }
        }
        drop(sender);
        let mut outcome = Ok(true);
        loop {
            let event = match receiver.recv_timeout(TICK) {
                Ok(result) => Event::Result(result),
                Err(RecvTimeoutError::Timeout) => Event::Tick,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            // After an error there is nobody to tell.
            if let Ok(goes_on) = &mut outcome {
                match tell(event) {
                    Ok(yes) => *goes_on &= yes,
                    Err(error) => outcome = Err(error),
                }
            }
            if !matches!(outcome, Ok(true)) {
                stop.store(true, Ordering::Relaxed);
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

/// Stops all threads when its own panics: what they would do meanwhile is in vain.
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

    /// Why an audience has had enough.
    #[derive(Debug, PartialEq)]
    struct Fault(&'static str);

    impl From<NoThread> for Fault {
        fn from(_: NoThread) -> Self {
            Self("no thread")
        }
    }

    #[test]
    fn every_job_is_done_once() {
        for threads in [0, 1, 3, 50] {
            let mut results = Vec::new();
            let job = |kept: &mut usize, _, place: usize, hand: &Hand<'_, usize>| {
                *kept += 1;
                hand.over(place);
            };
            let done = work(20, threads, job, |event| {
                if let Event::Result(result) = event {
                    results.push(result);
                }
                Ok::<bool, Fault>(true)
            });
            results.sort_unstable();
            assert_eq!((done, results), (Ok(true), (0..20).collect()));
        }
        let none = work(
            0,
            2,
            |(): &mut (), _, _, _: &Hand<'_, ()>| (),
            |_| Ok::<bool, Fault>(true),
        );
        assert_eq!(none, Ok(true));
    }

    #[test]
    fn it_stops_when_told_to_and_when_it_fails() {
        let job = |(): &mut (), _, place: usize, hand: &Hand<'_, usize>| {
            while !hand.over(place) && hand.goes_on() {}
        };
        let mut told = 0;
        let stopped = work(1000, 2, job, |_| {
            told += 1;
            Ok::<bool, Fault>(told < 5)
        });
        assert_eq!(stopped, Ok(false));
        assert!(told < 20, "{told}");
        let failed = work(1000, 2, job, |_| Err::<bool, Fault>(Fault("full")));
        assert_eq!(failed, Err(Fault("full")));
    }

    #[test]
    #[should_panic(expected = "the third")]
    fn a_panic_in_a_job_is_the_callers() {
        let job = |(): &mut (), _, place: usize, _: &Hand<'_, ()>| {
            assert!(place != 2, "the third");
        };
        let _ = work(5, 2, job, |_| Ok::<bool, Fault>(true));
    }

    #[test]
    fn a_panic_in_a_job_stops_the_others() {
        let begun = AtomicUsize::new(0);
        let job = |(): &mut (), _, place: usize, _: &Hand<'_, ()>| {
            begun.fetch_add(1, Ordering::Relaxed);
            assert!(place != 2, "the third");
            thread::sleep(Duration::from_millis(5));
        };
        let all = AssertUnwindSafe(|| work(1000, 2, job, |_| Ok::<bool, Fault>(true)));
        assert!(catch_unwind(all).is_err());
        assert!(begun.into_inner() < 100);
    }
}
