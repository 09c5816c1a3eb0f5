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

use super::pool::{Event, ResultSender, run_jobs};
use super::response::{InitialState, ResponsePlan, SettledResponse};
use super::subject::{SceneSubject, Subject};
use super::{OnProgress, StudyError};
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

/// Computes the response at each point of a shard that is not `known` yet, on `threads` threads (at least
/// one). The results do not depend on the number of threads, on the shard or on the known points. A failed
/// run is kept as a point with its error message; the next point of its chain starts from the scene's kick.
///
/// `on_point` takes each point as soon as it is computed, on the thread of the caller; they arrive in any order.
///
/// # Errors
/// [`StudyError::Stopped`] and [`StudyError::Threads`]; the error of `on_point`, which ends the sweep.
pub fn sweep<E: From<StudyError>>(
    plan: &SweepPlan,
    shard: Shard,
    known: &[SweepPoint],
    threads: usize,
    progress: OnProgress<'_>,
    on_point: impl FnMut(SweepPoint) -> Result<(), E>,
) -> Result<(), E> {
    let subject = SceneSubject {
        scene: plan.scene.clone(),
        parameters: plan.axes.iter().map(Axis::parameter).collect(),
    };
    let (grid, response) = (plan.grid(), &plan.response);
    let work = (shard, known, threads);
    sweep_subject(&subject, &grid, response, work, progress, on_point)
}

/// [`sweep`] of any systems. Times of the plan are in periods of the slowest motion ([`Trial::period`](super::Trial::period)).
///
/// # Errors
/// As [`sweep`].
pub fn sweep_subject<E: From<StudyError>>(
    subject: &dyn Subject,
    grid: &Grid<'_>,
    plan: &ResponsePlan,
    (shard, known, threads): (Shard, &[SweepPoint], usize),
    progress: OnProgress<'_>,
    mut on_point: impl FnMut(SweepPoint) -> Result<(), E>,
) -> Result<(), E> {
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
            let found = subject.response(&place.values, from, plan, ball, &mut |part, _| {
                share.store(part.to_bits(), Ordering::Relaxed);
                sender.check()
            });
            let outcome = match found {
                Err(StudyError::Stopped(_)) => return,
                // A failed run is kept as a point.
                found => found.map_err(|error| chain_of_causes(&error)),
            };
            before = outcome.as_ref().ok().cloned();
            share.store(0, Ordering::Relaxed);
            if sender.send(SweepPoint { place, outcome }).is_err() {
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
            on_point(point)?;
        }
        let task = format!("{done} of {all} points");
        Ok(progress(share(done).min(1.0), &task).map_err(StudyError::from)?)
    })
}
