//! `squeakscope scenes`: list the scenes, print one, or print the keys of scene files.

use schemars::JsonSchema;
use serde::Serialize;

use super::args::ScenesArgs;
use super::document::Document;
use super::error::CliError;
use super::output::Kind;
use super::report::{self, HEADING};
use crate::escape;
use crate::scene::{PRESETS, Scene, SceneError, key_reference};
use crate::table::Table;

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
/// If the scene is unknown or invalid, or the JSON file cannot be written.
pub(super) fn scenes(args: &ScenesArgs) -> Result<(), CliError> {
    if args.keys {
        return Ok(report::print(key_reference().trim_start())?);
    }
    let [json] = args
        .overwrite
        .check_all(None, [("--json", Kind::JSON, args.json.as_deref())])?;
    match &args.scene.scene {
        None => {
            let scenes = PRESETS.iter().map(|preset| preset.scene());
            let scenes = scenes.collect::<Result<Vec<_>, SceneError>>()?;
            let entries = scenes.iter().map(Entry::from).collect();
            Document::new(&Scenes { scenes: entries }, &[])
                .deliver(&list(&scenes), json.as_ref())?;
        }
        Some(_) => {
            let scene = args.scene.load()?;
            report::print_warnings(&scene.warnings());
            // The exact text of the scene file, which can be saved and run.
            Document::new(&Entry::from(&scene), &[]).deliver(&scene.text, json.as_ref())?;
        }
    }
    Ok(())
}

/// The scenes, one per line.
fn list(scenes: &[Scene]) -> String {
    let mut table = Table::default().left("").left("");
    for scene in scenes {
        let [name, title] = [&scene.name, &scene.title].map(|text| escape::line(text));
        table.row([format!("{HEADING}{name}{HEADING:#}"), title.into_owned()]);
    }
    table.text() + "\n`squeakscope scenes NAME` prints a scene, `squeakscope run NAME` runs it.\n"
}
