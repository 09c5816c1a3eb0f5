//! First stage of the search: linear stability of many random parameter sets.

use serde::{Deserialize, Serialize};

use super::space::{Candidate, StartingWay, known_sets};
use crate::joint::BallJoint;
use crate::scene::Scene;
use crate::study::pool::{Event, ResultSender, ThreadSpawnError, run_jobs};
use crate::study::stability;

/// Tilts (degrees) of Fig. 4 to 7 with the numbers of unstable modes in the paper.
const COUNTS: [(f64, usize); 4] = [(2.0, 4), (3.0, 4), (3.5, 5), (5.0, 5)];

/// Sets per job.
const SETS_PER_JOB: usize = 16;

/// Result of the screening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Screening {
    /// Number of sets whose linear stability was evaluated.
    pub sets: usize,
    /// Number of sets that agree with the paper's numbers of unstable modes at 0, 1, 2, 3 and all 4 of its tilts.
    pub agreeing: [usize; COUNTS.len() + 1],
}

/// Screens random candidates. Returns the result and the candidates to start with: all known sets, and those that
/// agree with the paper at most tilts, in order of their numbers. `None` if `on_progress`, which takes the number of
/// screened sets, returns false.
pub(super) fn screen<E: From<ThreadSpawnError>>(
    base: &Scene,
    seed: u64,
    screened: usize,
    starts: usize,
    threads: usize,
    mut on_progress: impl FnMut(usize) -> bool,
) -> Result<Option<(Screening, Vec<Candidate>)>, E> {
    let sets = screened.max(starts);
    let job = |balls: &mut Balls, _, place: usize, sender: &ResultSender<'_, _>| {
        let first = place * SETS_PER_JOB;
        for number in first..sets.min(first + SETS_PER_JOB) {
            let candidate = Candidate::random(seed, number as u64);
            let agreeing = balls.agreeing(base, &candidate);
            if !sender.send((number, agreeing)) {
                return;
            }
        }
    };
    let mut found = Vec::new();
    run_jobs(sets.div_ceil(SETS_PER_JOB), threads, job, |event| {
        if let Event::Result(result) = event {
            found.push(result);
        }
        Ok::<_, E>(on_progress(found.len()))
    })?;
    if found.len() < sets {
        return Ok(None);
    }
    let mut screening = Screening {
        sets,
        ..Screening::default()
    };
    for (_, agreeing) in &found {
        screening.agreeing[*agreeing] += 1;
    }
    found.sort_by_key(|(number, agreeing)| (COUNTS.len() - agreeing, *number));
    let best = found.into_iter();
    let best = best.map(|(number, _)| Candidate::random(seed, number as u64));
    let candidates = known_sets().into_iter().chain(best);
    Ok(Some((screening, candidates.take(starts).collect())))
}

/// The latest joint of each reading of the beam's length: the modes of a body are computed once.
#[derive(Default)]
struct Balls([Option<BallJoint>; 2]);

impl Balls {
    /// Number of the paper's tilts at which a candidate has as many unstable modes as the paper states; none if the
    /// candidate is not valid.
    fn agreeing(&mut self, base: &Scene, candidate: &Candidate) -> usize {
        let start = StartingWay {
            kick_mm_per_s: 0.01,
            continued: false,
        };
        let Ok(scene) = candidate.scene(base, start) else {
            return 0;
        };
        let Ok(joint) = scene.joint() else { return 0 };
        let cached = &mut self.0[candidate.choices[1]];
        let ball = match cached.take() {
            Some(before) => before.with_spec(&joint.spec),
            None => BallJoint::new(&joint.spec),
        };
        let Ok(ball) = ball else { return 0 };
        let tilts = COUNTS.map(|(tilt, _)| f64::to_radians(tilt));
        let linear = stability(&ball, &tilts);
        *cached = Some(ball);
        let Ok(linear) = linear else { return 0 };
        let pairs = linear.iter().zip(COUNTS);
        pairs
            .filter(|(at, (_, count))| at.unstable().count() == *count)
            .count()
    }
}
