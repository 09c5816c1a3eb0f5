//! What a scene runs: the ball joint, or a small system.

use std::sync::Arc;

use serde::Serialize;

use super::error::SceneError;
use super::schedule::Schedule;
use super::spec::Scene;
use crate::joint::{BallOnBeam, BodySpec, JointSpec, OwnModes};
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// What is run.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a scene has one subject: its size does not matter"
)]
pub enum SubjectSpec {
    /// A ball joint under a load and a rotation that may change with time.
    Joint(TiltedJoint),
    /// A small system.
    Small(SmallSystem),
}

/// A ball joint, and what acts on it as functions of time.
#[derive(Clone, Debug, PartialEq)]
pub struct TiltedJoint {
    /// The joint, with the load and the rotation that it has at the start: whoever holds them there
    /// needs nothing else.
    pub spec: JointSpec,
    /// Tilt of the load, rad.
    pub tilt: Schedule,
    /// Load, N, where it is a function of time.
    pub load: Option<Schedule>,
    /// Rotation where it is a function of time.
    pub rotation: Option<ScaledRotation>,
}

/// A rotation about a fixed axis whose speed is a function of time.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaledRotation {
    /// The rotation vector where the factor is 1, rad/s.
    pub rad_s: [f64; 3],
    /// The factor on it, above 0.
    pub factor: Schedule,
}

/// What acts on a joint at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Tilt of the load, rad.
    pub tilt: f64,
    /// Load, N.
    pub load: f64,
    /// Rotation vector, rad/s.
    pub rotation: [f64; 3],
    /// Factor on the scene's rotation; 1 where that is constant.
    pub rotation_factor: f64,
}

/// Values of what varies in a scene, at which a study holds it that takes one state of the joint;
/// `None` for what is constant anyhow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Held {
    /// Tilt, rad.
    #[serde(rename = "tilt_rad")]
    pub tilt: Option<f64>,
    /// Load, N.
    #[serde(rename = "load_n")]
    pub load: Option<f64>,
    /// Factor on the rotation.
    pub rotation_factor: Option<f64>,
}

impl ScaledRotation {
    /// The rotation vector at time `t` (s), rad/s.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let factor = self.factor.at(t);
        self.rad_s.map(|w| factor * w)
    }
}

impl TiltedJoint {
    /// What acts on the joint at time `t` (s).
    pub fn loading(&self, t: f64) -> Loading {
        let (load, rotation) = (self.load.as_ref(), self.rotation.as_ref());
        Loading {
            tilt: self.tilt.at(t),
            load: load.map_or(self.spec.load, |load| load.at(t)),
            rotation: rotation.map_or(self.spec.rotation, |rotation| rotation.at(t)),
            rotation_factor: rotation.map_or(1.0, |rotation| rotation.factor.at(t)),
        }
    }

    /// The smallest and the largest load that is reached, N.
    pub fn load_span(&self) -> [f64; 2] {
        match &self.load {
            Some(load) => [load.min(), load.max()],
            None => [self.spec.load; 2],
        }
    }

    /// The smallest and the largest factor on the rotation that is reached.
    pub fn rotation_span(&self) -> [f64; 2] {
        match &self.rotation {
            Some(rotation) => [rotation.factor.min(), rotation.factor.max()],
            None => [1.0; 2],
        }
    }

    /// The times at which anything jumps, s, in order, each once.
    pub fn jumps(&self) -> Vec<f64> {
        let factor = self.rotation.as_ref().map(|r| &r.factor);
        let courses = [Some(&self.tilt), self.load.as_ref(), factor];
        let mut jumps: Vec<f64> = courses
            .into_iter()
            .flatten()
            .flat_map(Schedule::jumps)
            .collect();
        jumps.sort_by(f64::total_cmp);
        jumps.dedup();
        jumps
    }

    /// The first values of what varies: there a study holds it that takes one state of the joint.
    pub fn held_at_first(&self) -> Held {
        self.held_at(self.loading(0.0))
    }

    /// What varies, where it is held at a loading.
    pub fn held_at(&self, loading: Loading) -> Held {
        let load = self.load.as_ref();
        let factor = self.rotation.as_ref().map(|rotation| &rotation.factor);
        let if_varies =
            |course: Option<&Schedule>, value| course.filter(|c| c.varies()).map(|_| value);
        Held {
            tilt: if_varies(Some(&self.tilt), loading.tilt),
            load: if_varies(load, loading.load),
            rotation_factor: if_varies(factor, loading.rotation_factor),
        }
    }
}

impl Held {
    /// What is held where, such as `tilt 3 deg, load 150 N`; `None` where nothing is.
    pub fn words(&self) -> Option<String> {
        // Radians and back are good for twelve digits.
        let short = |x: f64| (1e9 * x).round() / 1e9;
        let tilt = self
            .tilt
            .map(|x| format!("tilt {} deg", short(x.to_degrees())));
        let load = self.load.map(|x| format!("load {} N", short(x)));
        let factor = self.rotation_factor;
        let rotation =
            factor.map(|x| format!("rotation {} times that of rotation.rad_s", short(x)));
        let all: Vec<String> = [tilt, load, rotation].into_iter().flatten().collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

/// A system of one mass whose motion is known well enough to test a program by. Its mass counts as
/// 1 kg, so that modal coordinate and displacement are the same number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SmallSystem {
    /// A driven oscillator with a wall that it bounces off.
    ImpactOscillator(ImpactOscillator),
    /// A mass that a belt drags along.
    MassOnBelt(MassOnBelt),
    /// Two modes of a mass that a belt drags along.
    TwoModesOnBelt(TwoModesOnBelt),
    /// A driven oscillator that meets a spring with a damper.
    DampedContact(DampedContact),
}

impl SmallSystem {
    /// What it is, in a few words: `an impact oscillator`.
    pub fn words(&self) -> &'static str {
        match self {
            Self::ImpactOscillator(_) => "an impact oscillator",
            Self::MassOnBelt(_) => "a mass on a belt",
            Self::TwoModesOnBelt(_) => "two modes on a belt",
            Self::DampedContact(_) => "an oscillator that meets a spring with a damper",
        }
    }

    /// Number of modes of its state.
    pub fn modes(&self) -> usize {
        match self {
            Self::TwoModesOnBelt(_) => 2,
            Self::ImpactOscillator(_) | Self::MassOnBelt(_) | Self::DampedContact(_) => 1,
        }
    }
}

impl SubjectSpec {
    /// Number of modes of its state.
    pub fn modes(&self) -> usize {
        match self {
            Self::Joint(joint) => joint.spec.body.modes(),
            Self::Small(small) => small.modes(),
        }
    }
}

impl Scene {
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
