//! The rule that a joint requests by `contact.reduction`.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::selection::{TrainingPlan, reduce, shipped_rules_of, train};
use super::{CubatureRule, TrainingError};
use crate::joint::{AssemblyError, BallJoint, BodySpec, JointSpec};

/// Tilts between which the rule of a joint is trained, rad.
const TILTS: [f64; 2] = [0.0, 8.0 * std::f64::consts::PI / 180.0];

/// Number of rules that are remembered.
const REMEMBERED: usize = 64;

/// A joint with the rule that was found for it; `None` for all nodes.
type Remembered = (JointSpec, Option<Arc<CubatureRule>>);

/// The rule for `contact.reduction` of a joint; `None` if all nodes are requested, or no rule is accurate enough.
/// It depends on the parameters of the joint only. Friction with states is not reduced. The latest rules are remembered, because studies build the
/// same joint for each of their points.
///
/// # Errors
/// If the joint cannot be built or simulated for the choice of the rule.
fn requested_rule(ball: &BallJoint) -> Result<Option<Arc<CubatureRule>>, TrainingError> {
    static RULES: Mutex<VecDeque<Remembered>> = Mutex::new(VecDeque::new());
    let spec = ball.spec();
    let Some(tolerance) = spec
        .contact
        .reduction
        .filter(|_| spec.friction.states() == 0)
    else {
        return Ok(None);
    };
    // A panic while the lock is held leaves a valid list.
    let remembered = || RULES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, rule)) = remembered().iter().find(|(of, _)| of == spec) {
        return Ok(rule.clone());
    }
    let [first, last] = tilts(ball);
    let rule = match reduce(ball, &TrainingPlan::new(tolerance, first, last)) {
        Ok((trained, _)) => Some(Arc::new(trained.rule)),
        Err(TrainingError::Tolerance { .. }) => None,
        Err(error) => return Err(error),
    };
    let mut remembered = remembered();
    if remembered.len() == REMEMBERED {
        remembered.pop_front();
    }
    remembered.push_back((spec.clone(), rule.clone()));
    Ok(rule)
}

/// First and last tilt of the training of a joint, rad.
fn tilts(ball: &BallJoint) -> [f64; 2] {
    match &ball.spec().body {
        BodySpec::BallOnBeam(_) => TILTS,
        BodySpec::Imported(modes) => [modes.tilt(); 2],
    }
}

/// A rule for a joint whose present one is not accurate enough at some states (`[q | dq/dt]` at a tilt in rad): the next
/// larger shipped rule, or for a patch without shipped rules one that is trained with these states besides those of
/// the joint's own simulations. `None` if there is none.
pub fn replacement(
    ball: &BallJoint,
    tolerance: f64,
    inaccurate: Vec<(f64, Vec<f64>)>,
) -> Option<CubatureRule> {
    let shipped = shipped_rules_of(ball);
    if shipped.is_empty() {
        let [first, last] = tilts(ball);
        let plan = TrainingPlan {
            additional: inaccurate,
            ..TrainingPlan::new(tolerance, first, last)
        };
        return train(ball, &plan).ok().map(|trained| trained.rule);
    }
    let kept = ball.reduction().map_or(0, |rule| rule.kept().len());
    let mut rules = shipped.into_iter().map(|shipped| shipped.rule);
    rules.find(|rule| rule.kept().len() > kept)
}

impl BallJoint {
    /// Computes the modes, the quadrature points of the patch, and the rule for `contact.reduction`; all nodes are
    /// evaluated if no rule is accurate enough.
    ///
    /// # Errors
    /// If the modes cannot be computed, the published frequencies are selected and one is missing, or the joint
    /// cannot be simulated for the choice of the rule.
    pub fn new(spec: &JointSpec) -> Result<Self, AssemblyError> {
        Self::with_all_nodes(spec)?.with_requested_rule()
    }

    /// Changes the parameters. The modes are computed again only if the body changes.
    ///
    /// # Errors
    /// As [`BallJoint::new`].
    pub fn with_spec(self, spec: &JointSpec) -> Result<Self, AssemblyError> {
        self.with_all_nodes_of(spec)?.with_requested_rule()
    }

    fn with_requested_rule(self) -> Result<Self, AssemblyError> {
        let failed = |error: TrainingError| AssemblyError::Reduction(Box::new(error));
        let rule = requested_rule(&self).map_err(failed)?;
        self.with_reduction(rule)
            .map_err(|error| failed(error.into()))
    }
}
