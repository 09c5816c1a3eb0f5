//! Search for the parameters that the paper does not state.
//!
//! The search is an evolution strategy. The first generation is random over the whole parameter space. Later
//! ones are mutations of the fittest candidates, with a mutation width that decreases per generation, plus
//! some random candidates. A generation depends only on the seed and on the results of the generations before
//! it; the number of threads and interruptions do not change it.

mod space;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use super::paper::{Evidence, Finding, compare, fitness, score};
use super::pool::{Event, ResultSender, ThreadSpawnError, run_jobs};
use super::response::{InitialState, ResponsePlan, response};
use super::sweep::chain_of_causes;
use crate::joint::BallJoint;
use crate::scene::{Parameter, Scene};
pub use space::Candidate;
use space::rounded;

/// Tilts at which a candidate is simulated, degrees: those of Fig. 4 to 7, one above and one below.
pub const TILTS: [f64; 6] = [1.4, 2.0, 3.0, 3.5, 5.0, 6.5];

/// Plan of the response of a candidate: shorter than for a figure, but long enough to compare with the
/// claims.
pub const RESPONSE: ResponsePlan = ResponsePlan {
    min_transient: 0.05,
    max_transient: 0.25,
    measurement_time: 0.06,
    // Exponents would need ten times the simulated time.
    exponents: 0,
    portrait: false,
    // About fifteen times the work of a typical squeak; sticking or very stiff contacts exceed it.
    max_rhs_evals: Some(4_000_000),
};

/// Fraction of each later generation that is random over the whole space.
const RANDOM_SHARE: f64 = 0.2;

/// Number of parents: the fittest candidates so far.
const PARENTS: usize = 8;

/// Mutation width relative to a parameter's range: initial value, and its factor per generation.
const WIDTH: f64 = 0.15;
const WIDTH_FACTOR: f64 = 0.8;
/// Minimum mutation width.
const MIN_WIDTH: f64 = 0.01;

/// Plan of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationPlan {
    /// The scene with all parameters that the paper states.
    pub base: Scene,
    /// Seed of the random search.
    pub seed: u64,
    /// Number of generations.
    pub generations: usize,
    /// Number of candidates per generation.
    pub population: usize,
}

/// A trial: a candidate and its evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Number of the trial, from 0, in order of the generations.
    pub number: usize,
    /// The candidate: a parameter set.
    pub candidate: Candidate,
    /// Score: weighted share of the claims that hold, 0 to 1. ([`score`]).
    pub score: f64,
    /// Fitness by which candidates are ranked, 0 to 1 ([`fitness`]): how close the claims are to holding.
    #[serde(rename = "fitness")]
    pub fitness: f64,
    /// Claims held: the name of each claim that holds, with the share to which it holds, 0 to 1.
    #[serde(rename = "claims_held")]
    pub claims_held: Vec<(String, f64)>,
    /// Error message if the candidate could not be simulated; then no claim holds.
    pub error: Option<String>,
}

/// Observer of a calibration: it receives the trials and the progress. Its methods are called on the
/// caller's thread.
pub trait CalibrationObserver {
    /// Error of the receiver, or of starting the threads.
    type Error: From<ThreadSpawnError>;

    /// Takes a trial as soon as it is evaluated.
    ///
    /// # Errors
    /// An error ends the search.
    fn on_trial(&mut self, trial: &Trial) -> Result<(), Self::Error>;

    /// Takes the number of trials done and the best one, at least every 50 ms; returns whether to continue.
    fn on_progress(&mut self, done: usize, best: Option<&Trial>) -> bool;
}

/// Runs the search, reusing `known` trials. Returns all trials in order, and whether the search is complete.
///
/// # Errors
/// The error of the observer.
pub fn calibrate<W: CalibrationObserver>(
    plan: &CalibrationPlan,
    known: &[Trial],
    threads: usize,
    observer: &mut W,
) -> Result<(Vec<Trial>, bool), W::Error> {
    let mut trials: Vec<Trial> = Vec::new();
    for generation in 0..plan.generations {
        let candidates = plan.generation(generation, &trials);
        let first = trials.len();
        // A known trial of another candidate cannot be reused.
        let found = |k: usize| {
            let trial = known.iter().find(|trial| trial.number == first + k)?;
            (trial.candidate == candidates[k]).then(|| trial.clone())
        };
        let mut tried: Vec<Trial> = (0..candidates.len()).filter_map(found).collect();
        let missing: Vec<usize> = (0..candidates.len())
            .filter(|k| tried.iter().all(|t| t.number != first + k))
            .collect();
        let job =
            |ball: &mut Option<BallJoint>, _, place: usize, sender: &ResultSender<'_, Trial>| {
                let k = missing[place];
                let should_continue = || sender.should_continue();
                if let Some(trial) = evaluate(
                    &plan.base,
                    first + k,
                    &candidates[k],
                    ball,
                    &should_continue,
                ) {
                    sender.send(trial);
                }
            };
        run_jobs(missing.len(), threads, job, |event| {
            if let Event::Result(trial) = event {
                observer.on_trial(&trial)?;
                tried.push(trial);
            }
            let best = ranked(trials.iter().chain(&tried)).first().copied();
            Ok::<_, W::Error>(observer.on_progress(first + tried.len(), best))
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

/// Trials in descending order of fitness; among equals the earlier one comes first.
pub fn ranked<'t>(trials: impl IntoIterator<Item = &'t Trial>) -> Vec<&'t Trial> {
    let mut ranked: Vec<&Trial> = trials.into_iter().collect();
    ranked.sort_by(|a, b| {
        b.fitness
            .total_cmp(&a.fitness)
            .then(a.number.cmp(&b.number))
    });
    ranked
}

impl CalibrationPlan {
    /// Total number of trials.
    pub fn len(&self) -> usize {
        self.generations * self.population
    }

    /// Whether the plan has no trials.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The candidates of a generation, given the trials before it.
    fn generation(&self, generation: usize, before: &[Trial]) -> Vec<Candidate> {
        let ranked = ranked(before);
        let parents = &ranked[..ranked.len().min(PARENTS)];
        let random = (RANDOM_SHARE * self.population as f64).ceil() as usize;
        let width = WIDTH * WIDTH_FACTOR.powi(generation.max(1) as i32 - 1);
        let members = (0..self.population).map(|k| {
            let number = (generation * self.population + k) as u64;
            if parents.is_empty() || k < random {
                Candidate::random(self.seed, number)
            } else {
                let parent = parents[k % parents.len()];
                parent
                    .candidate
                    .mutated(width.max(MIN_WIDTH), self.seed, number)
            }
        });
        members.collect()
    }

    /// Everything that the results depend on, as text.
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

/// Evaluates a candidate; `None` if stopped.
fn evaluate(
    base: &Scene,
    number: usize,
    candidate: &Candidate,
    ball: &mut Option<BallJoint>,
    should_continue: &dyn Fn() -> bool,
) -> Option<Trial> {
    let trial = |findings: &[Finding], error| Trial {
        number,
        candidate: candidate.clone(),
        score: rounded(score(findings)),
        fitness: rounded(fitness(findings)),
        claims_held: findings
            .iter()
            .filter(|finding| finding.holds.share() > 0.0 && finding.claim.weight > 0.0)
            .map(|finding| (finding.claim.id.clone(), rounded(finding.holds.share())))
            .collect(),
        error,
    };
    match simulate(base, candidate, ball, should_continue) {
        Ok(evidence) => Some(trial(&compare(&evidence?), None)),
        Err(error) => Some(trial(&[], Some(chain_of_causes(&*error)))),
    }
}

/// The responses of a candidate at [`TILTS`]; `None` if stopped.
fn simulate(
    base: &Scene,
    candidate: &Candidate,
    ball: &mut Option<BallJoint>,
    should_continue: &dyn Fn() -> bool,
) -> Result<Option<Evidence>, Box<dyn std::error::Error>> {
    let scene = candidate.scene(base)?;
    let mut responses = Vec::new();
    let mut state: Option<Vec<f64>> = None;
    for tilt in TILTS {
        let there = scene.with_values(&[(Parameter::tilt(), tilt)])?;
        let from = match &state {
            Some(state) if candidate.continued => InitialState::State(state),
            _ => InitialState::Fresh,
        };
        let Some(found) = response(&there, from, &RESPONSE, ball, &mut |_| should_continue())?
        else {
            return Ok(None);
        };
        state = Some(found.state.clone());
        responses.push((tilt, found));
    }
    Ok(Some(Evidence::new(responses)))
}
