//! The search for the parameters that the paper does not state.
//!
//! An evolution strategy on generations: the first is spread over the whole space; each later one has
//! its members near the best so far, nearer and nearer, and some anywhere. Generations depend on
//! nothing but the seed and the results of those before, so that neither threads nor a stop in
//! between matter.

mod space;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use super::paper::{Evidence, Finding, compare, nearness, score};
use super::pool::{Event, Hand, NoThread, work};
use super::response::{From, ResponsePlan, response};
use super::sweep::chain_of_causes;
use crate::joint::BallJoint;
use crate::scene::{Parameter, Scene};
pub use space::Candidate;
use space::short;

/// Tilts at which a candidate is tried, degrees: those of Fig. 4 to 7, and one above and below.
pub const TILTS: [f64; 6] = [1.4, 2.0, 3.0, 3.5, 5.0, 6.5];

/// How a candidate's motion is followed: shorter than for a figure, long enough to tell.
pub const RESPONSE: ResponsePlan = ResponsePlan {
    least: 0.05,
    most: 0.25,
    measure: 0.06,
    // They need ten times as long to tell anything.
    exponents: 0,
    portrait: false,
    // Some fifteen times what a squeak needs: sets with sticking or very stiff contact are given up.
    most_calls: Some(4_000_000),
};

/// Share of each later generation that is anywhere in the space.
const ANYWHERE: f64 = 0.2;

/// The best so many are the parents of the next generation.
const PARENTS: usize = 8;

/// Width of a generation about its parents, of the range: the first, and how it shrinks.
const WIDTH: f64 = 0.15;
const SHRINKS: f64 = 0.8;
/// It shrinks no further.
const NARROWEST: f64 = 0.01;

/// How the search is done.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationPlan {
    /// The scene that has all that the paper does state.
    pub base: Scene,
    /// Seed of all choices.
    pub seed: u64,
    /// Generations.
    pub generations: usize,
    /// Candidates a generation.
    pub population: usize,
}

/// A candidate that has been tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Its number, from 0: generation by generation.
    pub number: usize,
    /// The set.
    pub candidate: Candidate,
    /// How well the claims hold, 0 to 1 ([`score`]).
    pub score: f64,
    /// How near they are to holding, by which candidates are compared ([`nearness`]).
    pub nearness: f64,
    /// The claims that hold, by their names, and how far.
    pub held: Vec<(String, f64)>,
    /// Why it could not be tried; then nothing holds.
    pub error: Option<String>,
}

/// Who is told of trials, on the caller's own thread.
pub trait Witness {
    /// Why it cannot go on, or that no thread can be started.
    type Error: std::convert::From<NoThread>;

    /// Takes a trial as soon as it is there.
    ///
    /// # Errors
    /// Ends the search.
    fn trial(&mut self, trial: &Trial) -> Result<(), Self::Error>;

    /// Is told how many trials are done, every now and then; whether to go on.
    fn progress(&mut self, done: usize, best: Option<&Trial>) -> bool;
}

/// Searches; trials that are `known` are not done again. All trials in their order, and whether the
/// search came to its end.
///
/// # Errors
/// What the witness says.
pub fn calibrate<W: Witness>(
    plan: &CalibrationPlan,
    known: &[Trial],
    threads: usize,
    witness: &mut W,
) -> Result<(Vec<Trial>, bool), W::Error> {
    let mut trials: Vec<Trial> = Vec::new();
    for generation in 0..plan.generations {
        let candidates = plan.generation(generation, &trials);
        let first = trials.len();
        // A trial that is known, but of another candidate, is of no use.
        let found = |k: usize| {
            let trial = known.iter().find(|trial| trial.number == first + k)?;
            (trial.candidate == candidates[k]).then(|| trial.clone())
        };
        let mut tried: Vec<Trial> = (0..candidates.len()).filter_map(found).collect();
        let missing: Vec<usize> = (0..candidates.len())
            .filter(|k| tried.iter().all(|t| t.number != first + k))
            .collect();
        let job = |ball: &mut Option<BallJoint>, _, place: usize, hand: &Hand<'_, Trial>| {
            let k = missing[place];
            let goes_on = || hand.goes_on();
            if let Some(trial) = attempt(&plan.base, first + k, &candidates[k], ball, &goes_on) {
                hand.over(trial);
            }
        };
        work(missing.len(), threads, job, |event| {
            if let Event::Result(trial) = event {
                witness.trial(&trial)?;
                tried.push(trial);
            }
            let best = ranked(trials.iter().chain(&tried)).first().copied();
            Ok::<_, W::Error>(witness.progress(first + tried.len(), best))
        })?;
        let complete = tried.len() == candidates.len();
        tried.sort_by_key(|trial| trial.number);
        trials.append(&mut tried);
        if !complete {
            return Ok((trials, false));
        }
    }
    Ok((trials, true))
}

/// Trials by how near the claims are to holding, the best first; of equals the earlier one.
pub fn ranked<'t>(trials: impl IntoIterator<Item = &'t Trial>) -> Vec<&'t Trial> {
    let mut ranked: Vec<&Trial> = trials.into_iter().collect();
    ranked.sort_by(|a, b| {
        b.nearness
            .total_cmp(&a.nearness)
            .then(a.number.cmp(&b.number))
    });
    ranked
}

impl CalibrationPlan {
    /// How many trials there are in all.
    pub fn len(&self) -> usize {
        self.generations * self.population
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The candidates of a generation after those before it.
    fn generation(&self, generation: usize, before: &[Trial]) -> Vec<Candidate> {
        let ranked = ranked(before);
        let parents = &ranked[..ranked.len().min(PARENTS)];
        let anywhere = (ANYWHERE * self.population as f64).ceil() as usize;
        let width = WIDTH * SHRINKS.powi(generation.max(1) as i32 - 1);
        let members = (0..self.population).map(|k| {
            let number = (generation * self.population + k) as u64;
            if parents.is_empty() || k < anywhere {
                Candidate::anywhere(self.seed, number)
            } else {
                let parent = parents[k % parents.len()];
                parent
                    .candidate
                    .near(width.max(NARROWEST), self.seed, number)
            }
        });
        members.collect()
    }

    /// All that the results depend on, as a text.
    pub fn identity(&self) -> String {
        format!(
            "squeakscope {} seed {} population {} at {TILTS:?} deg by {RESPONSE:?}\nscene {}\n{}\n{}",
            crate::VERSION,
            self.seed,
            self.population,
            self.base.name,
            self.base.text,
            super::paper::CLAIMS
        )
    }
}

/// Tries a candidate; `None` if it was told to stop.
fn attempt(
    base: &Scene,
    number: usize,
    candidate: &Candidate,
    ball: &mut Option<BallJoint>,
    goes_on: &dyn Fn() -> bool,
) -> Option<Trial> {
    let trial = |findings: &[Finding], error| Trial {
        number,
        candidate: candidate.clone(),
        score: short(score(findings)),
        nearness: short(nearness(findings)),
        held: findings
            .iter()
            .filter(|finding| finding.holds.share() > 0.0 && finding.claim.weight > 0.0)
            .map(|finding| (finding.claim.id.clone(), short(finding.holds.share())))
            .collect(),
        error,
    };
    match follow(base, candidate, ball, goes_on) {
        Ok(evidence) => Some(trial(&compare(&evidence?), None)),
        Err(error) => Some(trial(&[], Some(chain_of_causes(&*error)))),
    }
}

/// The responses of a candidate at [`TILTS`]; `None` if it was told to stop.
fn follow(
    base: &Scene,
    candidate: &Candidate,
    ball: &mut Option<BallJoint>,
    goes_on: &dyn Fn() -> bool,
) -> Result<Option<Evidence>, Box<dyn std::error::Error>> {
    let scene = candidate.scene(base)?;
    let mut responses = Vec::new();
    let mut state: Option<Vec<f64>> = None;
    for tilt in TILTS {
        let there = scene.with_values(&[(Parameter::tilt(), tilt)])?;
        let from = match &state {
            Some(state) if candidate.continued => From::State(state),
            _ => From::Cold,
        };
        let Some(found) = response(&there, from, &RESPONSE, ball, &mut |_| goes_on())? else {
            return Ok(None);
        };
        state = Some(found.state.clone());
        responses.push((tilt, found));
    }
    Ok(Some(Evidence::new(responses)))
}
