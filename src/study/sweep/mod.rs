//! Settled responses over a range of one parameter or two: Fig. 11 of the paper, and its like.

mod plan;
#[cfg(feature = "table")]
mod result;
#[cfg(feature = "table")]
mod row;
#[cfg(feature = "table")]
mod table;

#[cfg(test)]
pub(super) mod tests;

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::pool::{Event, Hand, NoThread, work};
use super::response::{From, Response, ResponseError, response};
use crate::joint::BallJoint;
use crate::scene::SceneError;
pub use plan::{Axis, Place, Shard, Start, SweepPlan};
#[cfg(feature = "table")]
pub use result::{Stretch, SweepResult};
#[cfg(feature = "table")]
pub use table::{
    CsvWriter, IDENTITY, SweepTable, TableError, TableWriter, read_table, write_csv, write_table,
};

/// What was found at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// Where it is.
    pub place: Place,
    /// The response, or why there is none.
    pub outcome: Result<Response, String>,
}

impl SweepPoint {
    /// The kind of motion in words.
    pub fn kind(&self) -> String {
        match &self.outcome {
            Ok(found) => found.regime.to_string(),
            Err(_) => "no response".to_owned(),
        }
    }

    /// Whether the motion still changed when it was measured.
    pub fn is_unsettled(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|found| !found.settled)
    }
}

/// How far a sweep is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepProgress {
    /// Points done, those known before included.
    pub done: usize,
    /// Points in all.
    pub all: usize,
    /// Share of the work done, 0 to 1.
    pub share: f64,
}

/// Who is told of what happens, on the caller's own thread.
pub trait Audience {
    /// Why it cannot go on, or that no thread can be started.
    type Error: std::convert::From<NoThread>;

    /// Takes a point, as soon as it is there; points come in any order.
    ///
    /// # Errors
    /// Ends the sweep.
    fn point(&mut self, point: SweepPoint) -> Result<(), Self::Error>;

    /// Is told how far it is, every now and then, and answers whether to go on.
    fn progress(&mut self, progress: SweepProgress) -> bool;
}

/// Takes the response at each point of a shard that is not `known` yet, on so many `threads`
/// (at least one). The points do not depend on the threads, on the shard, or on what was known.
/// A point without a response is told as such, and the next one of its chain starts cold.
///
/// Whether all points are done: not if the audience said no.
///
/// # Errors
/// What the audience says.
pub fn sweep<A: Audience>(
    plan: &SweepPlan,
    shard: Shard,
    known: &[SweepPoint],
    threads: usize,
    audience: &mut A,
) -> Result<bool, A::Error> {
    let chains = plan.chains(shard);
    let all: usize = chains.iter().map(Vec::len).sum();
    let known: HashMap<usize, &SweepPoint> = known
        .iter()
        .map(|point| (point.place.index, point))
        .collect();
    let mut done = chains
        .iter()
        .flatten()
        .filter(|k| known.contains_key(k))
        .count();
    let threads = threads.clamp(1, chains.len().max(1));
    let shares: Vec<AtomicU64> = (0..threads).map(|_| AtomicU64::new(0)).collect();
    let share = |done: usize| {
        let begun = shares
            .iter()
            .map(|share| f64::from_bits(share.load(Ordering::Relaxed)));
        (done as f64 + begun.sum::<f64>()) / all.max(1) as f64
    };
    let job = |ball: &mut Option<BallJoint>, thread: usize, chain: usize, hand: &Hand<'_, _>| {
        let worker = Worker {
            plan,
            known: &known,
            share: &shares[thread],
            hand,
        };
        worker.run(&chains[chain], ball);
    };
    work(chains.len(), threads, job, |event| {
        if let Event::Result(point) = event {
            done += 1;
            audience.point(point)?;
        }
        Ok::<_, A::Error>(audience.progress(SweepProgress {
            done,
            all,
            share: share(done).min(1.0),
        }))
    })?;
    Ok(done == all)
}

/// One thread of a sweep.
struct Worker<'a> {
    plan: &'a SweepPlan,
    known: &'a HashMap<usize, &'a SweepPoint>,
    /// Share of the point at work that is done, the bits of a number.
    share: &'a AtomicU64,
    hand: &'a Hand<'a, SweepPoint>,
}

impl Worker<'_> {
    fn run(&self, chain: &[usize], ball: &mut Option<BallJoint>) {
        let mut before: Option<Vec<f64>> = None;
        for &index in chain {
            if let Some(known) = self.known.get(&index) {
                before = known.outcome.as_ref().ok().map(|found| found.state.clone());
                continue;
            }
            let place = self.plan.place(index);
            let found = self.respond(&place, before.as_deref(), ball);
            let outcome = match found {
                Ok(Some(found)) => Ok(found),
                Ok(None) => return,
                // Where it cannot be told, that is what is told.
                Err(error) => Err(chain_of_causes(&error)),
            };
            before = outcome.as_ref().ok().map(|found| found.state.clone());
            self.share.store(0, Ordering::Relaxed);
            if !self.hand.over(SweepPoint { place, outcome }) {
                return;
            }
        }
    }

    fn respond(
        &self,
        place: &Place,
        before: Option<&[f64]>,
        ball: &mut Option<BallJoint>,
    ) -> Result<Option<Response>, PointError> {
        let scene = self.plan.scene_at(place)?;
        let from = before.map_or(From::Cold, From::State);
        let found = response(&scene, from, &self.plan.response, ball, &mut |progress| {
            let share = progress.simulated / progress.expected.max(f64::MIN_POSITIVE);
            self.share.store(share.to_bits(), Ordering::Relaxed);
            self.hand.goes_on()
        })?;
        Ok(found)
    }
}

/// Why there is no response at a point.
#[derive(Debug, thiserror::Error)]
enum PointError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Response(#[from] ResponseError),
}

/// An error with its causes, on one line.
pub(super) fn chain_of_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    let causes: Vec<String> = causes.map(ToString::to_string).collect();
    causes.join(": ")
}
