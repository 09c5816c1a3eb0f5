//! What a scene runs: the ball joint, or a small system.

use std::sync::Arc;

use super::error::SceneError;
use super::schedule::Schedule;
use super::spec::Scene;
use crate::joint::{BallOnBeam, BodySpec, JointSpec, OwnModes};
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt};

/// What is run.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a scene has one subject: its size does not matter"
)]
pub enum SubjectSpec {
    /// A ball joint under a load that may tilt.
    Joint(TiltedJoint),
    /// A small system.
    Small(SmallSystem),
}

/// A ball joint and the tilt of its load.
#[derive(Clone, Debug, PartialEq)]
pub struct TiltedJoint {
    /// The joint.
    pub spec: JointSpec,
    /// Tilt of the load, rad, as a function of time.
    pub tilt: Schedule,
}

/// A system of one mass whose motion is known well enough to test a program by. Its mass counts as
/// 1 kg, so that modal coordinate and displacement are the same number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SmallSystem {
    /// A driven oscillator with a wall that it bounces off.
    ImpactOscillator(ImpactOscillator),
    /// A mass that a belt drags along.
    MassOnBelt(MassOnBelt),
    /// A driven oscillator that meets a spring with a damper.
    DampedContact(DampedContact),
}

impl SmallSystem {
    /// What it is, in a few words: `an impact oscillator`.
    pub fn words(&self) -> &'static str {
        match self {
            Self::ImpactOscillator(_) => "an impact oscillator",
            Self::MassOnBelt(_) => "a mass on a belt",
            Self::DampedContact(_) => "an oscillator that meets a spring with a damper",
        }
    }
}

impl SubjectSpec {
    /// Number of modes of its state.
    pub fn modes(&self) -> usize {
        match self {
            Self::Joint(joint) => joint.spec.body.modes(),
            Self::Small(_) => 1,
        }
    }
}

impl Scene {
    /// The joint and its tilt.
    ///
    /// # Errors
    /// [`SceneError::NoJoint`] when the scene runs a small system.
    pub fn joint(&self) -> Result<&TiltedJoint, SceneError> {
        match &self.subject {
            SubjectSpec::Joint(joint) => Ok(joint),
            SubjectSpec::Small(small) => Err(no_joint(&self.name, small)),
        }
    }

    /// The joint and its tilt, to be changed. Nothing checks the result.
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
