//! What the trials of a search show about claims that exclude each other.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use super::trial::Trial;
use crate::study::paper::{Claim, Subject, claims};

/// Pareto front of two subjects: the trials for which no other one meets more of the claims on one subject and as
/// many on the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParetoFront {
    /// The two subjects of claims.
    pub subjects: [Subject; 2],
    /// The best trials in ascending order of the first share.
    pub best: Vec<FrontPoint>,
}

/// A trial on a Pareto front.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrontPoint {
    /// Number of the trial.
    pub trial: usize,
    /// Shares of the simulated claims on the two subjects that are met, by weight, 0 to 1.
    pub shares: [f64; 2],
}

/// The claims that some trial of a search meets, and their weights by subject.
pub struct MetClaims {
    claims: Vec<Claim>,
    totals: HashMap<Subject, f64>,
}

impl MetClaims {
    /// The claims that some of the trials meets.
    pub fn of(trials: &[Trial]) -> Self {
        let held = |claim: &Claim| trials.iter().any(|trial| trial.meets(&claim.id));
        let claims: Vec<Claim> = claims().into_iter().filter(held).collect();
        let mut totals = HashMap::new();
        for claim in &claims {
            *totals.entry(claim.subject()).or_insert(0.0) += claim.weight;
        }
        Self { claims, totals }
    }

    fn share(&self, trial: &Trial, subject: Subject) -> f64 {
        let of_subject = self.claims.iter().filter(|c| c.subject() == subject);
        let met = of_subject.filter(|claim| trial.meets(&claim.id));
        let total = self.totals.get(&subject).copied().unwrap_or(0.0);
        met.map(|claim| claim.weight).sum::<f64>() / total.max(f64::MIN_POSITIVE)
    }
}

/// Shares of the known claims on two subjects that each trial meets, by weight.
pub fn shares(known: &MetClaims, trials: &[Trial], subjects: [Subject; 2]) -> Vec<[f64; 2]> {
    let of = |trial| subjects.map(|subject| known.share(trial, subject));
    trials.iter().map(of).collect()
}

/// The Pareto fronts of all pairs of subjects.
pub fn pareto_fronts(known: &MetClaims, trials: &[Trial]) -> Vec<ParetoFront> {
    Subject::PAIRS
        .map(|subjects| ParetoFront {
            subjects,
            best: front(&shares(known, trials, subjects)),
        })
        .into()
}

/// The points that no other one exceeds.
fn front(shares: &[[f64; 2]]) -> Vec<FrontPoint> {
    let mut points: Vec<FrontPoint> = shares
        .iter()
        .enumerate()
        .map(|(trial, &shares)| FrontPoint { trial, shares })
        .collect();
    // By the first share in descending order; of equal ones, the largest second share first.
    points.sort_by(|a, b| {
        let [a0, a1] = a.shares;
        let [b0, b1] = b.shares;
        b0.total_cmp(&a0)
            .then(b1.total_cmp(&a1))
            .then(a.trial.cmp(&b.trial))
    });
    let mut highest = f64::NEG_INFINITY;
    points.retain(|point| {
        let is_best = point.shares[1] > highest;
        highest = highest.max(point.shares[1]);
        is_best
    });
    points.reverse();
    points
}

/// Pairs of known claims that no trial meets together.
pub fn never_together(known: &MetClaims, trials: &[Trial]) -> Vec<[String; 2]> {
    let mut pairs = Vec::new();
    for (k, first) in known.claims.iter().enumerate() {
        for second in &known.claims[k + 1..] {
            let both = |trial: &Trial| trial.meets(&first.id) && trial.meets(&second.id);
            if !trials.iter().any(both) {
                pairs.push([first.id.clone(), second.id.clone()]);
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_has_the_points_that_no_other_exceeds() {
        let shares = [
            [0.1, 0.9],
            [0.5, 0.5],
            [0.5, 0.7],
            [0.4, 0.6],
            [0.8, 0.2],
            [0.8, 0.2],
            [0.05, 0.9],
        ];
        let found: Vec<usize> = front(&shares).iter().map(|point| point.trial).collect();
        assert_eq!(found, [0, 2, 4]);
    }
}
