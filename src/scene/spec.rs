//! The validated scene.

use std::sync::Arc;

use super::error::SceneError;
use super::mechanism::Mechanism;
use super::subject::{SmallSystem, SubjectSpec, TiltedJoint};
use super::tables::analysis::AnalysisSpec;
use super::tables::{Advised, Integrator, RecordSpec, Start};
use crate::joint::{BallOnBeam, BodySpec, OwnModes};

/// A validated scene. SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name, as in `squeakscope run NAME`.
    pub name: String,
    /// One line that says what the scene shows.
    pub title: String,
    /// A few sentences (Markdown): what to look for.
    pub about: String,
    /// The mechanism that the scene shows, if it is one of those that have a lesson.
    pub mechanism: Option<Mechanism>,
    /// The scene's whole text as read, with what the command line changed at its end as comments.
    pub text: String,
    /// What is run.
    pub subject: SubjectSpec,
    /// How the run starts.
    pub start: Start,
    /// Simulated time, s.
    pub duration: f64,
    /// Samples a second, Hz.
    pub sample_rate: f64,
    /// Samples a frame.
    pub frame_samples: usize,
    /// The integrator.
    pub integrator: Integrator,
    /// The cheapest integrators for some errors, where the scene knows them.
    pub advice: Vec<Advised>,
    /// Which analyses run.
    pub analysis: AnalysisSpec,
    /// What is recorded, and how often.
    pub record: RecordSpec,
}

impl Scene {
    /// The number of samples of the whole run, at least one.
    pub fn samples(&self) -> u64 {
        (self.duration * self.sample_rate).round().max(1.0) as u64
    }

    /// The joint and what acts on it.
    ///
    /// # Errors
    /// [`SceneError::NoJoint`] when the scene runs a small system.
    pub fn joint(&self) -> Result<&TiltedJoint, SceneError> {
        match &self.subject {
            SubjectSpec::Joint(joint) => Ok(joint),
            SubjectSpec::Small(small) => Err(no_joint(&self.name, small)),
        }
    }

    /// The joint and what acts on it, to be changed. Nothing checks the result.
    ///
    /// # Errors
    /// [`SceneError::NoJoint`] when the scene runs a small system.
    pub fn joint_mut(&mut self) -> Result<&mut TiltedJoint, SceneError> {
        match &mut self.subject {
            SubjectSpec::Joint(joint) => Ok(joint),
            SubjectSpec::Small(small) => Err(no_joint(&self.name, small)),
        }
    }

    /// Ball and beam, whose mesh and contact patch are made here.
    ///
    /// # Errors
    /// When the scene has no joint, or takes modes and patch from a file.
    pub fn ball_on_beam(&self) -> Result<&BallOnBeam, SceneError> {
        match &self.joint()?.spec.body {
            BodySpec::BallOnBeam(body) => Ok(body),
            BodySpec::Own(modes) => Err(SceneError::NoBeam {
                scene: self.name.clone(),
                file: modes.name().to_owned(),
            }),
        }
    }

    /// [`Scene::ball_on_beam`], to be changed. Nothing checks the result.
    ///
    /// # Errors
    /// As [`Scene::ball_on_beam`].
    pub fn ball_on_beam_mut(&mut self) -> Result<&mut BallOnBeam, SceneError> {
        self.ball_on_beam()?;
        match &mut self.joint_mut()?.spec.body {
            BodySpec::BallOnBeam(body) => Ok(body),
            BodySpec::Own(_) => unreachable!("refused above"),
        }
    }

    /// The modes from a file, if the scene takes them from one.
    pub fn own_modes(&self) -> Option<&Arc<OwnModes>> {
        match &self.joint().ok()?.spec.body {
            BodySpec::BallOnBeam(_) => None,
            BodySpec::Own(modes) => Some(modes),
        }
    }
}

fn no_joint(scene: &str, small: &SmallSystem) -> SceneError {
    SceneError::NoJoint {
        scene: scene.to_owned(),
        subject: small.words(),
    }
}
