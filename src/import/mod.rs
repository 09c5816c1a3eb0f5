//! Signals from files.
//!
//! | format | columns | clock |
//! |---|---|---|
//! | WAV: PCM of 8 to 32 bits, float of 32 or 64 bits, any number of channels | `left`, `right`; of more channels `0`, `1`, ...; full scale is 1 FS | the header |
//! | FLAC, MP3, Ogg Vorbis, AIFF | as WAV | the header |
//! | CSV and similar formats: fields separated by `,` `;` tab or blanks; with or without a header; `#` comments; decimal commas unless commas separate the fields | by header or by index, from 0 | a column named `t`, `time`, `zeit`, ... (unit in its name, else s), or the first column if it increases uniformly |
//! | `.npy`: integers and floats of any size and byte order, one or two axes | by index along the shorter axis | none |
//! | `.npz`: several of these, compressed or not | by name; for two axes `name[0]`, `name[1]`, ... | an array `t` or `time`, or a number `rate`, `fs` or `sample_rate` |
//! | MATLAB `.mat` up to version 7: real numeric arrays of one or two axes | as `.npz` | as `.npz` |
//!
//! The format is detected from the content, not from the file name. Recordings (`.rrd`) are read by the
//! module `record`, which passes their columns as a [`Table`].
//!
//! All checks are here: a [`Signal`] is finite and uniformly sampled.
//!
//! # Memory
//!
//! Files are read in blocks, except MATLAB files, which are read as a whole. Only the selected samples are stored, 8 bytes each, plus a few MB for any file.
//! A file may therefore be much larger than the memory, and a small file cannot claim more memory than it
//! contains:
//!
//! | what | limit |
//! |---|---|
//! | selected samples | [`Selection::max_samples`], default [`MAX_SAMPLES`], and the available memory |
//! | a line of text | 1 MiB |
//! | columns | 16,384; channels of a WAV 65,535 |
//! | the header of an array | 65,535 bytes |
//!
//! A value above a limit is rejected with both numbers before memory is allocated. A file is read several
//! times; therefore pipes and devices are rejected.

mod clock;
mod compressed;
mod error;
mod format;
mod lines;
mod mat;
mod npy;
mod preamble;
mod signal;
mod table;
mod text;
mod units;
mod wav;

use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

pub use error::{ImportError, Problem};
pub use format::Format;
pub use signal::{MAX_SAMPLES, Selection, Signal};
pub use table::Table;

/// Reads a signal from a file.
///
/// # Errors
/// If the file cannot be read, has no known [`Format`], or does not contain the selection: [`Problem`] gives
/// the place and the remedy.
pub fn read_signal(path: &Path, selection: &Selection) -> Result<Signal, ImportError> {
    read_signal_with(path, selection, &mut |_| ())
}

/// As [`read_signal`] with progress reports: `progress` receives the fraction of the file, 0 to 1, that the
/// present pass has read. A file is read up to six times, text with a clock most often.
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
    let file = format::Reported::open(path, progress)?;
    decode(
        BufReader::with_capacity(format::BLOCK, file),
        path,
        selection,
    )
}

/// Decodes a signal. The name of a single column is the stem of `path`.
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
        Format::Sound => table::read(&mut compressed::Compressed::open(path, &stem)?, selection),
        Format::Mat => table::read(&mut mat::read(content)?, selection),
        Format::Rrd => Err(Problem::Content(
            "the file is a recording (.rrd), which this build cannot read; build with the feature `record`, or export \
             the column as CSV"
                .to_owned(),
        )),
    }
}

#[cfg(test)]
mod array_tests;
#[cfg(test)]
mod formats_tests;
#[cfg(test)]
mod limits_tests;
#[cfg(test)]
mod tests;
