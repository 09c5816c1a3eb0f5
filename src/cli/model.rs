//! `squeakscope model`: all that Eq. (8) needs, as NumPy arrays.

use std::io::{Cursor, Write};

use serde::Serialize;

use super::args::ModelArgs;
use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::output::check_all;
use super::report::{self, NAME};
use crate::escape;
use crate::export::{ModelArrays, encode_model};
use crate::joint::BallJoint;
use crate::pipeline::initial_state;
use crate::scene::Scene;

/// How large a model is: its contact nodes, and its modes.
#[derive(Serialize)]
struct Size {
    /// Number of contact nodes.
    nodes: usize,
    /// Number of modes.
    modes: usize,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while building or writing.
pub(super) fn model(args: &ModelArgs) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    let held = scene.joint()?.held_at_first();
    report::print_warnings(&scene.warnings());
    report::print_held(held);
    let [out, json] = check_all(
        args.scene.input(),
        [("--out", Some(&args.out)), ("--json", args.json.as_deref())],
    )?;
    let out = out.expect("a path was given, and has been checked");
    let (size, npz) = build(&scene).map_err(|source| CliError::Run {
        doing: "model",
        source,
    })?;
    out.write(|file| file.write_all(&npz))?;
    let text = format!(
        "{NAME}{}{NAME:#}: {} contact nodes, {} modes\n",
        escape::line(&scene.name),
        size.nodes,
        size.modes
    );
    let files = [WrittenFile::of(&out)?];
    let document = Document::new(&size, &files).of_scene(&scene.name);
    Ok(document.deliver(&text, json.as_ref())?)
}

/// The model of a scene at its start, as a `.npz` file.
fn build(scene: &Scene) -> Result<(Size, Vec<u8>), Cause> {
    let joint = scene.joint()?;
    let model = BallJoint::new(&joint.spec)?.model(joint.tilt.at(0.0))?;
    let (nodes, modes) = (model.nodes(), model.modes());
    let arrays = ModelArrays::new(model, initial_state(scene, modes));
    let mut npz = Cursor::new(Vec::new());
    encode_model(&mut npz, &arrays)?;
    Ok((Size { nodes, modes }, npz.into_inner()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::DEFAULT_SCENE;

    #[test]
    fn a_model_is_written_with_its_size() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let args = ModelArgs {
            scene: Default::default(),
            out: folder.path().join("model.npz"),
            json: Some(folder.path().join("model.json")),
        };
        model(&args).expect("done");
        let bytes = std::fs::metadata(&args.out).expect("written").len();
        let text = std::fs::read(folder.path().join("model.json")).expect("written");
        let found: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(found["scene"], DEFAULT_SCENE);
        assert_eq!(found["nodes"], 100);
        assert_eq!(found["modes"], 11);
        assert_eq!(found["files"][0]["bytes"], bytes);
    }
}
