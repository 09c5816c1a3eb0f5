//! Signals from files that somebody else made.
//!
//! | format | columns | clock |
//! |---|---|---|
//! | WAV: PCM of 8 to 32 bits, float of 32 or 64 bits, any number of channels | `left`, `right`; of more channels `0`, `1`, ...; full scale is 1 FS | the header |
//! | CSV and its relatives: fields parted by `,` `;` tab or blanks; header or none; `#` comments; decimal commas unless commas part the fields | by header or by place, from 0 | a column named `t`, `time`, `zeit`, ... (unit in its name, else s), or the first if it rises uniformly |
//! | `.npy`: integers and floats of any size and byte order, one or two axes | by place along the shorter axis | none |
//! | `.npz`: several of these, compressed or not | by name; of two axes `name[0]`, `name[1]`, ... | an array `t` or `time`, or a number `rate`, `fs` or `sample_rate` |
//!
//! The format is told from the content, not from the file's name. Recordings (`.rrd`) are read by
//! the room that knows them; [`Table`] takes what it finds.
//!
//! Everything is checked here, once: a [`Signal`] is finite and uniform in time.
//!
//! # Memory
//!
//! Files are read in blocks, and nothing is held but the samples selected: 8 bytes each, however few they
//! have in the file or in its archive, and a few MB whatever the file. So a file may be far larger than the
//! memory, and a small one may not claim it:
//!
//! | what | limit |
//! |---|---|
//! | samples selected | [`Selection::max_samples`], [`MAX_SAMPLES`] if not given, and what memory is available |
//! | a line of text | 1 MiB |
//! | columns | 16,384; channels of a WAV 65,535 |
//! | the header of an array | 65,535 bytes |
//!
//! What is above a limit is refused with both numbers before it is held. A file is gone through several
//! times, so that pipes and devices are refused.

mod clock;
mod error;
mod format;
mod npy;
mod signal;
mod table;
mod text;
mod units;
mod wav;

use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

pub use clock::Clock;
pub use error::{ImportError, Problem};
pub use format::Format;
pub use signal::{MAX_SAMPLES, Selection, Signal};
pub use table::{Column, Table};

/// Reads a signal from a file.
///
/// # Errors
/// If the file cannot be read, is of no known [`Format`], or does not hold what is asked for:
/// [`Problem`] says place and remedy.
pub fn read_signal(path: &Path, selection: &Selection) -> Result<Signal, ImportError> {
    read_signal_with(path, selection, &mut |_| ())
}

/// The same; `progress` gets the share of the file, 0 to 1, that this pass through it has read. A file is
/// read up to six times: text with a clock most often.
///
/// # Errors
/// As [`read_signal`].
pub fn read_signal_with(
    path: &Path,
    selection: &Selection,
    progress: &mut dyn FnMut(f64),
) -> Result<Signal, ImportError> {
    read(path, selection, progress).map_err(|problem| ImportError {
        path: path.to_owned(),
        problem,
    })
}

fn read(
    path: &Path,
    selection: &Selection,
    progress: &mut dyn FnMut(f64),
) -> Result<Signal, Problem> {
    let file = format::Reported::new(format::open(path)?, progress)?;
    decode(
        BufReader::with_capacity(format::BLOCK, file),
        path,
        selection,
    )
}

/// The signal in a content; `path` gives a lone column its name.
fn decode(
    mut content: impl BufRead + Seek,
    path: &Path,
    selection: &Selection,
) -> Result<Signal, Problem> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    match Format::of_content(&mut content, path)? {
        Format::Wav => table::read(&mut wav::Wav::open(content, &stem)?, selection),
        Format::Text => table::read(&mut text::Text::open(content, &stem)?, selection),
        Format::Npy => table::read(&mut npy::Npy::open(content, &stem)?, selection),
        Format::Npz => table::read(&mut npy::Npz::open(content)?, selection),
        Format::Rrd => Err(Problem::Recording),
    }
}

#[cfg(test)]
mod array_tests;
#[cfg(test)]
mod limits_tests;
#[cfg(test)]
mod tests;
