//! The validated scene.

use std::sync::Arc;

use super::error::SceneError;
use super::mechanism::Mechanism;
use super::parameter::Parameter;
use super::presets::DEFAULT_SCENE;
use super::subject::{LoadedJoint, SmallSystem, SystemSpec};
use super::tables::analysis::AnalysisSpec;
use super::tables::{Integrator, RecordSpec, Start};
use crate::joint::{BallOnBeam, BodySpec, ImportedModes};

/// A validated scene, in SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name, as in `squeakscope run NAME`.
    pub name: String,
    /// One line that states the content of the scene.
    pub title: String,
    /// A few sentences (Markdown) on what to observe.
    pub about: String,
    /// The mechanism that the scene demonstrates, if it has a lesson.
    pub mechanism: Option<Mechanism>,
    /// Complete text of the scene, with all overrides.
    pub text: String,
    /// The numbers that the scene is about, with the ranges of their sliders in the units of the scene file.
    pub controls: Vec<(Parameter, [f64; 2])>,
    /// The simulated system.
    pub subject: SystemSpec,
    /// Initial state.
    pub start: Start,
    /// Simulated time, s.
    pub duration: f64,
    /// Sampling rate, Hz.
    pub sample_rate: f64,
    /// Samples in a frame.
    pub frame_samples: usize,
    /// Integrator and accuracy.
    pub integrator: Integrator,
    /// Analyses.
    pub analysis: AnalysisSpec,
    /// Contents and rates of the recording.
    pub record: RecordSpec,
}

impl Scene {
    /// Number of samples of the whole run, at least one.
    pub fn samples(&self) -> u64 {
        (self.duration * self.sample_rate).round().max(1.0) as u64
    }

    /// Returns the joint and its loading.
    ///
    /// # Errors
    /// If the scene defines a small system.
    pub fn joint(&self) -> Result<&LoadedJoint, SceneError> {
        match &self.subject {
            SystemSpec::Joint(joint) => Ok(joint),
            SystemSpec::Small(small) => Err(no_joint(&self.name, small)),
        }
    }

    /// Tilt of the load at the start, rad; `None` for a small system.
    pub fn start_tilt(&self) -> Option<f64> {
        Some(self.joint().ok()?.tilt.at(0.0))
    }

    /// Returns the joint and its loading for modification. The result is not validated.
    ///
    /// # Errors
    /// If the scene defines a small system.
    pub fn joint_mut(&mut self) -> Result<&mut LoadedJoint, SceneError> {
        match &mut self.subject {
            SystemSpec::Joint(joint) => Ok(joint),
            SystemSpec::Small(small) => Err(no_joint(&self.name, small)),
        }
    }

    /// Returns the finite-element model of ball and beam.
    ///
    /// # Errors
    /// If the scene has no joint, or imports modes and patch from a file.
    pub fn ball_on_beam(&self) -> Result<&BallOnBeam, SceneError> {
        match &self.joint()?.spec.body {
            BodySpec::BallOnBeam(body) => Ok(body),
            BodySpec::Imported(modes) => Err(SceneError::wrong_system(
                &self.name,
                "modes and contact patch of ball and beam are",
                &format!("imports them from `{}`", modes.name()),
                &format!("without body.modes, such as `{DEFAULT_SCENE}`"),
            )),
        }
    }

    /// Returns the imported modes, if the scene imports them from a file.
    pub fn imported_modes(&self) -> Option<&Arc<ImportedModes>> {
        match &self.joint().ok()?.spec.body {
            BodySpec::BallOnBeam(_) => None,
            BodySpec::Imported(modes) => Some(modes),
        }
    }
}

fn no_joint(scene: &str, small: &SmallSystem) -> SceneError {
    let defines = format!("defines {}", small.description());
    let remedy = format!("with a [load] table, such as `{DEFAULT_SCENE}`");
    SceneError::wrong_system(scene, "a ball joint is", &defines, &remedy)
}
