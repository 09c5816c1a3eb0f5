//! A run with a reduced contact: pictures of all nodes, and the check of the reduced force.

use super::PipelineError;
use super::message::ContactReduction;
use crate::joint::{BallJoint, ForceChecker, Joint, Model};
use crate::scene::Loading;

/// Evaluations of the reduced force for each evaluation of the full force, per ratio of their numbers of nodes: the
/// checks take 2 % of the time of the reduced force.
const EVALUATIONS_PER_CHECK: f64 = 50.0;

/// Least number of evaluations of the force between two samples.
const EVALUATIONS_PER_SAMPLE: f64 = 4.0;

/// The full patch beside the reduced one.
#[derive(Debug)]
pub(super) struct FullPatch {
    ball: BallJoint,
    checker: ForceChecker,
    /// Number of samples between two checks.
    every: u64,
    report: ContactReduction,
}

impl FullPatch {
    /// The full patch of a joint under a loading; `None` if its contact is not reduced.
    ///
    /// # Errors
    /// If the joint cannot be assembled.
    pub fn new(ball: &BallJoint, loading: &Loading) -> Result<Option<Self>, PipelineError> {
        let (Some(rule), Some(tolerance)) = (ball.rule(), ball.spec().contact.reduction) else {
            return Ok(None);
        };
        let all = ball.with_all_nodes();
        let joint = all.joint(loading.tilt)?;
        let [nodes, kept] = [joint.contact_nodes(), rule.kept().len()];
        let evaluations = EVALUATIONS_PER_CHECK * nodes as f64 / kept as f64;
        Ok(Some(Self {
            ball: all,
            checker: ForceChecker::new(joint),
            every: (evaluations / EVALUATIONS_PER_SAMPLE).ceil() as u64,
            report: ContactReduction::new(nodes, kept, tolerance),
        }))
    }

    /// The joint with all nodes.
    pub fn joint(&self) -> &Joint {
        self.checker.full()
    }

    /// The model with all nodes at a tilt (rad).
    ///
    /// # Errors
    /// If the joint cannot be assembled.
    pub fn model(&self, tilt: f64) -> Result<Model, PipelineError> {
        Ok(self.ball.model(tilt)?)
    }

    /// The body and patch with all nodes.
    pub fn into_ball(self) -> BallJoint {
        self.ball
    }

    /// Comparison of the forces so far.
    pub fn report(&self) -> &ContactReduction {
        &self.report
    }

    /// Rebuilds the joint under another loading, and returns its model.
    ///
    /// # Errors
    /// If the joint cannot be assembled.
    pub fn set_loading(&mut self, loading: &Loading) -> Result<Model, PipelineError> {
        self.ball.set_load(loading.load);
        self.ball.set_rotation(loading.rotation);
        let model = self.ball.model(loading.tilt)?;
        self.checker.set_full(Joint::new(&model));
        Ok(model)
    }

    /// Compares the forces at the state of a sample if a check is due.
    pub fn follow(&mut self, reduced: &Joint, index: u64, z: &[f64]) {
        if index.is_multiple_of(self.every) {
            self.report.errors.add(&self.checker.check(reduced, z));
        }
    }
}
