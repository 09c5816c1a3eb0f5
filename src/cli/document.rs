//! Output of a result: text for the terminal, JSON for programs.
//!
//! The JSON object has the fields of the result struct. Later versions may add fields, but do not change the
//! meaning of a field. The unit of a number is the suffix of its field name. Non-finite numbers are `null`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use super::output::{OutputError, OutputFile, is_stdout};
use super::report::print;
use crate::number::size;
use crate::{VERSION, escape};

/// A result with the version of the program, the scene and the written files.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Document<R> {
    /// Version of squeakscope.
    version: String,
    /// Name of the scene; absent in a result without a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<String>,
    #[serde(flatten)]
    result: R,
    /// Written files.
    files: Vec<WrittenFile>,
}

/// A written file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct WrittenFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Size of the file, bytes.
    pub bytes: u64,
}

impl WrittenFile {
    /// Describes a file that has just been written.
    ///
    /// # Errors
    /// If the file does not exist.
    pub fn of(file: &OutputFile) -> Result<Self, OutputError> {
        Ok(Self {
            path: file.path().to_owned(),
            bytes: file.size()?,
        })
    }
}

impl<R: Serialize> Document<R> {
    /// A result and its files.
    pub fn new(result: R, files: &[WrittenFile]) -> Self {
        Self {
            version: VERSION.to_owned(),
            scene: None,
            result,
            files: files.to_vec(),
        }
    }

    /// Adds the name of the scene.
    pub fn with_scene(self, scene: &str) -> Self {
        let scene = Some(scene.to_owned());
        Self { scene, ..self }
    }

    /// Prints `text` and the list of files, and writes the JSON file, if there is one.
    ///
    /// # Errors
    /// If the JSON file or the standard output cannot be written.
    pub fn deliver(&self, text: &str, json: Option<&OutputFile>) -> Result<(), OutputError> {
        let written = self.write(json);
        print(&format!("{text}{}", list(&self.files)))?;
        written
    }

    /// Prints the JSON if it was requested on the standard output, otherwise delivers text and file.
    ///
    /// # Errors
    /// As [`Document::deliver`].
    pub fn deliver_or_print(
        &self,
        text: &str,
        requested: Option<&Path>,
        json: Option<&OutputFile>,
    ) -> Result<(), OutputError> {
        if requested.is_some_and(is_stdout) {
            self.print()
        } else {
            self.deliver(text, json)
        }
    }

    /// Writes the JSON file, if there is one.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, json: Option<&OutputFile>) -> Result<(), OutputError> {
        let Some(file) = json else {
            return Ok(());
        };
        file.write(|out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            writeln!(out)
        })
    }

    /// Prints JSON to the standard output.
    ///
    /// # Errors
    /// If the standard output cannot be written.
    pub fn print(&self) -> Result<(), OutputError> {
        let json = serde_json::to_string_pretty(self)
            .map_err(|fault| OutputError::Terminal(fault.into()))?;
        print(&format!("{json}\n"))
    }
}

/// Lists files with their sizes, one per line.
pub(super) fn list(files: &[WrittenFile]) -> String {
    let line = |file: &WrittenFile| {
        let path = escape::path(&file.path);
        format!("  {path} ({})\n", size(file.bytes))
    };
    files.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_has_the_result_version_scene_and_files() {
        #[derive(Serialize)]
        struct Example {
            value_m: f64,
            rate_per_s: f64,
        }
        let example = Example {
            value_m: 0.1 + 0.2,
            rate_per_s: f64::NAN,
        };
        let files = [WrittenFile {
            path: "a.rrd".into(),
            bytes: 2_500_000,
        }];
        let json =
            serde_json::to_value(Document::new(&example, &files).with_scene("made")).unwrap();
        let expected = serde_json::json!({
            "version": VERSION,
            "scene": "made",
            "value_m": 0.1 + 0.2,
            "rate_per_s": null,
            "files": [{"path": "a.rrd", "bytes": 2_500_000}],
        });
        assert_eq!(json, expected);
        assert_eq!(list(&files), "  a.rrd (2.5 MB)\n");
        let bare = serde_json::to_value(Document::new(&example, &[])).unwrap();
        assert!(bare.get("scene").is_none());
    }
}
