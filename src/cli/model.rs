//! `squeakscope model`: the arrays of Eq. (8) as a NumPy file.

use std::io::{Cursor, Write};

use schemars::JsonSchema;
use serde::Serialize;

use super::args::ModelArgs;
use super::console;
use super::error::{Cause, CliError};
use super::harness::Outputs;
use super::output::Kind;
use crate::export::{encode_model, replace_file};
use crate::joint::BallJoint;
use crate::pipeline::initial_state;
use crate::report::{Block, Report};
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
    console::print_warnings(&scene.warnings());
    console::print_fixed(&scene, []);
    let mut files = Outputs::new(args.scene.input(), &args.output)
        .file("--out", Kind::ARRAYS, Some(&args.out))?
        .check()?;
    let (size, npz) = build(&scene).map_err(CliError::during("assembly of the model"))?;
    files.write("--out", |path| {
        replace_file(path, |out| out.write_all(&npz))
    })?;
    files.deliver(Some(&scene.name), &size)
}

impl Report for Size {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let rest = format!(": {} contact nodes, {} modes", self.nodes, self.modes);
        vec![Block::heading(scene, rest)]
    }
}

/// Assembles the model at the start of a scene and encodes it as a `.npz` file.
fn build(scene: &Scene) -> Result<(Size, Vec<u8>), Cause> {
    let joint = scene.joint()?;
    let model = BallJoint::new(&joint.spec)?.model(joint.tilt.at(0.0))?;
    let (nodes, modes) = (model.nodes(), model.modes());
    let mut npz = Cursor::new(Vec::new());
    encode_model(&mut npz, &model, &initial_state(scene, modes))?;
    Ok((Size { nodes, modes }, npz.into_inner()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::tests::parsed;
    use crate::scene::DEFAULT_SCENE;

    #[test]
    fn the_file_and_the_size_of_a_model_are_written() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = |name: &str| folder.path().join(name);
        let [out, json] = [path("model.npz"), path("model.json")];
        let line = format!("--out {} --json {}", out.display(), json.display());
        model(&parsed(&line)).expect("success");
        let bytes = std::fs::metadata(&out).expect("written").len();
        let text = std::fs::read(json).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(json["scene"], DEFAULT_SCENE);
        assert_eq!(json["nodes"], 16);
        assert_eq!(json["modes"], 11);
        assert_eq!(json["files"][0]["bytes"], bytes);
        let size = Size {
            nodes: 16,
            modes: 11,
        };
        crate::report::agreement::check(&size, &[]);
    }
}
