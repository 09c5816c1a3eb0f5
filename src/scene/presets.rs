//! Built-in scenes, and scenes from files.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use super::error::{SceneError, did_you_mean, nearest};
use super::spec::Scene;

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Name, as in `squeakscope run NAME`.
    pub name: &'static str,
    /// Text of the scene file.
    pub text: &'static str,
}

impl Preset {
    /// Parses and validates the scene.
    ///
    /// # Errors
    /// None: the tests check all presets. The preset is parsed like a file, which can fail.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        Scene::parse(self.name, self.text)
    }
}

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        &[$(Preset {
            name: $name,
            text: include_str!(concat!("../../assets/scenes/", $name, ".toml")),
        }),*]
    };
}

/// The built-in scenes: ball joints from stable sliding to chaos, then small systems.
pub const PRESETS: &[Preset] = presets![
    "tilt-ramp",
    "printed-friction",
    "periodic-2deg",
    "mode-shift-3.5deg",
    "torus-birth",
    "torus-1.75deg",
    "doubled-torus-3deg",
    "chaos-5deg",
    "paper",
    "stick-slip",
    "lift-off",
    "exchanged-friction",
    "which-mode-wins",
    "hysteresis",
    "articulation",
    "bristles",
    "contact-age",
    "measured-friction",
    "negative-slope",
    "mode-coupling",
    "mass-on-belt",
    "impact-oscillator",
    "damped-contact",
];

/// Name of the default scene.
pub const DEFAULT_SCENE: &str = "tilt-ramp";

/// Returns the preset with the given name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

impl Scene {
    /// Loads a scene by the name of a preset or the path of a file.
    ///
    /// # Errors
    /// If neither exists, the file cannot be read, or its content is not a valid scene.
    pub fn load(name: &str) -> Result<Self, SceneError> {
        match preset(name) {
            Some(preset) => preset.scene(),
            None => Self::parse(name, read(name)?),
        }
    }
}

/// Reads a file up to a size limit, so that reading an endless device ends.
fn read(name: &str) -> Result<Vec<u8>, SceneError> {
    /// A typical scene has a few kilobytes; 10,000 knots take a few hundred.
    const LIMIT: u64 = 4 << 20;

    let mut content = Vec::new();
    File::open(name)
        .and_then(|file| file.take(LIMIT + 1).read_to_end(&mut content))
        .map_err(|source| {
            let is_path = Path::new(name).components().count() > 1 || name.ends_with(".toml");
            if source.kind() == ErrorKind::NotFound && !is_path {
                unknown(name)
            } else {
                SceneError::unreadable(name, source)
            }
        })?;
    if content.len() as u64 > LIMIT {
        return Err(SceneError::whole(format!(
            "the scene file `{name}` is larger than {LIMIT} bytes; a scene is a few kilobytes of TOML"
        )));
    }
    Ok(content)
}

fn unknown(name: &str) -> SceneError {
    let names: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
    let nearest = did_you_mean(nearest(name, names.iter().copied()));
    SceneError::whole(format!(
        "no scene is called `{name}`{nearest}; choose one of {}, or give the path of a scene file",
        names.join(", ")
    ))
}
