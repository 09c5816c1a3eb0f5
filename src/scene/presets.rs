//! The scenes that come with the program, and scenes from files.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use super::error::{CLOSE, SceneError, nearest};
use super::spec::Scene;

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Name, as in `squeakscope run NAME`.
    pub name: &'static str,
    /// The scene file's text.
    pub text: &'static str,
}

impl Preset {
    /// Parses and validates it.
    ///
    /// # Errors
    /// None as long as the crate's tests pass; the type says so because it is parsed like a file.
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

/// The scenes that come with the program: the joint from silence to chaos, then small systems.
pub const PRESETS: &[Preset] = presets![
    "tilt-ramp",
    "printed-friction",
    "periodic-2deg",
    "mode-shift-3.5deg",
    "torus-3deg",
    "chaos-5deg",
    "paper",
    "stick-slip",
    "lift-off",
    "exchanged-friction",
    "which-mode-wins",
    "hysteresis",
    "negative-slope",
    "mode-coupling",
    "mass-on-belt",
    "impact-oscillator",
    "damped-contact",
];

/// Name of the scene that runs if none is asked for.
pub const DEFAULT_SCENE: &str = "tilt-ramp";

/// The preset of the given name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

impl Scene {
    /// Loads a scene by the name of a preset or the path of a file.
    ///
    /// # Errors
    /// When there is neither, the file cannot be read, or its content is no valid scene.
    pub fn load(name: &str) -> Result<Self, SceneError> {
        match preset(name) {
            Some(preset) => preset.scene(),
            None => Self::parse(name, read(name)?),
        }
    }
}

/// Reads a file of a sensible size; endless devices included.
fn read(name: &str) -> Result<Vec<u8>, SceneError> {
    /// A scene is a few kilobytes; ten thousand knots are a few hundred.
    const LIMIT: u64 = 4 << 20;

    let mut content = Vec::new();
    File::open(name)
        .and_then(|file| file.take(LIMIT + 1).read_to_end(&mut content))
        .map_err(|source| {
            if source.kind() == ErrorKind::NotFound && !looks_like_a_path(name) {
                unknown(name)
            } else {
                SceneError::Unreadable {
                    file: name.to_owned(),
                    source,
                }
            }
        })?;
    if content.len() as u64 > LIMIT {
        return Err(SceneError::TooLarge {
            file: name.to_owned(),
            limit: LIMIT,
        });
    }
    Ok(content)
}

/// Whether a name that is no file was still meant as one.
fn looks_like_a_path(name: &str) -> bool {
    let path = Path::new(name);
    path.components().count() > 1
        || path
            .extension()
            .is_some_and(|extension| extension == "toml")
}

fn unknown(name: &str) -> SceneError {
    let names: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
    SceneError::UnknownScene {
        name: name.to_owned(),
        nearest: nearest(name, names.iter().copied(), CLOSE).map(str::to_owned),
        known: names.join(", "),
    }
}
