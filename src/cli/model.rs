//! `squeakscope model`: the arrays of Eq. (8) as a NumPy file.

use std::io::{Cursor, Write};

use schemars::JsonSchema;
use serde::Serialize;

use super::args::ModelArgs;
use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::output::Kind;
use super::report::{self, HEADING};
use crate::escape;
use crate::export::{ModelArrays, encode_model};
use crate::joint::BallJoint;
use crate::pipeline::initial_state;
use crate::scene::Scene;

/// Size of a model.
#[derive(Serialize, JsonSchema)]
pub(super) struct Size {
    /// Number of contact nodes.
    nodes: usize,
    /// Number of modes.
    modes: usize,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while assembling or writing.
pub(super) fn model(args: &ModelArgs) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    scene.joint()?;
    report::print_warnings(&scene.warnings());
    report::print_fixed(&scene, []);
    let [out, json] = args.overwrite.check_all(
        args.scene.input(),
        [
            ("--out", Kind::ARRAYS, Some(&args.out)),
            ("--json", Kind::JSON, args.json.as_deref()),
        ],
    )?;
    let out = out.expect("--out is required");
    let (size, npz) = build(&scene).map_err(CliError::during("assembly of the model"))?;
    out.write(|file| file.write_all(&npz))?;
    let text = format!(
        "{HEADING}{}{HEADING:#}: {} contact nodes, {} modes\n",
        escape::line(&scene.name),
        size.nodes,
        size.modes
    );
    let files = [WrittenFile::of(&out)?];
    let document = Document::new(&size, &files).with_scene(&scene.name);
    Ok(document.deliver(&text, json.as_ref())?)
}

/// Assembles the model at the start of a scene and encodes it as a `.npz` file.
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
    fn the_file_and_the_size_of_a_model_are_written() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let args = ModelArgs {
            scene: Default::default(),
            out: folder.path().join("model.npz"),
            json: Some(folder.path().join("model.json")),
            overwrite: Default::default(),
        };
        model(&args).expect("success");
        let bytes = std::fs::metadata(&args.out).expect("written").len();
        let text = std::fs::read(folder.path().join("model.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(json["scene"], DEFAULT_SCENE);
        assert_eq!(json["nodes"], 16);
        assert_eq!(json["modes"], 11);
        assert_eq!(json["files"][0]["bytes"], bytes);
    }
}
