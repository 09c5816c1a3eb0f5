//! Signals from files.
//!
//! | format | columns | clock |
//! |---|---|---|
//! | WAV: PCM of 8 to 32 bits, float of 32 or 64 bits, A-law, mu-law, ADPCM, any number of channels | `left`, `right`; of more channels `0`, `1`, ...; full scale is 1 FS | the header |
//! | AIFF, FLAC, MP3, AAC alone or in MP4, Ogg Vorbis and Opus | as WAV | the header |
//! | universal files: time histories of dataset 58 | by node and direction | the header of each, or its times |
//! | CSV and similar formats: fields separated by `,` `;` tab or blanks; with or without titles, a header and a row of units; `#` comments; decimal points or commas; UTF-8, UTF-16, Latin-1 | by header or by index, from 0 | a column named `t`, `time`, `zeit`, ... (unit in its name, else s), or the first column if it increases uniformly |
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
//! Sound and arrays are read in blocks, and only the selected samples are stored, 8 bytes each, plus a few MB for any
//! file and 8 bytes for each of the times of an archive: a sound may be much larger than the memory. A text is read once,
//! and the times and the selected column are stored. MATLAB and universal files and UTF-16 are read as a whole. A small
//! file cannot claim more memory than it contains:
//!
//! | what | limit |
//! |---|---|
//! | selected samples | [`Selection::max_samples`], default [`MAX_SAMPLES`], and the available memory |
//! | a line of text | 1 MiB |
//! | columns | 16,384; channels of a WAV 65,535 |
//! | the header of an array | 65,535 bytes |
//!
//! A value above a limit is rejected with both numbers before memory is allocated. The beginning of
//! a file is read more than once; therefore pipes and devices are rejected.

mod clock;
mod format;
mod labels;
mod lines;
mod mat;
mod npy;
mod preamble;
mod signal;
mod sound;
mod table;
mod text;
mod uff;
mod units;
mod wav;

use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::{Path, PathBuf};

pub use crate::foreign::Problem;
pub use format::Format;
pub use labels::{Label, LabelError};
use npy::{Arrays, Container};
pub use signal::{MAX_SAMPLES, Selection, Signal};
use sound::Sound;
pub use table::Table;
use table::{ColumnHeader, Source};
use text::Text;

use crate::foreign::open_file;
use crate::numpy::Npz;

/// A file does not contain a signal.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct ImportError {
    /// The file.
    pub path: PathBuf,
    /// Problem, place and remedy.
    pub problem: Problem,
}

/// Reads a signal from a file.
///
/// # Errors
/// If the file cannot be read, has no known [`Format`], or does not contain the selection: [`Problem`] gives
/// the place and the remedy.
pub fn read_signal(path: &Path, selection: &Selection) -> Result<Signal, ImportError> {
    read_signal_with(path, selection, &mut |_| ())
}

/// As [`read_signal`]. Of a damaged file the samples before the damage are read, and `warn` receives the damage.
///
/// # Errors
/// As [`read_signal`].
pub fn read_signal_with(
    path: &Path,
    selection: &Selection,
    warn: &mut dyn FnMut(&str),
) -> Result<Signal, ImportError> {
    with_source(path, selection.skip_lines, |source| {
        if let Some(damage) = source.damage() {
            warn(damage);
        }
        table::read(source, selection)
    })
}

/// The columns or channels of a file, for [`Selection::column`]: their names, or indices where a name is not unique. The
/// first `skipped` lines of a text are left out.
///
/// # Errors
/// If the file cannot be read or has no known [`Format`].
pub fn channels(path: &Path, skipped: u64) -> Result<Vec<String>, ImportError> {
    let headings = with_source(path, skipped, |source| Ok(source.headings()))?;
    let names = headings.iter().enumerate().map(|(place, column)| {
        let is_same = |other: &&ColumnHeader| other.header == column.header;
        if headings.iter().filter(is_same).count() == 1 {
            column.header.clone()
        } else {
            place.to_string()
        }
    });
    Ok(names.collect())
}

/// Why something in a directory is no signal; `None` if it may be one. Of a text the first lines are ignored.
pub fn why_no_signal(entry: &Path, skipped_lines: u64) -> Option<String> {
    if entry.is_dir() {
        return Some("a directory; give its path, too, if it has signals".to_owned());
    }
    let name = entry.file_name().unwrap_or_default();
    if name.to_string_lossy().starts_with('.') {
        return Some("a hidden file".to_owned());
    }
    // A damaged file is a signal that cannot be analysed, such as an empty file, or text, named .wav.
    if Format::ending(entry).is_some_and(|ending| ending != "txt") {
        return None;
    }
    match Format::of(entry) {
        Ok(Format::Text) => {
            let problem = channels(entry, skipped_lines).err()?.problem;
            matches!(problem, Problem::NoNumbers)
                .then(|| "a text without numbers in its first lines".to_owned())
        }
        Ok(_) => None,
        Err(problem) => Some(problem.to_string()),
    }
}

/// Opens a file and reads from its columns.
fn with_source<T>(
    path: &Path,
    skipped: u64,
    read: impl FnOnce(&mut dyn Source) -> Result<T, Problem>,
) -> Result<T, ImportError> {
    let attempt = || {
        let mut content = BufReader::with_capacity(format::BLOCK, open_file(path)?.0);
        let format = Format::of_content(&mut content, path)?;
        read(&mut *source(content, path, format, skipped)?)
    };
    attempt().map_err(|problem| ImportError {
        path: path.to_owned(),
        problem,
    })
}

/// The columns of a content. The name of a single column is the stem of `path`.
fn source<'a>(
    mut content: impl BufRead + Seek + 'a,
    path: &Path,
    format: Format,
    skipped: u64,
) -> Result<Box<dyn Source + 'a>, Problem> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(match format {
        Format::Sound => Box::new(Sound::open(path, &stem)?),
        Format::Text => match lines::from_utf16(&mut content)? {
            Some(text) => Box::new(Text::open(Cursor::new(text), &stem, skipped)?),
            None => Box::new(Text::open(content, &stem, skipped)?),
        },
        Format::Npy => Box::new(Arrays::open(Container::Npy(content, stem.into_owned()))?),
        Format::Npz => Box::new(Arrays::open(Container::Npz(Npz::new(content)?))?),
        Format::Mat => Box::new(Arrays::open(Container::Npz(mat::read(content)?))?),
        Format::Universal => Box::new(uff::read(content)?),
        Format::Rrd => {
            return Err(Problem::Content(
                "the file is a recording (.rrd), which this build cannot read; build with the feature `record`, or export \
                 the column as CSV"
                    .to_owned(),
            ));
        }
    })
}

#[cfg(test)]
mod array_tests;
#[cfg(test)]
mod formats_tests;
#[cfg(test)]
mod limits_tests;
#[cfg(test)]
mod tests;
