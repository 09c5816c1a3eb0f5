//! Training of cubature rules from states of joints with the same patch.

use serde::{Deserialize, Serialize};

use super::nnls::{ActiveSet, Problem};
use super::snapshots::Snapshots;
use super::{CubatureRule, KeptNode, TrainingError};
use crate::dynamics::System;
use crate::joint::Joint;

/// Factor on the equations of steady sliding, load and area in the choice of the nodes.
const STEADY: f64 = 3.0;

/// Factor by which the residual may increase for the equations that are satisfied to rounding.
const EXACT_COST: f64 = 2.0;

/// Factor on the equations of the linearised force.
const LINEARISED: f64 = 1.0;

/// Largest number of candidates. More make the weights fit the states of the training better, others hardly.
const MAX_CANDIDATES: usize = 256;

/// A case for training or for a check: a joint with states.
#[derive(Clone, Debug)]
pub struct TrainingCase {
    /// The joint with all nodes.
    pub joint: Joint,
    /// States `[q | dq/dt]`.
    pub states: Vec<Vec<f64>>,
    /// Factor on the errors of this joint.
    pub weight: f64,
}

/// Errors of a rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RuleErrors {
    /// Largest relative error of the force (minus that of steady sliding) over the states.
    pub max: f64,
    /// Root mean square of that error over the states.
    pub rms: f64,
    /// Largest relative error of the force of steady sliding over the joints.
    pub steady: f64,
}

/// A trained rule with its errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainedRule {
    /// The rule.
    pub rule: CubatureRule,
    /// Errors at the states of the training.
    pub training: RuleErrors,
    /// Errors at held-out states, which were not used in the training.
    pub held_out: RuleErrors,
}

/// Trainer of rules: the equations of the weights for some joints with the same patch.
#[derive(Clone, Debug)]
pub struct Trainer {
    cases: Vec<TrainingCase>,
    problem: Problem,
    /// Equations that the weights satisfy to rounding where that is possible: area, load and steady-sliding
    /// force of the first joint; area and load.
    exact: [Vec<f64>; 2],
    /// Nodes that may be kept.
    candidates: Vec<usize>,
    nodes: usize,
}

impl Trainer {
    /// Collects the equations of some joints. The rules reproduce area and load to rounding and, if they have
    /// enough nodes, the steady-sliding force of the first joint, unless this increases the other errors by more
    /// than a factor of two.
    ///
    /// # Errors
    /// [`TrainingError::NoStates`] without states or with a vanishing force.
    ///
    /// # Panics
    /// If the joints have different numbers of nodes.
    pub fn new(cases: &[TrainingCase]) -> Result<Self, TrainingError> {
        let Some(first) = cases.first() else {
            return Err(TrainingError::NoStates);
        };
        let nodes = first.joint.contact_nodes();
        let mut snapshots = Snapshots::new(nodes);
        let share = 1.0 / (cases.len() as f64).sqrt();
        for TrainingCase {
            joint,
            states,
            weight,
        } in cases
        {
            assert_eq!(joint.contact_nodes(), nodes, "joints with the same patch");
            snapshots.add_states(joint, states, weight * share);
            snapshots.add_linearised(joint, LINEARISED * weight * share);
            snapshots.add_steady(joint, STEADY * weight * share);
            snapshots.add_area_and_load(joint, STEADY * weight * share);
        }
        if snapshots.is_empty() {
            return Err(TrainingError::NoStates);
        }
        let candidates = candidates(nodes);
        let mut totals = Snapshots::new(nodes);
        totals.add_area_and_load(&first.joint, 1.0);
        let mut steady = totals.clone();
        steady.add_steady(&first.joint, 1.0);
        Ok(Self {
            exact: [steady.with_sums(&candidates), totals.with_sums(&candidates)],
            cases: cases.to_vec(),
            problem: snapshots.problem(&candidates),
            candidates,
            nodes,
        })
    }

    /// Number of nodes of the full patch.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Trains a rule with at most `size` nodes and evaluates its errors.
    ///
    /// # Errors
    /// If no node receives a weight.
    pub fn rule(
        &self,
        size: usize,
        held_out: &[TrainingCase],
    ) -> Result<TrainedRule, TrainingError> {
        let mut set = ActiveSet::default();
        self.problem.grow(&mut set, size, 0.0);
        self.problem.exchange(&mut set);
        let residual = self.problem.residual_norm(&set);
        let exact = self.exact.iter().find_map(|exact| {
            let exact = self.problem.with_exact(&set, exact)?;
            (self.problem.residual_norm(&exact) <= EXACT_COST * residual).then_some(exact)
        });
        let set = exact.unwrap_or(set);
        let columns = set.columns.iter().map(|&column| self.candidates[column]);
        let mut kept: Vec<_> = columns.zip(set.weights).collect();
        kept.sort_by_key(|(node, _)| *node);
        let kept = kept
            .into_iter()
            .map(|(node, weight)| KeptNode { node, weight });
        let rule = CubatureRule::new(self.nodes, kept.collect())?;
        Ok(TrainedRule {
            training: errors_of(&rule, &self.cases),
            held_out: errors_of(&rule, held_out),
            rule,
        })
    }
}

/// Nodes that may be kept: all, or about [`MAX_CANDIDATES`] evenly spaced ones of a fine patch.
fn candidates(nodes: usize) -> Vec<usize> {
    let count = nodes.min(MAX_CANDIDATES);
    (0..count).map(|k| k * nodes / count).collect()
}

/// Errors of the force of a rule over the states of some joints.
///
/// # Panics
/// If a joint has another number of nodes than the rule.
pub fn errors_of(rule: &CubatureRule, cases: &[TrainingCase]) -> RuleErrors {
    let mut weights = vec![0.0; rule.full_nodes()];
    for kept in rule.kept() {
        weights[kept.node] = kept.weight;
    }
    let (mut errors, mut count) = (RuleErrors::default(), 0.0);
    for TrainingCase { joint, states, .. } in cases {
        assert_eq!(
            joint.contact_nodes(),
            rule.full_nodes(),
            "the patch of the rule"
        );
        let mut snapshots = Snapshots::new(rule.full_nodes());
        // The scale cancels that of the average over the states.
        snapshots.add_states(joint, states, (states.len() as f64).sqrt());
        for error in snapshots.errors(&weights, joint.modes()) {
            errors.max = errors.max.max(error);
            errors.rms += error * error;
            count += 1.0;
        }
        let mut steady = Snapshots::new(rule.full_nodes());
        steady.add_steady(joint, 1.0);
        errors.steady = steady
            .errors(&weights, joint.modes())
            .fold(errors.steady, f64::max);
    }
    errors.rms = (errors.rms / f64::max(count, 1.0)).sqrt();
    errors
}
