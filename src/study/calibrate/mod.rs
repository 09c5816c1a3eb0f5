//! Search for the parameters that the paper does not state.
//!
//! The search has two stages. Screening evaluates the linear stability of many random parameter sets and keeps those
//! that agree best with the paper's numbers of unstable modes. These sets and some known ones are then simulated,
//! and the fittest are improved one after another by CMA-ES, an evolution strategy for noisy functions. Several
//! initial states are simulated for each set, because attractors coexist and the paper does not state its own.
//!
//! A generation depends only on the plan and on the results of the generations before it; the number of threads and
//! interruptions do not change it.

mod cma;
mod fronts;
mod screening;
mod space;
mod trial;

#[cfg(test)]
mod tests;

use nalgebra::DVector;
use rand::RngExt;

use super::paper::{Evidence, Finding, Score, Verdict, compare, fitness};
use super::pool::{Event, ResultSender, ThreadSpawnError, run_jobs};
use super::response::{InitialState, ResponsePlan, SettledResponse, response};
use crate::chain_of_causes;
use crate::joint::BallJoint;
use crate::scene::{Parameter, Scene};
use cma::Cma;
pub use fronts::{FrontPoint, MetClaims, ParetoFront, never_together, pareto_fronts, shares};
pub use screening::Screening;
use screening::screen;
pub use space::{Candidate, StartingWay};
use space::{rounded, stream};
pub use trial::{Trial, ranked};

/// Tilts at which a candidate is simulated, degrees: those of Fig. 4 to 7, one above and one below.
pub const TILTS: [f64; 6] = [1.4, 2.0, 3.0, 3.5, 5.0, 6.5];

/// Initial velocities of a candidate, mm/s: small ones, from which the vibration grows, and large ones. Each is
/// simulated with a new kick at every tilt and with upward continuation.
const KICKS_MM_PER_S: [f64; 2] = [0.01, 1.0];

/// Plan of the response of a candidate: shorter than for a figure, but long enough to compare with the
/// claims.
pub const RESPONSE: ResponsePlan = ResponsePlan {
    min_transient: 0.05,
    max_transient: 0.25,
    measurement_time: 0.06,
    // Exponents would need ten times the simulated time.
    exponents: 0,
    orbits: false,
    portrait: false,
    // About fifteen times the work of a typical squeak; sticking or very stiff contacts exceed it.
    max_rhs_evals: Some(4_000_000),
};

/// Number of generations by which each of the fittest sets is improved.
const GENERATIONS_PER_RUN: usize = 8;

/// Initial standard deviation of the improvement, relative to the ranges of the parameters.
const WIDTH: f64 = 0.04;

/// Random stream of the improvements, beyond those of the screening.
const IMPROVEMENT_STREAM: u64 = 1 << 40;

/// Plan of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationPlan {
    /// The scene with all parameters that the paper states.
    pub base: Scene,
    /// Seed of the random search.
    pub seed: u64,
    /// Number of sets whose linear stability is evaluated, at least as many as `starts`.
    pub screened: usize,
    /// Number of sets that are simulated before any is improved: known sets, and the best of the screening.
    pub starts: usize,
    /// Number of generations of the improvement.
    pub generations: usize,
    /// Number of candidates per generation, at least 4.
    pub population: usize,
    /// Plan of each response.
    pub response: ResponsePlan,
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

    /// Takes the number of screened sets, at least every 50 ms; returns whether to continue.
    fn on_screening(&mut self, done: usize) -> bool;

    /// Takes the number of trials done and the best one, at least every 50 ms; returns whether to continue.
    fn on_progress(&mut self, done: usize, best: Option<&Trial>) -> bool;
}

/// Result of a calibration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    /// Result of the screening.
    pub screening: Screening,
    /// All trials, in order.
    pub trials: Vec<Trial>,
    /// Whether the search is complete.
    pub complete: bool,
}

/// Runs the search, reusing `known` trials.
///
/// # Errors
/// The error of the observer.
pub fn calibrate<W: CalibrationObserver>(
    plan: &CalibrationPlan,
    known: &[Trial],
    threads: usize,
    observer: &mut W,
) -> Result<Calibration, W::Error> {
    let mut result = Calibration::default();
    let on_screening = |done| observer.on_screening(done);
    let screened = screen::<W::Error>(
        &plan.base,
        plan.seed,
        plan.screened,
        plan.starts,
        threads,
        on_screening,
    )?;
    let Some((screening, starts)) = screened else {
        return Ok(result);
    };
    result.screening = screening;
    for generation in 0..=plan.generations {
        let candidates = plan.generation(generation, &starts, &result.trials);
        let evaluated = evaluate_all(plan, &candidates, known, threads, observer, &result.trials)?;
        let complete = evaluated.len() == candidates.len();
        result.trials.extend(evaluated);
        if !complete {
            return Ok(result);
        }
    }
    result.complete = true;
    Ok(result)
}

/// The trials of candidates after those `before`, in order; fewer if the observer stops.
fn evaluate_all<W: CalibrationObserver>(
    plan: &CalibrationPlan,
    candidates: &[Candidate],
    known: &[Trial],
    threads: usize,
    observer: &mut W,
    before: &[Trial],
) -> Result<Vec<Trial>, W::Error> {
    let first = before.len();
    // A known trial of another candidate cannot be reused.
    let found = |k: usize| {
        let trial = known.iter().find(|trial| trial.number == first + k)?;
        (trial.candidate == candidates[k]).then(|| trial.clone())
    };
    let mut tried: Vec<Trial> = (0..candidates.len()).filter_map(found).collect();
    let missing: Vec<usize> = (0..candidates.len())
        .filter(|k| tried.iter().all(|t| t.number != first + k))
        .collect();
    let job = |ball: &mut Option<BallJoint>, _, place: usize, sender: &ResultSender<'_, Trial>| {
        let k = missing[place];
        let should_continue = || sender.should_continue();
        if let Some(trial) = evaluate(plan, first + k, &candidates[k], ball, &should_continue) {
            sender.send(trial);
        }
    };
    run_jobs(missing.len(), threads, job, |event| {
        if let Event::Result(trial) = event {
            observer.on_trial(&trial)?;
            tried.push(trial);
        }
        let best = ranked(before.iter().chain(&tried)).first().copied();
        Ok::<_, W::Error>(observer.on_progress(first + tried.len(), best))
    })?;
    tried.sort_by_key(|trial| trial.number);
    Ok(tried)
}

impl CalibrationPlan {
    /// Total number of trials.
    pub fn len(&self) -> usize {
        self.starts + self.generations * self.population
    }

    /// Whether the plan has no trials.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The candidates of a generation, given the trials before it. The first one has the starts; each of the fittest
    /// of them is then improved over [`GENERATIONS_PER_RUN`] generations.
    fn generation(
        &self,
        generation: usize,
        starts: &[Candidate],
        before: &[Trial],
    ) -> Vec<Candidate> {
        let Some(index) = generation.checked_sub(1) else {
            return starts.to_vec();
        };
        let (simulated, improved) = before.split_at(starts.len());
        let (run, step) = (index / GENERATIONS_PER_RUN, index % GENERATIONS_PER_RUN);
        let start = &ranked(simulated)[run % simulated.len()].candidate;
        let mut search = Cma::new(&start.positions, WIDTH);
        let sampled = |search: &Cma, generation: usize| {
            let mut rng = stream(self.seed, IMPROVEMENT_STREAM + generation as u64);
            (search.points(self.population, &mut rng), rng)
        };
        // The steps before are replayed.
        for earlier in index - step..index {
            let (points, _) = sampled(&search, earlier);
            let trials = &improved[earlier * self.population..][..self.population];
            let best_first = ranked(trials).into_iter();
            let best_first: Vec<DVector<f64>> = best_first
                .map(|trial| points[trial.number - trials[0].number].clone())
                .collect();
            search.update(&best_first);
        }
        let (points, mut rng) = sampled(&search, index);
        let points = points.iter();
        points
            .map(|point| start.moved(point.as_slice(), rng.random()))
            .collect()
    }

    /// Everything that the results depend on, as text.
    pub fn identity(&self) -> String {
        format!(
            "squeakscope {} seed {} screened {} starts {} population {} at {TILTS:?} deg by {:?}\nscene {}\n{}\n{}",
            crate::VERSION,
            self.seed,
            self.screened,
            self.starts,
            self.population,
            self.response,
            self.base.name,
            self.base.text,
            super::paper::CLAIMS
        )
    }
}

/// Evaluates a candidate; `None` if stopped.
fn evaluate(
    plan: &CalibrationPlan,
    number: usize,
    candidate: &Candidate,
    ball: &mut Option<BallJoint>,
    should_continue: &dyn Fn() -> bool,
) -> Option<Trial> {
    let trial = |start, findings: &[Finding], error| Trial {
        number,
        candidate: candidate.clone(),
        start,
        score: rounded(Score::of(findings).strict_score),
        fitness: rounded(fitness(findings)),
        claims_held: findings
            .iter()
            .filter(|finding| finding.verdict.share() > 0.0)
            .map(|finding| (finding.id.clone(), rounded(finding.verdict.share())))
            .collect(),
        claims_missed: findings
            .iter()
            .filter(|finding| finding.verdict == Verdict::NotMet)
            .map(|finding| finding.id.clone())
            .collect(),
        error,
    };
    let mut best: Option<Trial> = None;
    for kick_mm_per_s in KICKS_MM_PER_S {
        let start = |continued| StartingWay {
            kick_mm_per_s,
            continued,
        };
        let found = match simulate(plan, candidate, start(false), ball, should_continue) {
            Ok(found) => found?
                .into_iter()
                .map(|(start, evidence)| trial(start, &compare(&evidence), None))
                .collect(),
            Err(error) => vec![trial(start(false), &[], Some(chain_of_causes(&*error)))],
        };
        for next in found {
            if best.as_ref().is_none_or(|best| next.fitness > best.fitness) {
                best = Some(next);
            }
        }
    }
    best
}

/// Responses of a candidate for each way of starting.
type Simulated = Vec<(StartingWay, Evidence)>;

/// The responses of a candidate at [`TILTS`] after a kick, each with a new kick and with upward continuation; `None`
/// if stopped.
fn simulate(
    plan: &CalibrationPlan,
    candidate: &Candidate,
    start: StartingWay,
    ball: &mut Option<BallJoint>,
    should_continue: &dyn Fn() -> bool,
) -> Result<Option<Simulated>, Box<dyn std::error::Error>> {
    let scene = candidate.scene(&plan.base, start)?;
    let mut found = Vec::new();
    let mut first: Option<SettledResponse> = None;
    for continued in [false, true] {
        let mut responses: Vec<(f64, SettledResponse)> = Vec::new();
        for tilt in TILTS {
            // Both ways begin with the same kick.
            if let (true, Some(first)) = (responses.is_empty(), first.take()) {
                responses.push((tilt, first));
                continue;
            }
            let there = scene.with_values(&[(Parameter::tilt(), tilt)])?;
            let from = match responses.last() {
                Some((_, before)) if continued => InitialState::State(&before.state),
                _ => InitialState::Fresh,
            };
            let watch = &mut |_| should_continue();
            let Some(settled) = response(&there, from, &plan.response, ball, watch)? else {
                return Ok(None);
            };
            responses.push((tilt, settled));
        }
        first = responses.first().map(|(_, response)| response.clone());
        found.push((StartingWay { continued, ..start }, Evidence::new(responses)));
    }
    Ok(Some(found))
}
