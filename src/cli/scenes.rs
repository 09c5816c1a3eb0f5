//! `squeakscope scenes`: list the scenes, print one, tell what its effects cost, or print what a scene file
//! can say.

use serde::Serialize;

use super::args::ScenesArgs;
use super::document::Document;
use super::effects;
use super::error::CliError;
use super::interrupt;
use super::output;
use super::report::{self, NAME};
use crate::escape;
use crate::scene::{PRESETS, Scene, SceneError, key_reference};
use crate::table::Table;

/// All scenes that come with the program.
#[derive(Serialize)]
struct Scenes<'a> {
    scenes: Vec<Entry<'a>>,
}

/// What JSON says of a scene.
#[derive(Serialize)]
struct Entry<'a> {
    /// Name, as in `squeakscope run NAME`.
    name: &'a str,
    /// One line that says what it shows.
    title: &'a str,
    /// What to look for (Markdown).
    about: &'a str,
    /// Simulated time, s.
    duration_s: f64,
    /// The text of the scene file.
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
/// When the scene asked for is unknown or faulty or cannot be run, or the JSON file cannot be written.
pub(super) fn scenes(args: &ScenesArgs) -> Result<(), CliError> {
    if args.keys {
        return Ok(report::print(key_reference().trim_start())?);
    }
    // Before anything is read.
    let stop = args.effects.then(interrupt::catch).transpose()?;
    let [json] = output::check_all(None, [("--json", args.json.as_deref())])?;
    match &args.name {
        None => {
            let scenes = PRESETS.iter().map(|preset| preset.scene());
            let scenes = scenes.collect::<Result<Vec<_>, SceneError>>()?;
            let entries = scenes.iter().map(Entry::from).collect();
            Document::new(&Scenes { scenes: entries }, &[])
                .deliver(&list(&scenes), json.as_ref())?;
        }
        Some(name) => {
            let scene = Scene::load(name)?;
            report::print_warnings(&scene.warnings());
            if let Some(stop) = stop {
                return effects::effects(&scene, json.as_ref(), &stop);
            }
            // The scene file's text, so that it can be saved and run.
            Document::new(&Entry::from(&scene), &[]).deliver(&scene.text, json.as_ref())?;
        }
    }
    Ok(())
}

/// The scenes, a line each.
fn list(scenes: &[Scene]) -> String {
    let mut table = Table::default().left("").left("");
    for scene in scenes {
        let [name, title] = [&scene.name, &scene.title].map(|text| escape::line(text));
        table.row([format!("{NAME}{name}{NAME:#}"), title.into_owned()]);
    }
    table.text() + "\nsqueakscope scenes NAME prints one; squeakscope run NAME runs it\n"
}
