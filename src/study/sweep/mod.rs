//! Parameter sweeps: settled responses over one or two parameters, as in Fig. 11 of the paper.

#[cfg(feature = "table")]
mod batch;
mod plan;
#[cfg(feature = "table")]
mod result;
#[cfg(feature = "table")]
mod row;
#[cfg(feature = "table")]
mod table;
#[cfg(all(test, feature = "table"))]
mod table_tests;
mod transition;

#[cfg(test)]
pub(super) mod tests;

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Stopped;
use super::pool::{Event, ResultSender, ThreadSpawnError, run_jobs};
use super::response::{InitialState, ResponseError, ResponsePlan, SettledResponse};
use super::subject::{SceneSubject, Subject};
use crate::chain_of_causes;
use crate::joint::BallJoint;
#[cfg(feature = "table")]
pub use batch::IDENTITY;
pub use plan::{Axis, Grid, Place, Shard, Start, SweepPlan};
#[cfg(feature = "table")]
pub use result::{HysteresisEnd, NamedPoints, RegimeInterval, SweepResult};
#[cfg(feature = "table")]
pub use table::{SweepTable, TableError, TableWriter, read_table, write_table};
pub use transition::{Transition, transitions};

/// A point of a sweep and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// Place of the point: index, start and axis values.
    pub place: Place,
    /// Outcome: the response, or the error message if there is none.
    pub outcome: Result<SettledResponse, String>,
}

impl SweepPoint {
    /// The response, if there is one.
    pub fn found(&self) -> Option<&SettledResponse> {
        self.outcome.as_ref().ok()
    }

    /// Name of the regime with its doubling ([`SettledResponse::motion`]), or "no response".
    pub fn regime_name(&self) -> String {
        match &self.outcome {
            Ok(found) => found.motion(),
            Err(_) => "no response".to_owned(),
        }
    }

    /// Whether the motion still changed when it was measured.
    pub fn is_unsettled(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|found| !found.settled)
    }
}

/// Progress of a sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepProgress {
    /// Points done, including those known before.
    pub done: usize,
    /// Total number of points.
    pub all: usize,
    /// Fraction of the work done, 0 to 1.
    pub share: f64,
}

/// Observer of a sweep: it receives the points and the progress. Its methods are called on the caller's
/// thread.
pub trait SweepObserver {
    /// Error of the receiver, or of starting the threads.
    type Error: From<ThreadSpawnError>;

    /// Takes a point as soon as it is computed; points arrive in any order.
    ///
    /// # Errors
    /// An error ends the sweep.
    fn on_point(&mut self, point: SweepPoint) -> Result<(), Self::Error>;

    /// Takes the progress, at least every 50 ms.
    ///
    /// # Errors
    /// To stop the sweep.
    fn on_progress(&mut self, progress: SweepProgress) -> Result<(), Stopped>;
}

/// Computes the response at each point of a shard that is not `known` yet, on `threads` threads (at least
/// one). The results do not depend on the number of threads, on the shard or on the known points. A failed
/// run is kept as a point with its error message; the next point of its chain starts from the scene's kick.
///
/// Returns whether all points of the shard are done; `false` if the observer stopped the sweep.
///
/// # Errors
/// The error of the observer.
pub fn sweep<A: SweepObserver>(
    plan: &SweepPlan,
    shard: Shard,
    known: &[SweepPoint],
    threads: usize,
    observer: &mut A,
) -> Result<bool, A::Error> {
    let subject = SceneSubject {
        scene: plan.scene.clone(),
        parameters: plan.axes.iter().map(Axis::parameter).collect(),
    };
    let (grid, response) = (plan.grid(), &plan.response);
    sweep_subject(&subject, &grid, response, (shard, known), threads, observer)
}

/// [`sweep`] of any systems. Times of the plan are in periods of the slowest motion ([`Trial::period`](super::Trial::period)).
///
/// # Errors
/// The error of the observer.
pub fn sweep_subject<A: SweepObserver>(
    subject: &dyn Subject,
    grid: &Grid<'_>,
    plan: &ResponsePlan,
    (shard, known): (Shard, &[SweepPoint]),
    threads: usize,
    observer: &mut A,
) -> Result<bool, A::Error> {
    let chains = grid.chains(shard);
    let all: usize = chains.iter().map(Vec::len).sum();
    let known = known.iter().map(|point| (point.place.index, point));
    let known: HashMap<usize, &SweepPoint> = known.collect();
    let planned = chains.iter().flatten();
    let mut done = planned.filter(|k| known.contains_key(k)).count();
    let threads = threads.clamp(1, chains.len().max(1));
    // Fraction done of the current point of each thread, as the bits of an `f64`.
    let shares: Vec<AtomicU64> = (0..threads).map(|_| AtomicU64::new(0)).collect();
    let share = |done: usize| {
        let begun = shares
            .iter()
            .map(|share| f64::from_bits(share.load(Ordering::Relaxed)));
        (done as f64 + begun.sum::<f64>()) / all.max(1) as f64
    };
    let run = |chain: &[usize],
               ball: &mut Option<BallJoint>,
               share: &AtomicU64,
               sender: &ResultSender<'_, SweepPoint>| {
        let mut before: Option<SettledResponse> = None;
        for &index in chain {
            if let Some(known) = known.get(&index) {
                before = known.outcome.as_ref().ok().cloned();
                continue;
            }
            let place = grid.place(index);
            let from = before
                .as_ref()
                .map_or(InitialState::Fresh, InitialState::After);
            let found = subject.response(&place.values, from, plan, ball, &mut |progress| {
                let part = progress.simulated / progress.expected.max(f64::MIN_POSITIVE);
                share.store(part.to_bits(), Ordering::Relaxed);
                sender.check()
            });
            let outcome = match found {
                Err(ResponseError::Stopped(_)) => return,
                // A failed run is kept as a point.
                found => found.map_err(|error| chain_of_causes(&error)),
            };
            before = outcome.as_ref().ok().cloned();
            share.store(0, Ordering::Relaxed);
            if !sender.send(SweepPoint { place, outcome }) {
                return;
            }
        }
    };
    let job = |ball: &mut _, thread: usize, chain: usize, sender: &ResultSender<'_, _>| {
        subject.enter(&mut || run(&chains[chain], ball, &shares[thread], sender));
    };
    run_jobs(chains.len(), threads, job, |event| {
        if let Event::Result(point) = event {
            done += 1;
            observer.on_point(point)?;
        }
        let progress = SweepProgress {
            done,
            all,
            share: share(done).min(1.0),
        };
        Ok::<_, A::Error>(observer.on_progress(progress).is_ok())
    })?;
    Ok(done == all)
}
