//! Choice of a cubature rule for a joint: a shipped one if it is accurate enough, else one that is trained.

use serde::{Deserialize, Serialize};

use super::training::{TrainedRule, Trainer, TrainingCase, errors_of};
use super::{Excitation, TrainingError, shipped_rules};
use crate::joint::{BallJoint, BodySpec, Joint, LANES};

/// Largest number of kept nodes.
const MAX_KEPT: usize = 96;

/// Largest number of nodes in the simulations for training.
const SIMULATED_NODES: usize = 100;

/// A chosen rule has at most this share of the tolerance at the held-out states: they are a sample of the motion, and
/// the error over a whole run is larger or smaller by up to a factor of two.
const MARGIN: f64 = 0.5;

/// Parameters of [`reduce`] and [`train`].
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingPlan {
    /// Largest permitted rms of the relative error of the force in a run. At the held-out states half of it is
    /// permitted, because they are a sample of the motion.
    pub tolerance: f64,
    /// Tilts for training, rad.
    pub tilts: Vec<f64>,
    /// Tilts of the held-out states, rad.
    pub held_out_tilts: Vec<f64>,
    /// Simulations at each tilt. The held-out states have the next seed.
    pub excitation: Excitation,
    /// Additional states for training, for example those at which a rule was not accurate enough, with
    /// their tilts (rad).
    pub additional: Vec<(f64, Vec<f64>)>,
}

impl TrainingPlan {
    /// A plan for tilts from `first` to `last` (rad): training at both and at the centre, held-out states in
    /// between; or training and held-out states at a single tilt.
    pub fn new(tolerance: f64, first: f64, last: f64) -> Self {
        let at = |share: f64| first + share * (last - first);
        let (tilts, held_out_tilts) = match first == last {
            true => (vec![first], vec![first]),
            false => (vec![first, at(0.5), last], vec![at(0.25), at(0.75)]),
        };
        Self {
            tolerance,
            tilts,
            held_out_tilts,
            excitation: Excitation::default(),
            additional: Vec::new(),
        }
    }
}

/// Origin of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RuleSource {
    /// Shipped with the program.
    Shipped,
    /// Trained for the joint.
    Trained,
}

/// Returns the smallest shipped rule that is accurate enough for a joint, or else trains one ([`train`]). The
/// held-out errors are those of this joint.
///
/// # Errors
/// As [`train`].
pub fn reduce(
    ball: &BallJoint,
    plan: &TrainingPlan,
) -> Result<(TrainedRule, RuleSource), TrainingError> {
    let held_out = held_out_cases(ball, plan)?;
    for mut shipped in shipped_rules_of(ball) {
        shipped.held_out = errors_of(&shipped.rule, &held_out);
        if shipped.held_out.rms <= MARGIN * plan.tolerance {
            return Ok((shipped, RuleSource::Shipped));
        }
    }
    let trained = smallest_rule(&training_cases(ball, plan)?, &held_out, plan.tolerance)?;
    Ok((trained, RuleSource::Trained))
}

/// The shipped rules for the patch of a joint.
pub(super) fn shipped_rules_of(ball: &BallJoint) -> Vec<TrainedRule> {
    match &ball.spec().body {
        BodySpec::BallOnBeam(_) => shipped_rules(&ball.spec().contact),
        BodySpec::Imported(_) => Vec::new(),
    }
}

/// Trains the smallest rule whose rms error at held-out states is within half of the tolerance. Its number of nodes is,
/// where possible, a multiple of eight, the length of a vector.
///
/// The result depends on the arguments only.
///
/// # Errors
/// [`TrainingError::Tolerance`] if no rule with at most 96 nodes, and with at most half of all nodes, is
/// accurate enough. Otherwise if the joint cannot be built or simulated.
pub fn train(ball: &BallJoint, plan: &TrainingPlan) -> Result<TrainedRule, TrainingError> {
    let held_out = held_out_cases(ball, plan)?;
    smallest_rule(&training_cases(ball, plan)?, &held_out, plan.tolerance)
}

fn smallest_rule(
    cases: &[TrainingCase],
    held_out: &[TrainingCase],
    tolerance: f64,
) -> Result<TrainedRule, TrainingError> {
    let trainer = Trainer::new(cases)?;
    let limit = MAX_KEPT.min(trainer.nodes() / 2);
    let tolerance = MARGIN * tolerance;
    let mut smallest = f64::INFINITY;
    for size in (LANES..=limit).step_by(LANES) {
        let trained = trainer.rule(size, held_out)?;
        if trained.held_out.rms <= tolerance {
            return Ok(trained);
        }
        smallest = smallest.min(trained.held_out.rms);
    }
    Err(TrainingError::Tolerance {
        kept: limit,
        nodes: trainer.nodes(),
        tolerance,
        error: smallest,
    })
}

fn training_cases(
    ball: &BallJoint,
    plan: &TrainingPlan,
) -> Result<Vec<TrainingCase>, TrainingError> {
    let mut cases = cases_at(ball, &plan.tilts, &plan.excitation)?;
    for (tilt, z) in &plan.additional {
        let joint = Joint::new(&ball.full_model(*tilt)?);
        let states = vec![z.clone()];
        // One state among those of all simulations.
        let share = cases.first().map_or(1, |case| case.states.len());
        let weight = 1.0 / (share as f64).sqrt();
        cases.push(TrainingCase {
            joint,
            states,
            weight,
        });
    }
    Ok(cases)
}

fn held_out_cases(
    ball: &BallJoint,
    plan: &TrainingPlan,
) -> Result<Vec<TrainingCase>, TrainingError> {
    let excitation = Excitation {
        seed: plan.excitation.seed + 1,
        ..plan.excitation.clone()
    };
    cases_at(ball, &plan.held_out_tilts, &excitation)
}

/// Joints at some tilts with states of their simulations.
fn cases_at(
    ball: &BallJoint,
    tilts: &[f64],
    excitation: &Excitation,
) -> Result<Vec<TrainingCase>, TrainingError> {
    let cases = tilts.iter().map(|&tilt| {
        let joint = Joint::new(&ball.full_model(tilt)?);
        // The motion of a coarse patch is near enough, and a fine one costs much more.
        let states = match ball.coarse_model(SIMULATED_NODES, tilt)? {
            Some(coarse) => excitation.states_of(&Joint::new(&coarse))?,
            None => excitation.states_of(&joint)?,
        };
        let weight = 1.0;
        Ok(TrainingCase {
            joint,
            states,
            weight,
        })
    });
    cases.collect()
}
