//! What can be wrong with somebody else's file.

use std::fmt::Write as _;
use std::io;
use std::path::PathBuf;

use crate::memory::MemoryShortage;

/// The formats, for messages.
const KNOWN: &str = "WAV, CSV (or other columns of text), .npy, .npz, .rrd";

/// Why a file gives no signal.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct ImportError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, where, and what to do.
    pub problem: Problem,
}

/// What is wrong with a file, or with what is asked of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// There is no such file.
    #[error("there is no such file; check the path")]
    Missing,
    /// It is a directory.
    #[error("this is a directory; give the path of a file in it")]
    Directory,
    /// The path is that of a device, a pipe or a socket.
    #[error(
        "this is a device or a pipe, which cannot be read twice and may never end; copy it into a file"
    )]
    Device,
    /// The system does not let it be read.
    #[error("the file cannot be read ({0}); check its permissions")]
    Unreadable(#[from] io::Error),
    /// No byte in it.
    #[error("the file is empty; record or export it again")]
    Empty,
    /// Its content fits no known format.
    #[error("its format is unknown{}; convert it to one of: {KNOWN}", called.as_deref().map_or(String::new(), |e| format!(" (it is called .{e}, but its content is something else)")))]
    UnknownFormat {
        /// Its extension, if that is the one of a known format.
        called: Option<String>,
    },
    /// It is a recording, which another room reads.
    #[error(
        "this is a recording (.rrd), which this build cannot read; build with the feature `record`, or export the column as CSV"
    )]
    Recording,
    /// It does not follow its format.
    #[error("this {format} file is damaged: {what}; export it again")]
    Damaged {
        /// The format.
        format: &'static str,
        /// What does not fit.
        what: String,
    },
    /// It ends before its time.
    #[error(
        "this {format} file is cut short: {what} has {have} bytes where {need} are announced; copy or record it again"
    )]
    CutShort {
        /// The format.
        format: &'static str,
        /// Which part.
        what: String,
        /// Bytes there.
        have: u64,
        /// Bytes announced.
        need: u64,
    },
    /// Its samples are coded in a way that is not read.
    #[error("{what} is not read here; {remedy}")]
    Unsupported {
        /// What it is.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A row of other length than the first.
    #[error(
        "line {line} has {have} fields where the lines before it have {need}; complete or remove it"
    )]
    Ragged {
        /// Line, from 1.
        line: u64,
        /// Fields there.
        have: usize,
        /// Fields of the first row.
        need: usize,
    },
    /// A line of text that is no row of samples.
    #[error(
        "line {line} is longer than {most} bytes; check that this is text with one row of samples a line"
    )]
    LongLine {
        /// Line, from 1.
        line: u64,
        /// The longest that is read, bytes.
        most: usize,
    },
    /// More columns than anything measures.
    #[error("there are {have} columns, and {most} are read; save fewer")]
    TooManyColumns {
        /// How many.
        have: usize,
        /// The most that are read.
        most: usize,
    },
    /// More samples than are to be read.
    #[error(
        "{have} samples are selected, above the limit of {most}; select a stretch with --from and --to, or raise the limit with --max-samples"
    )]
    TooManySamples {
        /// How many.
        have: usize,
        /// The limit.
        most: usize,
    },
    /// More samples than fit into the memory.
    #[error(
        "the {samples} samples selected do not fit into memory: {shortage}; select a stretch with --from and --to"
    )]
    Memory {
        /// How many.
        samples: usize,
        /// By how much.
        shortage: MemoryShortage,
    },
    /// It changed between two passes.
    #[error("the file changed while it was read; wait until it is complete")]
    Changed,
    /// Text where a number ought to be.
    #[error(
        "line {line}, column `{column}`: `{text}` is not a number; correct the line, or put # before it if it is a remark"
    )]
    NotANumber {
        /// Line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// What is there.
        text: String,
    },
    /// Nothing in it is a row of samples.
    #[error("there is no sample in it, only {0}; export it again")]
    NoSamples(&'static str),
    /// Several columns, and none chosen.
    #[error(
        "there are several columns; choose one with --column: {}",
        listed(columns)
    )]
    ChooseColumn {
        /// Their names.
        columns: Vec<String>,
    },
    /// A column that is not there.
    #[error("there is no column `{asked}`; there is: {}", listed(columns))]
    NoSuchColumn {
        /// The name asked for.
        asked: String,
        /// The names there are.
        columns: Vec<String>,
    },
    /// Times that stand still or go back, or are no numbers.
    #[error(
        "time does not go on: sample {index} is at {time} s, the one before at {before} s; repair the times, or give the file without them and with --rate"
    )]
    NotRising {
        /// Index of the sample, from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// The time before, s.
        before: f64,
    },
    /// Times that are not evenly spaced.
    #[error(
        "the samples are not evenly spaced in time: sample {index} is at {time} s, {off:.3} of a sample spacing off its place; resample the signal, or give the file without its times and with --rate"
    )]
    NotUniform {
        /// Index of the sample, from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// How far off, in spacings.
        off: f64,
    },
    /// Times and samples differ in number.
    #[error("there are {times} times for {samples} samples of `{column}`; export it again")]
    UnevenTimes {
        /// Name of the column.
        column: String,
        /// How many times.
        times: usize,
        /// How many samples.
        samples: usize,
    },
    /// No clock.
    #[error("the file does not say how many samples there are a second; say so with --rate HZ")]
    NoRate,
    /// A rate that cannot be.
    #[error(
        "a rate of {0} Hz cannot be; give the number of samples a second, from 1e-12 to 1e15, with --rate HZ"
    )]
    BadRate(f64),
    /// The file's own clock says something else.
    #[error("the file's own clock gives {own} Hz, not {asked} Hz; leave --rate out")]
    OtherRate {
        /// The rate asked for, Hz.
        asked: f64,
        /// The rate of the file, Hz.
        own: f64,
    },
    /// A stretch that ends before it begins, or that is no number.
    #[error(
        "--from {from} s is not before --to {to} s; give a stretch of the file's time, from {first} to {last} s"
    )]
    Backwards {
        /// Begin asked for, s.
        from: f64,
        /// End asked for, s.
        to: f64,
        /// Begin of the file, s.
        first: f64,
        /// End of the file, s.
        last: f64,
    },
    /// A stretch that the file does not have.
    #[error("{option} {asked} s is outside the file, which lasts from {first} to {last} s")]
    Outside {
        /// `--from` or `--to`.
        option: &'static str,
        /// Time asked for, s.
        asked: f64,
        /// Begin of the file, s.
        first: f64,
        /// End of the file, s.
        last: f64,
    },
    /// A sample that is no number.
    #[error(
        "sample {index} (at {time} s) of `{column}` is {value}; cut it out with --from and --to, or repair it"
    )]
    NotFinite {
        /// Index of the sample in the file, from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Name of the column.
        column: String,
        /// `NaN`, `inf` or `-inf`.
        value: f64,
    },
    /// A sample whose square is beyond all numbers.
    #[error(
        "sample {index} (at {time} s) of `{column}` is {value:e}, too large to be squared; give the signal in a larger unit, or cut it out with --from and --to"
    )]
    TooLarge {
        /// Index of the sample in the file, from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Name of the column.
        column: String,
        /// The sample.
        value: f64,
    },
}

/// Names in a row; of many, the first.
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
