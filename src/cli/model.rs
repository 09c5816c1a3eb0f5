//! `squeakscope model`: all that Eq. (8) needs, as NumPy arrays.

use std::ffi::OsStr;
use std::io::Write;

use super::args::ModelArgs;
use super::error::{Cause, CliError};
use super::output::check_all;
use super::report::{self, FileReport, ModelReport};
use crate::VERSION;
use crate::scene::{DEFAULT_SCENE, Scene};

/// A model ready to be written.
pub(super) struct ModelFile {
    /// Number of contact nodes.
    pub nodes: usize,
    /// Number of modes.
    pub modes: usize,
    /// The whole `.npz` file.
    pub npz: Vec<u8>,
}

/// Runs the command; `build` makes the model of a scene at its start.
///
/// # Errors
/// Bad input before any work; a fault while building or writing.
pub(super) fn model(
    args: &ModelArgs,
    build: impl FnOnce(&Scene) -> Result<ModelFile, Cause>,
) -> Result<(), CliError> {
    let scene = Scene::load(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    let held = scene.joint()?.held_at_first();
    report::print_warnings(&scene.warnings());
    report::print_held(held);
    let [out, json] = check_all(
        args.scene.as_deref().map(OsStr::new),
        [("--out", Some(&args.out)), ("--json", args.json.as_deref())],
    )?;
    let out = out.expect("a path was given, and has been checked");
    let model = build(&scene).map_err(|source| CliError::Run {
        doing: "model",
        source,
    })?;
    out.write(|file| file.write_all(&model.npz))?;
    let report = ModelReport {
        version: VERSION,
        scene: scene.name,
        nodes: model.nodes,
        modes: model.modes,
        file: FileReport::of(&out)?,
    };
    Ok(report::deliver(&report, json.as_ref())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_written_whole_or_not_at_all() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let args = ModelArgs {
            scene: None,
            out: folder.path().join("model.npz"),
            json: Some(folder.path().join("model.json")),
        };
        let failed = model(&args, |_| Err("no mode converged".into())).expect_err("failed");
        assert_eq!(failed.exit_code(), 1);
        assert!(!args.out.exists());
        let build = |scene: &Scene| -> Result<_, Cause> {
            Ok(ModelFile {
                nodes: scene.joint()?.spec.contact.nodes,
                modes: scene.subject.modes(),
                npz: vec![1, 2, 3],
            })
        };
        model(&args, build).expect("done");
        assert_eq!(std::fs::read(&args.out).expect("written"), [1, 2, 3]);
        let text = std::fs::read(folder.path().join("model.json")).expect("written");
        let report: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(report["nodes"], 100);
        assert_eq!(report["modes"], 11);
        assert_eq!(report["file"]["bytes"], 3);
    }
}
