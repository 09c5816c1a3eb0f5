//! Arguments that several commands share.

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::Args as Arguments;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use strum::VariantArray;

use super::steps::Steps;
use crate::record::Output;
use crate::scene::{AnalysisBudget, DEFAULT_SCENE, Parameter, Scene, SceneError};
use crate::sound::{Quantity, Source};

/// The scene of a command.
#[derive(Clone, Debug, Default, Arguments)]
pub struct SceneArgs {
    /// Name of a scene, or path of a scene file [default: tilt-ramp].
    #[arg(help_heading = None::<&str>)]
    pub scene: Option<String>,
    /// Change this key of the scene, as in `--set load.tilt_deg=4`; repeat the option for several. The value is that of
    /// a scene file, and `absent` removes the key, or a table, as in `--set analysis.lyapunov=absent`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_and_value, help_heading = None::<&str>)]
    pub set: Vec<(String, String)>,
}

impl SceneArgs {
    /// Reads the scene and changes its keys.
    pub fn load(&self) -> Result<Scene, SceneError> {
        self.load_or(DEFAULT_SCENE)
    }

    /// As [`SceneArgs::load`], with another default scene.
    pub fn load_or(&self, default: &str) -> Result<Scene, SceneError> {
        let scene = Scene::load(self.scene.as_deref().unwrap_or(default))?;
        if self.set.is_empty() {
            Ok(scene)
        } else {
            scene.with_overrides(&self.set)
        }
    }

    /// Reads the scene and applies the accuracy and the values of other options. `numbers` are keys with values in their
    /// units; `None` keeps the value of the scene.
    pub fn load_with(
        &self,
        accuracy: AccuracyArgs,
        numbers: &[(&str, Option<f64>)],
    ) -> Result<Scene, SceneError> {
        let mut scene = accuracy.apply(self.load()?)?;
        for (key, value) in numbers {
            let Some(value) = *value else { continue };
            let parameter = Parameter::named(key)?;
            scene = if parameter == Parameter::tilt() {
                scene.with_tilt(value)?
            } else {
                scene.with_values(&[(parameter, value)])?
            };
        }
        Ok(scene)
    }

    /// The scene as given. If it is a file, no output may replace it.
    pub fn input(&self) -> Option<&OsStr> {
        self.scene.as_deref().map(OsStr::new)
    }
}

/// The accuracy of a command.
#[derive(Clone, Copy, Debug, Default, Arguments)]
pub struct AccuracyArgs {
    /// Choose tolerance and contact nodes for this relative error of the settled motion, such as 1e-4.
    #[arg(long, value_name = "ERROR", value_parser = positive)]
    pub accuracy: Option<f64>,
}

impl AccuracyArgs {
    /// Returns the scene with this accuracy.
    pub fn apply(self, scene: Scene) -> Result<Scene, SceneError> {
        match self.accuracy {
            Some(error) => scene.with_accuracy(error),
            None => Ok(scene),
        }
    }
}

/// The budget of the analyses of a command.
#[derive(Clone, Copy, Debug, Default, Arguments)]
pub struct BudgetArgs {
    /// Compute all windows of the analyses, or fewer of those that are only displayed while they are slower than
    /// real time (in a live run: than the playback) [default: the scene's].
    #[arg(long, value_name = "BUDGET", value_parser = budgets())]
    pub budget: Option<AnalysisBudget>,
}

impl BudgetArgs {
    /// Returns the scene with this budget.
    pub fn apply(self, scene: Scene) -> Result<Scene, SceneError> {
        match self.budget {
            Some(budget) => scene.with_overrides(&[("analysis.budget", <&str>::from(budget))]),
            None => Ok(scene),
        }
    }
}

/// Parses a budget by its name in a scene file.
fn budgets() -> impl TypedValueParser<Value = AnalysisBudget> {
    let names = AnalysisBudget::VARIANTS.iter().map(<&str>::from);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<AnalysisBudget>())
}

/// The Rerun viewer of a command.
#[derive(Clone, Debug, Default, Arguments)]
#[command(next_help_heading = "Viewer")]
pub struct ViewerArgs {
    /// Open a Rerun viewer on this machine.
    #[arg(long, conflicts_with = "connect")]
    pub spawn: bool,
    /// Send the recording to a running Rerun viewer.
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = DEFAULT_URL, value_parser = viewer_url)]
    pub connect: Option<String>,
}

impl ViewerArgs {
    /// A recording for the viewer, and for a file; `None` without either.
    pub fn output(&self, save: Option<PathBuf>) -> Option<Output> {
        let output = Output {
            save,
            connect: self.connect.clone(),
            spawn: self.spawn,
        };
        (output != Output::default()).then_some(output)
    }
}

/// Default URL of a running Rerun viewer.
const DEFAULT_URL: &str = "rerun+http://127.0.0.1:9876/proxy";

/// Parses the URL of a viewer and checks its scheme.
fn viewer_url(text: &str) -> Result<String, String> {
    let known = ["rerun+http://", "rerun+https://", "rerun://"];
    if known.iter().any(|scheme| text.starts_with(scheme)) {
        Ok(text.to_owned())
    } else {
        Err(format!("give the URL of a viewer, such as {DEFAULT_URL}"))
    }
}

/// Parses `KEY=VALUE`.
fn key_and_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text
        .split_once('=')
        .ok_or("give a key and its value, such as load.tilt_deg=4")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// Parses a finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &f64| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "give a number above 0".to_owned())
}

/// Parses one tilt or A:B:STEP, -90 to 90 degrees.
pub fn tilts(text: &str) -> Result<Steps, String> {
    let steps: Steps = text.parse()?;
    match steps.0.iter().find(|tilt| tilt.abs() > 90.0) {
        None => Ok(steps),
        Some(tilt) => Err(format!(
            "a tilt of {tilt} degrees is out of range; give -90 to 90 degrees"
        )),
    }
}

/// The sound file, the quantity that it plays, and the point of the surface.
#[derive(Debug, Default, Arguments)]
#[command(next_help_heading = "Sound")]
pub struct SoundArgs {
    /// Write the sound as a WAV file: 48 kHz, peak at -1 dBFS without --wav-level. `live` writes the first run, at
    /// real-time speed.
    #[arg(long, value_name = "FILE")]
    pub wav: Option<PathBuf>,
    /// Keep the true level, to compare runs by ear: full scale is this velocity, mm/s (with --sound pressure this
    /// acceleration, m/s^2).
    #[arg(long, value_name = "PEAK", value_parser = positive, requires = "wav")]
    pub wav_level: Option<f64>,
    /// Quantity that the sound represents.
    #[arg(long, value_enum, default_value_t = Quantity::Velocity)]
    pub sound: Quantity,
    /// Play the normal motion of the surface point nearest to X,Y,Z: mm from the ball's centre, beam at negative z
    /// [default: the contact's centre].
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub probe: Option<[f64; 3]>,
}

impl SoundArgs {
    /// The quantity and its place.
    pub fn source(&self) -> Source {
        let unit = match self.sound {
            Quantity::Velocity => 1e-3,
            Quantity::Pressure => 1.0,
        };
        Source {
            full_scale: self.wav_level.map(|peak| unit * peak),
            quantity: self.sound,
            point: self.probe.map(|mm| mm.map(|x| 1e-3 * x)),
        }
    }
}

/// Parses a point, in mm from the ball's centre.
fn point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let numbers = numbers.ok().and_then(|all| <[f64; 3]>::try_from(all).ok());
    let finite = numbers.filter(|all| all.iter().all(|x| x.is_finite()));
    finite.ok_or_else(|| "give three numbers, such as 8,0,60".to_owned())
}
