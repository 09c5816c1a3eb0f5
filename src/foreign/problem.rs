//! Why a file cannot be read.

use std::fmt::Display;
use std::io;

/// Problem of a file, or of what is selected in it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file cannot be opened or read.
    #[error(
        "cannot read the file ({0}); check its path and permissions, and copy the data of a pipe or a device to a file"
    )]
    Unreadable(#[from] io::Error),
    /// The content is not what it should be, or the selection does not fit it: what, where, and the remedy.
    #[error("{0}")]
    Content(String),
    /// A text without a row of numbers, which is no signal.
    #[error("the file contains no sample, only headings or comments; export it again")]
    NoNumbers,
}

impl Problem {
    /// The content violates its format.
    pub(crate) fn damaged(format: &str, what: impl Display) -> Self {
        Self::Content(format!(
            "the {format} file is damaged: {what}; export it again"
        ))
    }

    /// A part of the file has `have` of the `need` bytes that are announced.
    pub(crate) fn truncated(format: &str, what: impl Display, have: u64, need: u64) -> Self {
        Self::Content(format!(
            "the {format} file is truncated: {what} has {have} of {need} bytes; copy or record it again"
        ))
    }

    /// An array for which there is not enough memory.
    pub(crate) fn too_large(array: &str, shortage: impl Display) -> Self {
        Self::Content(format!(
            "the array `{array}`: {shortage}; save fewer numbers"
        ))
    }

    /// A coding that is not supported.
    pub(crate) fn unsupported(what: impl Display, remedy: &str) -> Self {
        Self::Content(format!("{what} is not supported; {remedy}"))
    }

    /// A file that contains something, but no sample.
    pub(crate) fn no_samples(content: &str) -> Self {
        Self::Content(format!(
            "the file contains no sample, only {content}; export it again"
        ))
    }

    /// A file without times and without a sample rate.
    pub(crate) fn no_rate() -> Self {
        Self::Content(
            "the file does not contain the sample rate; give it with --rate HZ".to_owned(),
        )
    }

    /// A file that changed between two passes.
    pub(crate) fn changed() -> Self {
        let text = "the file changed while it was read; wait until it is complete, and try again";
        Self::Content(text.to_owned())
    }

    /// Text instead of a number; only its start is shown.
    pub(crate) fn not_a_number(line: u64, column: &str, text: &str) -> Self {
        Self::Content(format!(
            "line {line}, column `{column}`: `{}` is not a number; correct the line, start it with # if it is a \
             comment, or skip the lines up to it with --skip-lines N",
            shortened(text)
        ))
    }
}

/// Start of a text, for a message.
pub(crate) fn shortened(text: &str) -> String {
    const MOST: usize = 30;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
