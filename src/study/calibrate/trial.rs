//! Trials of a search.

use serde::{Deserialize, Serialize};

use super::space::{Candidate, StartingWay};

/// A trial: a candidate and its evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Number of the trial, from 0, in order of the generations.
    pub number: usize,
    /// The candidate: a parameter set.
    pub candidate: Candidate,
    /// The way of starting with the highest fitness, to which the following values belong.
    pub start: StartingWay,
    /// Strict score (`Score`): share of the comparable claims that are met, by weight, 0 to 1.
    pub score: f64,
    /// Fitness by which candidates are ranked, 0 to 1 (`fitness`): how close the claims are to holding.
    pub fitness: f64,
    /// Claims held: the name of each claim that is met or partly met, with the share to which it holds, 0 to 1.
    pub claims_held: Vec<(String, f64)>,
    /// Claims missed: the name of each claim that can be compared but does not hold at any tilt.
    pub claims_missed: Vec<String>,
    /// Error message if the candidate could not be simulated; then no claim holds.
    pub error: Option<String>,
}

impl Trial {
    /// Whether the trial meets a claim at all of its tilts.
    pub fn meets(&self, claim: &str) -> bool {
        let mut held = self.claims_held.iter();
        held.any(|(id, share)| id == claim && *share >= 1.0)
    }
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
