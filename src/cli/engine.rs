//! What the commands call of the rest of the crate: the only place where the command line meets
//! the pipeline and the joint.

use super::error::Cause;
use super::model::ModelFile;
use super::report::ModeReport;
use super::run::Job;
use crate::pipeline::message::Summary;
use crate::scene::Scene;

/// Said by the commands whose engine is not connected yet.
const NOT_CONNECTED: &str = "this command is not connected to its engine yet";

/// Runs a scene down the road: simulation, analysis, recording.
pub(super) fn simulate(_job: &Job<'_>) -> Result<Summary, Cause> {
    Err(NOT_CONNECTED.into())
}

/// The modes at steady sliding at each of the tilts (rad), by frequency.
pub(super) fn stability(_scene: &Scene, _tilts: &[f64]) -> Result<Vec<Vec<ModeReport>>, Cause> {
    Err(NOT_CONNECTED.into())
}

/// The model of a scene at its start.
pub(super) fn model(_scene: &Scene) -> Result<ModelFile, Cause> {
    Err(NOT_CONNECTED.into())
}
