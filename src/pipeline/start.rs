//! The simulation that a scene asks for.

use super::{PipelineError, Simulation, SmallSimulation, Source, Steerable};
use crate::scene::{Scene, SubjectSpec};

/// The simulation of what a scene runs, to be steered.
///
/// # Errors
/// As [`Simulation::new`] and [`SmallSimulation::new`].
pub fn steerable(scene: &Scene) -> Result<Box<dyn Steerable>, PipelineError> {
    Ok(match scene.subject {
        SubjectSpec::Joint(_) => Box::new(Simulation::new(scene)?),
        SubjectSpec::Small(_) => Box::new(SmallSimulation::new(scene)?),
    })
}

/// The simulation of what a scene runs.
///
/// # Errors
/// As [`steerable`].
pub fn source(scene: &Scene) -> Result<Box<dyn Source>, PipelineError> {
    Ok(steerable(scene)?)
}
