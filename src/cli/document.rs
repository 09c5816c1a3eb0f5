//! How a command hands on its result: as text for the terminal, and as JSON for programs.
//!
//! JSON is the result's own struct. A field may be added in a later version, none changes its meaning. Every number
//! is in the unit at the end of its field's name. A number that is not finite is written as `null`.

use std::io::Write as _;
use std::path::PathBuf;

use serde::Serialize;

use super::output::{OutputError, OutputFile};
use super::report::print;
use crate::number::size;
use crate::{VERSION, escape};

/// A result as it is written: beside it the version of the program, the scene and the files.
#[derive(Debug, Serialize)]
pub(super) struct Document<'a, R> {
    /// Version of the program.
    version: &'static str,
    /// Name of the scene; none of what is no scene's.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<&'a str>,
    #[serde(flatten)]
    result: &'a R,
    /// Files written.
    files: &'a [WrittenFile],
}

/// A file that a command has written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct WrittenFile {
    /// Its path.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
}

impl WrittenFile {
    /// A file that has just been written.
    ///
    /// # Errors
    /// When it is not there.
    pub fn of(file: &OutputFile) -> Result<Self, OutputError> {
        Ok(Self {
            path: file.path().to_owned(),
            bytes: file.size()?,
        })
    }
}

impl<'a, R: Serialize> Document<'a, R> {
    /// A result, and the files that hold it.
    pub fn new(result: &'a R, files: &'a [WrittenFile]) -> Self {
        Self {
            version: VERSION,
            scene: None,
            result,
            files,
        }
    }

    /// The same, of a scene.
    pub fn of_scene(self, scene: &'a str) -> Self {
        let scene = Some(scene);
        Self { scene, ..self }
    }

    /// Prints the result's text and the files, and writes JSON if asked for.
    ///
    /// # Errors
    /// When the JSON file cannot be written.
    pub fn deliver(&self, text: &str, json: Option<&OutputFile>) -> Result<(), OutputError> {
        let written = self.write(json);
        print(&format!("{text}{}", list(self.files)))?;
        written
    }

    /// Writes JSON, where a file is given.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, json: Option<&OutputFile>) -> Result<(), OutputError> {
        let Some(file) = json else {
            return Ok(());
        };
        file.write(|out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            writeln!(out)
        })
    }

    /// Prints JSON in place of the text.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn print(&self) -> Result<(), OutputError> {
        let json = serde_json::to_string_pretty(self)
            .map_err(|fault| OutputError::Terminal(fault.into()))?;
        print(&format!("{json}\n"))
    }
}

/// Files, a line each with its size.
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
    fn a_document_is_its_result_with_version_scene_and_files() {
        #[derive(Serialize)]
        struct Found {
            value_m: f64,
            rate_per_s: f64,
        }
        let found = Found {
            value_m: 0.1 + 0.2,
            rate_per_s: f64::NAN,
        };
        let files = [WrittenFile {
            path: "a.rrd".into(),
            bytes: 2_500_000,
        }];
        let json = serde_json::to_value(Document::new(&found, &files).of_scene("made")).unwrap();
        let expected = serde_json::json!({
            "version": VERSION,
            "scene": "made",
            "value_m": 0.1 + 0.2,
            "rate_per_s": null,
            "files": [{"path": "a.rrd", "bytes": 2_500_000}],
        });
        assert_eq!(json, expected);
        assert_eq!(list(&files), "  a.rrd (2.5 MB)\n");
        let bare = serde_json::to_value(Document::new(&found, &[])).unwrap();
        assert!(bare.get("scene").is_none());
    }
}
