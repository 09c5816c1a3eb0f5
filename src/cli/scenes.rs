//! `squeakscope scenes`: list the scenes, print one, tell what its effects cost, or print what a scene file
//! can say.

use super::args::ScenesArgs;
use super::effects;
use super::error::CliError;
use super::interrupt;
use super::output;
use super::report::{self, SceneReport, ScenesReport};
use crate::scene::{Scene, key_reference};

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
        None => report::deliver(&ScenesReport::of_presets()?, json.as_ref())?,
        Some(name) => {
            let scene = Scene::load(name)?;
            report::print_warnings(&scene.warnings());
            if let Some(stop) = stop {
                return effects::effects(&scene, json.as_ref(), &stop);
            }
            report::deliver(&SceneReport::new(&scene), json.as_ref())?;
        }
    }
    Ok(())
}
