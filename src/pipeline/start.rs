//! Builds the simulation of a scene.

use super::{ControllableSource, PipelineError, Simulation, SmallSimulation, Source};
use crate::scene::{Scene, SystemSpec};

/// Builds the simulation of a scene for an interactive run.
///
/// # Errors
/// As [`Simulation::new`] and [`SmallSimulation::new`].
pub fn controllable_source(scene: &Scene) -> Result<Box<dyn ControllableSource>, PipelineError> {
    Ok(match scene.subject {
        SystemSpec::Joint(_) => Box::new(Simulation::new(scene)?),
        SystemSpec::Small(_) => Box::new(SmallSimulation::new(scene)?),
    })
}

/// Builds the simulation of a scene.
///
/// # Errors
/// As [`controllable_source`].
pub fn source(scene: &Scene) -> Result<Box<dyn Source>, PipelineError> {
    Ok(controllable_source(scene)?)
}
