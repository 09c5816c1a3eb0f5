//! `squeakscope scenes`: list the scenes, print one, compare two, or print the keys of scene files.

use schemars::JsonSchema;
use serde::Serialize;

use super::args::ScenesArgs;
use super::console;
use super::error::CliError;
use super::harness::Outputs;
use crate::report::{Block, Report, Table, Tone};
use crate::scene::{PRESETS, Scene, SceneComparison, SceneError, key_reference};

/// The built-in scenes.
#[derive(Serialize, JsonSchema)]
pub(super) struct Scenes<'a> {
    /// Scenes in the order of the list.
    scenes: Vec<Entry<'a>>,
}

/// A scene.
#[derive(Serialize, JsonSchema)]
pub(super) struct Entry<'a> {
    /// Name, as in `squeakscope run NAME`.
    name: &'a str,
    /// Title, one line.
    title: &'a str,
    /// Description and what to look for (Markdown).
    about: &'a str,
    /// Duration: simulated time, s.
    duration_s: f64,
    /// Text of the scene file.
    toml: &'a str,
}

impl<'a> From<&'a Scene> for Entry<'a> {
    fn from(scene: &'a Scene) -> Self {
        Self {
            name: &scene.name,
            title: &scene.title,
            about: &scene.about,
            duration_s: scene.duration,
            toml: &scene.text,
        }
    }
}

/// Runs the command.
///
/// # Errors
/// If a scene is unknown or invalid, or the JSON file cannot be written.
pub(super) fn scenes(args: &ScenesArgs) -> Result<(), CliError> {
    if args.keys {
        return console::print(key_reference().trim_start());
    }
    let files = Outputs::new(None, &args.output).check()?;
    if let [one, other] = &args.compare[..] {
        let found = SceneComparison::new(&Scene::load(one)?, &Scene::load(other)?)?;
        return files.deliver(None, &found);
    }
    if args.scene.scene.is_some() {
        let scene = args.scene.load()?;
        console::print_warnings(&scene.warnings());
        return files.deliver(None, &Entry::from(&scene));
    }
    let scenes = PRESETS.iter().map(|preset| preset.scene());
    let scenes = scenes.collect::<Result<Vec<_>, SceneError>>()?;
    let scenes = scenes.iter().map(Entry::from).collect();
    files.deliver(None, &Scenes { scenes })
}

impl Report for Entry<'_> {
    /// The exact text of the scene file, which can be saved and run.
    fn blocks(&self, _name: &str) -> Vec<Block> {
        vec![Block::Code(self.toml.to_owned())]
    }
}

impl Report for Scenes<'_> {
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let table = Table::of(&self.scenes)
            .left("", |scene| Tone::Strong.cell(scene.name))
            .left("", |scene| scene.title);
        let hint = "`squeakscope scenes NAME` prints a scene, `squeakscope run NAME` runs it.";
        vec![table.into(), Block::Code(format!("{hint}\n"))]
    }
}
