//! Arguments that several commands have.

use std::ffi::OsStr;

use clap::Args as Arguments;

use super::steps::{Steps, StepsError};
use crate::scene::{DEFAULT_SCENE, Scene, SceneError};

/// The scene of a command.
#[derive(Clone, Debug, Default, Arguments)]
pub struct SceneArgs {
    /// Name of a scene, or path of a scene file [default: tilt-ramp].
    pub scene: Option<String>,
}

impl SceneArgs {
    /// Reads the scene.
    pub fn load(&self) -> Result<Scene, SceneError> {
        Scene::load(self.scene.as_deref().unwrap_or(DEFAULT_SCENE))
    }

    /// What is read, if anything is, which no output may replace.
    pub fn input(&self) -> Option<&OsStr> {
        self.scene.as_deref().map(OsStr::new)
    }
}

/// The accuracy of a command.
#[derive(Clone, Copy, Debug, Default, Arguments)]
pub struct AccuracyArgs {
    /// Take the cheapest integrator for this error of the state, such as 1e-4, as `cost` advises it.
    #[arg(long, value_name = "ERROR", value_parser = positive, allow_negative_numbers = true)]
    pub accuracy: Option<f64>,
}

impl AccuracyArgs {
    /// The scene with this accuracy.
    pub fn apply(self, scene: Scene) -> Result<Scene, SceneError> {
        changed(scene, self.accuracy, |scene, error| {
            scene.with_accuracy(error)
        })
    }
}

/// A scene with what the command line changes of it, if it does.
pub fn changed<T>(
    scene: Scene,
    value: Option<T>,
    change: impl FnOnce(Scene, T) -> Result<Scene, SceneError>,
) -> Result<Scene, SceneError> {
    match value {
        Some(value) => change(scene, value),
        None => Ok(scene),
    }
}

/// Where a viewer listens unless told otherwise.
pub const DEFAULT_URL: &str = "rerun+http://127.0.0.1:9876/proxy";

/// Takes the URL of a viewer; its form is checked here so that a slip is found before any work.
pub fn viewer_url(text: &str) -> Result<String, String> {
    let known = ["rerun+http://", "rerun+https://", "rerun://"];
    if known.iter().any(|scheme| text.starts_with(scheme)) {
        Ok(text.to_owned())
    } else {
        Err(format!("a viewer's URL looks like {DEFAULT_URL}"))
    }
}

/// Takes a number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &f64| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "write a number above 0".to_owned())
}

/// Takes tilts: one, or A:B:STEP, within the range of a tilt.
pub fn tilts(text: &str) -> Result<Steps, StepsError> {
    let steps: Steps = text.parse()?;
    match steps.values().find(|tilt| tilt.abs() > 90.0) {
        None => Ok(steps),
        Some(tilt) => Err(StepsError::TiltOutOfRange(tilt)),
    }
}
