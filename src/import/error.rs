//! Errors of signal files.

use std::fmt::Display;
use std::io;
use std::path::PathBuf;

/// A file does not contain a signal.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct ImportError {
    /// The file.
    pub path: PathBuf,
    /// Problem, place and remedy.
    pub problem: Problem,
}

/// Problem of a file or of the selection.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file cannot be opened or read.
    #[error(
        "cannot read the file ({0}); check its path and permissions, and copy the data of a pipe or a device to a file"
    )]
    Unreadable(#[from] io::Error),
    /// The content is not a signal, or the selection does not fit it: what, where, and the remedy.
    #[error("{0}")]
    Content(String),
}

impl Problem {
    /// The content violates its format.
    pub(super) fn damaged(format: &str, what: impl Display) -> Self {
        Self::Content(format!(
            "the {format} file is damaged: {what}; export it again"
        ))
    }

    /// A part of the file has `have` of the `need` bytes that are announced.
    pub(super) fn truncated(format: &str, what: impl Display, have: u64, need: u64) -> Self {
        Self::Content(format!(
            "the {format} file is truncated: {what} has {have} of {need} bytes; copy or record it again"
        ))
    }

    /// A coding that is not supported.
    pub(super) fn unsupported(what: impl Display, remedy: &str) -> Self {
        Self::Content(format!("{what} is not supported; {remedy}"))
    }

    /// A file that contains something, but no sample.
    pub(super) fn no_samples(content: &str) -> Self {
        Self::Content(format!(
            "the file contains no sample, only {content}; export it again"
        ))
    }

    /// A file without times and without a sample rate.
    pub(super) fn no_rate() -> Self {
        Self::Content(
            "the file does not contain the sample rate; give it with --rate HZ".to_owned(),
        )
    }

    /// A file that changed between two passes.
    pub(super) fn changed() -> Self {
        let text = "the file changed while it was read; wait until it is complete, and try again";
        Self::Content(text.to_owned())
    }

    /// Text instead of a number.
    pub(super) fn not_a_number(line: u64, column: &str, text: &str) -> Self {
        Self::Content(format!(
            "line {line}, column `{column}`: `{text}` is not a number; correct the line, start it with # if it is a \
             comment, or skip the lines up to it with --skip-lines N"
        ))
    }
}
