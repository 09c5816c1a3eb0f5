//! What studies vary: a scene over its keys, or systems of a caller over parameters of their own.

use crate::pipeline::{PipelineError, Prepared, prepare};
use crate::scene::{Parameter, Scene, SceneError, SystemSpec};

use super::response::section_lag;

/// Systems over parameters.
pub trait Subject: Send + Sync {
    /// The system at some values of the parameters of these names.
    ///
    /// # Errors
    /// If there is no system.
    fn trial(&self, names: &[String], values: &[f64]) -> Result<Trial, PipelineError>;

    /// Does work on a thread that calls the systems.
    fn enter(&self, work: &mut (dyn FnMut() + Send)) {
        work();
    }

    /// Displacement (m) at which the motion near a Hopf point is no longer small, from its circular frequency (rad/s) and its
    /// equilibrium.
    fn hopf_size(&self, omega: f64, state: &[f64]) -> f64;
}

/// A system that is ready to run, and what its studies need to know of it.
pub struct Trial {
    /// The system, its integrator and its initial state.
    pub prepared: Prepared,
    /// Sample rate, Hz.
    pub sample_rate: f64,
    /// Delay of the section, s.
    pub lag: f64,
    /// Maximum time step, s.
    pub max_step: f64,
    /// Period of the drive, s; `None` for an autonomous system.
    pub drive_period: Option<f64>,
    /// Period of the slowest motion, s; `None` for that of the slowest mode.
    pub period: Option<f64>,
    /// Displacement amplitude below which a motion is silent, m.
    pub silence: f64,
    /// Seed of the tangent vectors.
    pub seed: u64,
    /// The scene of the system, for its linear modes and its orbits; `None` for a system of a caller.
    pub scene: Option<Scene>,
}

/// Displacement amplitude below which a scene is silent, m. Equals the default of
/// `analysis.regime.silence_um`.
pub(super) const SILENCE: f64 = 3e-10;

impl Trial {
    /// The system of a scene.
    ///
    /// # Errors
    /// If it cannot be built.
    pub fn of_scene(scene: Scene) -> Result<Self, PipelineError> {
        Ok(Self {
            prepared: prepare(&scene)?,
            sample_rate: scene.sample_rate,
            lag: section_lag(&scene),
            max_step: scene.integrator.max_step,
            drive_period: match &scene.subject {
                SystemSpec::Small(system) => system.drive_period(),
                SystemSpec::Joint(_) => None,
            },
            period: None,
            silence: SILENCE,
            seed: scene.start.seed,
            scene: Some(scene),
        })
    }
}

/// A scene with other values of some keys, in the units of the scene file.
pub(super) fn scene_at(
    scene: &Scene,
    names: &[String],
    values: &[f64],
) -> Result<Scene, SceneError> {
    if names.is_empty() {
        return Ok(scene.clone());
    }
    let parameters = names.iter().map(|name| Parameter::named(name));
    let pairs = parameters
        .zip(values)
        .map(|(key, value)| Ok((key?, *value)));
    scene.with_values(&pairs.collect::<Result<Vec<_>, _>>()?)
}

/// A scene over some of its keys, in the units of the scene file.
impl Subject for Scene {
    fn trial(&self, names: &[String], values: &[f64]) -> Result<Trial, PipelineError> {
        Trial::of_scene(scene_at(self, names, values)?)
    }

    /// The displacement at which the sliding speed reverses, or 50 um for a system without sliding.
    fn hopf_size(&self, omega: f64, _state: &[f64]) -> f64 {
        let speed = match &self.subject {
            SystemSpec::Joint(joint) => {
                let turns = joint.spec.rotation.iter().map(|w| w * w).sum::<f64>();
                let ball = self.ball_on_beam().ok();
                ball.map(|ball| 0.5 * turns.sqrt() * ball.geometry.ball_diameter)
            }
            SystemSpec::Small(system) => system.belt_speed(),
        };
        speed.map_or(50e-6, |speed| speed / omega)
    }
}
