//! Errors of signal files.

use std::fmt::Write as _;
use std::io;
use std::path::PathBuf;

use crate::memory::MemoryShortage;

/// Known formats, for messages.
const KNOWN: &str =
    "WAV, FLAC, MP3, Ogg, AIFF, CSV (or other columns of text), .npy, .npz, .mat, .rrd";

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
    /// The file has no content.
    #[error("the file is empty; record or export it again")]
    Empty,
    /// The content has no known format.
    #[error("unknown file format{}; convert the file to one of: {KNOWN}", called.as_deref().map_or(String::new(), |e| format!(" (the extension is .{e}, but the content is different)")))]
    UnknownFormat {
        /// The extension, if it is that of a known format.
        called: Option<String>,
    },
    /// A recording, which needs another feature.
    #[error(
        "the file is a recording (.rrd), which this build cannot read; build with the feature `record`, or export the column as CSV"
    )]
    Recording,
    /// The content violates its format.
    #[error("the {format} file is damaged: {what}; export it again")]
    Damaged {
        /// The format.
        format: &'static str,
        /// The violation.
        what: String,
    },
    /// The file is truncated.
    #[error(
        "the {format} file is truncated: {what} has {have} of {need} bytes; copy or record it again"
    )]
    Truncated {
        /// The format.
        format: &'static str,
        /// The truncated part.
        what: String,
        /// Bytes present.
        have: u64,
        /// Bytes announced.
        need: u64,
    },
    /// The coding of the samples is not supported.
    #[error("{what} is not supported; {remedy}")]
    Unsupported {
        /// The unsupported coding.
        what: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// A row with another number of fields than the first one.
    #[error("line {line} has {have} fields instead of {need}; complete or remove it")]
    Ragged {
        /// Line, from 1.
        line: u64,
        /// Number of fields in this line.
        have: usize,
        /// Number of fields in the first row.
        need: usize,
    },
    /// A line of text that is too long for a row of samples.
    #[error(
        "line {line} is longer than {most} bytes; check that the file is text with one row of samples per line"
    )]
    LongLine {
        /// Line, from 1.
        line: u64,
        /// Maximum length, bytes.
        most: usize,
    },
    /// Too many columns.
    #[error("the file has {have} columns; the maximum is {most}; save fewer")]
    TooManyColumns {
        /// Number of columns.
        have: usize,
        /// Maximum number.
        most: usize,
    },
    /// The selection has too many samples.
    #[error(
        "the selection has {have} samples, more than the limit of {most}; select a shorter part with --from and --to, or raise the limit with --max-samples"
    )]
    TooManySamples {
        /// Number of samples.
        have: usize,
        /// The limit.
        most: usize,
    },
    /// The selected samples do not fit into memory.
    #[error(
        "the {samples} selected samples do not fit into memory: {shortage}; select a shorter part with --from and --to"
    )]
    Memory {
        /// Number of samples.
        samples: usize,
        /// Missing memory.
        shortage: MemoryShortage,
    },
    /// The file changed between two passes.
    #[error("the file changed while it was read; wait until it is complete, and try again")]
    Changed,
    /// Text instead of a number.
    #[error(
        "line {line}, column `{column}`: `{text}` is not a number; correct the line, or start it with # if it is a comment"
    )]
    NotANumber {
        /// Line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// Content of the field.
        text: String,
    },
    /// The file contains no sample.
    #[error("the file contains no sample, only {0}; export it again")]
    NoSamples(&'static str),
    /// Several columns without a selection.
    #[error(
        "the file has several columns; choose one with --column: {}",
        listed(columns)
    )]
    ChooseColumn {
        /// Their names.
        columns: Vec<String>,
    },
    /// The selected column does not exist.
    #[error("there is no column `{asked}`; choose one of: {}", listed(columns))]
    NoSuchColumn {
        /// Requested name.
        asked: String,
        /// Existing names.
        columns: Vec<String>,
    },
    /// Times that do not increase, or that are not numbers.
    #[error(
        "the time does not increase: sample {index} is at {time} s, the previous one at {before} s; correct the times, or remove them and give --rate"
    )]
    NotIncreasing {
        /// Index of the sample, from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Previous time, s.
        before: f64,
    },
    /// Times that are not evenly spaced.
    #[error(
        "the samples are not evenly spaced in time: sample {index} is at {time} s, {off:.3} sample spacings from its nominal time; resample the signal, or remove the times and give --rate"
    )]
    NotUniform {
        /// Index of the sample, from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Deviation, in sample spacings.
        off: f64,
    },
    /// Different numbers of times and samples.
    #[error("{times} times for {samples} samples of `{column}`; export the file again")]
    CountMismatch {
        /// Name of the column.
        column: String,
        /// Number of times.
        times: usize,
        /// Number of samples.
        samples: usize,
    },
    /// No sample rate.
    #[error("the file does not contain the sample rate; give it with --rate HZ")]
    NoRate,
    /// An invalid rate.
    #[error("the sample rate {0} Hz is invalid; give a rate from 1e-12 to 1e15 Hz with --rate HZ")]
    InvalidRate(f64),
    /// The given rate contradicts the file.
    #[error("the file has a sample rate of {own} Hz, not {asked} Hz; omit --rate")]
    RateMismatch {
        /// Given rate, Hz.
        asked: f64,
        /// Rate of the file, Hz.
        own: f64,
    },
    /// An empty time range.
    #[error(
        "--from {from} s is not before --to {to} s; give a range within the file, from {first} to {last} s"
    )]
    EmptyRange {
        /// Given start, s.
        from: f64,
        /// Given end, s.
        to: f64,
        /// Start of the file, s.
        first: f64,
        /// End of the file, s.
        last: f64,
    },
    /// A time range outside the file.
    #[error("{option} {asked} s is outside the file, which extends from {first} to {last} s")]
    Outside {
        /// `--from` or `--to`.
        option: &'static str,
        /// Given time, s.
        asked: f64,
        /// Start of the file, s.
        first: f64,
        /// End of the file, s.
        last: f64,
    },
    /// A sample that is not finite, or whose square overflows.
    #[error(
        "sample {index} (at {time} s) of `{column}` is {value:e}; samples are finite numbers below 1e150: exclude it with --from and --to, or correct it"
    )]
    InvalidSample {
        /// Index of the sample in the file, from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Name of the column.
        column: String,
        /// Value.
        value: f64,
    },
}

/// Names separated by commas; a long list is shortened.
fn listed(names: &[String]) -> String {
    const SHOWN: usize = 16;
    let mut text = names
        .iter()
        .take(SHOWN)
        .map(String::as_str)
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > SHOWN {
        let _ = write!(text, " and {} more", names.len() - SHOWN);
    }
    text
}
