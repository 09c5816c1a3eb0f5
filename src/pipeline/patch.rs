//! The contact patch of a run: its pictures, and the check of a reduced contact.

use std::sync::Arc;

use super::PipelineError;
use super::message::{ContactReduction, NodeState, PatchGeometry, PatchSnapshot};
use crate::dynamics::System;
use crate::joint::reduction::{ForceChecker, replacement};
use crate::joint::{BallJoint, Joint, Model};
use crate::scene::Loading;

/// Evaluations of the reduced force for each evaluation of the full force, per ratio of their numbers of nodes: the
/// checks take 2 % of the time of the reduced force.
const EVALUATIONS_PER_CHECK: f64 = 50.0;

/// Least number of evaluations of the force between two samples.
const EVALUATIONS_PER_SAMPLE: f64 = 4.0;

/// Largest number of states for a new training.
const MAX_STATES: usize = 32;

/// The full patch beside the reduced one.
#[derive(Debug)]
pub(super) struct FullPatch {
    checker: ForceChecker,
    /// Number of samples between two checks.
    every: u64,
    report: ContactReduction,
    /// Tilts (rad) and states with errors above the tolerance, for a new training.
    inaccurate: Vec<(f64, Vec<f64>)>,
}

impl FullPatch {
    /// The full patch of a joint at a tilt (rad); `None` if its contact is not reduced.
    ///
    /// # Errors
    /// If the joint cannot be assembled.
    pub fn new(ball: &BallJoint, tilt: f64) -> Result<Option<Self>, PipelineError> {
        let (Some(rule), Some(tolerance)) = (ball.reduction(), ball.spec().contact.reduction)
        else {
            return Ok(None);
        };
        let joint = Joint::new(&ball.full_model(tilt)?);
        let [nodes, kept] = [joint.contact_nodes(), rule.kept().len()];
        let evaluations = EVALUATIONS_PER_CHECK * nodes as f64 / kept as f64;
        Ok(Some(Self {
            checker: ForceChecker::new(joint),
            every: (evaluations / EVALUATIONS_PER_SAMPLE).ceil() as u64,
            report: ContactReduction::new(nodes, kept, tolerance),
            inaccurate: Vec::new(),
        }))
    }

    /// The joint with all nodes.
    pub fn joint(&self) -> &Joint {
        self.checker.full()
    }

    /// The report on a joint whose contact could not be reduced as requested; `None` for all others.
    pub fn not_reduced(ball: &BallJoint) -> Option<ContactReduction> {
        let tolerance = ball.spec().contact.reduction?;
        let nodes = ball.full_nodes();
        ball.reduction().is_none().then(|| ContactReduction {
            all_nodes_since_s: Some(0.0),
            ..ContactReduction::new(nodes, nodes, tolerance)
        })
    }

    /// Comparison of the forces so far.
    pub fn report(&self) -> &ContactReduction {
        &self.report
    }

    /// Changes the tolerance.
    #[cfg(test)]
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.report.tolerance = tolerance;
    }

    /// Replaces the model with all nodes after a change of the loading.
    pub fn set_model(&mut self, model: &Model) {
        self.checker.set_full(Joint::new(model));
    }

    /// Compares the forces at the state of a sample, at a tilt (rad), if a check is due.
    pub fn follow(&mut self, reduced: &Joint, tilt: f64, index: u64, z: &[f64]) {
        if !index.is_multiple_of(self.every) {
            return;
        }
        let check = self.checker.check(reduced, z);
        self.report.errors.add(&check);
        if check.relative_error > self.report.tolerance && self.inaccurate.len() < MAX_STATES {
            self.inaccurate
                .push((tilt, z[..2 * reduced.modes()].to_vec()));
        }
    }

    /// A joint with other nodes from a time (s) on, because the present ones were not accurate enough; `None` if no
    /// others are found.
    pub fn with_other_nodes(
        &mut self,
        ball: &BallJoint,
        loading: &Loading,
        time: f64,
    ) -> Option<BallJoint> {
        let before = ball.reduction()?.kept().len();
        let inaccurate = std::mem::take(&mut self.inaccurate);
        // At the tilts of the training and of the states, also if the rotation has moved the patch.
        let mut at_tilts = ball.clone();
        at_tilts.set_patch(None);
        let rule = replacement(&at_tilts, self.report.tolerance, inaccurate)?;
        // Nodes that are trained once more differ little if there are not more of them.
        if self.report.nodes_changed_at_s.is_some() && rule.kept().len() <= before {
            return None;
        }
        let ball = ball.clone().with_reduction(Some(Arc::new(rule))).ok()?;
        let mut full = Self::new(&ball, loading.tilt).ok()??;
        full.report.tolerance = self.report.tolerance;
        full.report.nodes_changed_at_s = Some(time);
        *self = full;
        Some(ball)
    }
}

/// The nodes of a model at a tilt (rad).
pub(super) fn patch_geometry(ball: &BallJoint, model: Model, tilt: f64) -> PatchGeometry {
    PatchGeometry {
        positions: model.positions,
        normals: model.normals,
        areas: model.areas,
        pre_stress: model.pre_stress,
        direction: ball.direction(tilt),
        radius: ball.patch_radius(),
    }
}

/// Status and forces of the nodes of a joint at a state `z`.
pub(super) fn patch_snapshot(joint: &Joint, time: f64, z: &[f64]) -> PatchSnapshot {
    let forces = joint.node_forces(z);
    let pairs = forces.normal.iter().zip(&forces.speed).enumerate();
    let states = pairs.map(|(k, (&normal, &speed))| {
        if normal <= 0.0 {
            NodeState::Separated
        } else if speed < joint.stick_speed(k) {
            NodeState::Stick
        } else {
            NodeState::Slip
        }
    });
    PatchSnapshot {
        time,
        states: states.collect(),
        normal_force: forces.normal,
        friction: forces.friction,
    }
}
