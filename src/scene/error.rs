//! Errors and warnings of scenes. Each message states the fault, its position and the remedy.

use std::fmt;
use std::io;

use thiserror::Error;

use super::schema::split;
use crate::joint::ImportedModesError;

/// A scene that cannot be run, or a change or value that a scene or a study does not permit. The message contains position,
/// key, permitted values and, for a likely misspelling, the most similar known name.
#[derive(Debug, Error)]
#[error("{}{message}", at.as_ref().map_or_else(String::new, |at| format!("{at}: ")))]
pub struct SceneError {
    /// Position of the faulty value or key, or of the table that lacks a key: the file as the user named it, or the name of
    /// a built-in scene, with the line, such as `mine.toml:3`; `None` for a scene as a whole.
    pub at: Option<String>,
    /// The fault and its remedy.
    message: String,
    /// Why a file cannot be read.
    source: Option<io::Error>,
}

impl SceneError {
    /// A fault of a scene as a whole, with its remedy.
    pub(crate) fn whole(message: String) -> Self {
        Self {
            at: None,
            message,
            source: None,
        }
    }

    /// A file that cannot be read.
    pub(super) fn unreadable(file: &str, source: io::Error) -> Self {
        let message = format!(
            "cannot read the scene file `{file}`; give a readable TOML file or the name of a built-in scene"
        );
        Self {
            source: Some(source),
            ..Self::whole(message)
        }
    }

    /// A fault at a position, with its remedy.
    pub(super) fn new(at: String, problem: impl fmt::Display, remedy: impl fmt::Display) -> Self {
        Self {
            at: Some(at),
            ..Self::whole(format!("{problem}; {remedy}"))
        }
    }

    /// Values that are valid individually but inconsistent with each other.
    pub(super) fn inconsistent(
        at: String,
        key: impl fmt::Display,
        problem: impl fmt::Display,
        remedy: impl fmt::Display,
    ) -> Self {
        Self::new(at, format!("`{key}`: {problem}"), remedy)
    }

    /// A text that is not valid TOML.
    pub(super) fn syntax(at: String, error: &toml_edit::TomlError) -> Self {
        let problem = format!("not valid TOML: {}", error.message().replace('\n', " "));
        let remedy = "`squeakscope scenes NAME` prints a valid scene to start from";
        Self::new(at, problem, remedy)
    }

    /// A file of modes that is invalid.
    pub(super) fn modes(at: String, file: impl fmt::Display, problem: &ImportedModesError) -> Self {
        Self {
            at: Some(at),
            ..Self::whole(format!("`body.modes`: {file}: {problem}"))
        }
    }

    /// A scene with another system than the operation requires: what is required, with the verb, what the scene has, and
    /// what a suitable one has.
    pub(crate) fn wrong_system(scene: &str, required: &str, defines: &str, remedy: &str) -> Self {
        Self::whole(format!(
            "{required} required, but the scene `{scene}` {defines}; choose a scene {remedy}"
        ))
    }

    /// The same fault at another position.
    pub(super) fn moved_to(self, at: String) -> Self {
        Self {
            at: self.at.map(|_| at),
            ..self
        }
    }
}

/// Returns an error for inconsistent values unless the condition holds. The arguments after the condition
/// are the key, the other keys involved, the problem and the remedy.
macro_rules! ensure {
    (
        $document:expr, $holds:expr => $key:expr, $others:expr;
        $problem:literal $(, $value:expr)*;
        $remedy:literal $(, $limit:expr)*
    ) => {{
        let holds: bool = $holds;
        if !holds {
            let (problem, remedy) = (format!($problem $(, $value)*), format!($remedy $(, $limit)*));
            return Err($document.inconsistent($key, $others, problem, remedy));
        }
    }};
}

pub(super) use ensure;

/// Part of a message that suggests a similar name.
pub(super) fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!(" (did you mean `{name}`?)"))
}

/// Minimum similarity (0 to 1) of a suggestion; a less similar name does not help the user.
const CLOSE: f64 = 0.5;

/// Returns the most similar candidate.
pub(super) fn nearest<'c>(
    word: &str,
    candidates: impl IntoIterator<Item = &'c str>,
) -> Option<&'c str> {
    most_alike(candidates, CLOSE, |candidate| {
        strsim::normalized_damerau_levenshtein(word, candidate)
    })
}

/// Returns the most similar path of a key or a table, by its name. Without a table, or in the same table, it may be less
/// similar.
pub(super) fn nearest_path<'c>(
    path: &str,
    candidates: impl IntoIterator<Item = &'c str>,
) -> Option<&'c str> {
    /// Credit for the same table.
    const SAME: f64 = 0.25;

    let (table, name) = split(path);
    let least = CLOSE + if table.is_empty() { 0.0 } else { SAME };
    most_alike(candidates, least, |candidate| {
        let (other, candidate) = split(candidate);
        let credit = if other == table { SAME } else { 0.0 };
        strsim::normalized_damerau_levenshtein(name, candidate) + credit
    })
}

/// The first of the candidates with the largest likeness, if that is at least `least`.
fn most_alike<'c>(
    candidates: impl IntoIterator<Item = &'c str>,
    least: f64,
    likeness: impl Fn(&str) -> f64,
) -> Option<&'c str> {
    let alike = candidates.into_iter().map(|name| (likeness(name), name));
    // Of equally alike names the first.
    let close = alike.filter(|(likeness, _)| *likeness >= least);
    Some(close.min_by(|a, b| b.0.total_cmp(&a.0))?.1)
}
