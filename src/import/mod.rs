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

mod clock;
mod error;
mod format;
mod npy;
mod table;
mod text;
mod units;
mod wav;

use std::path::Path;

pub use clock::Clock;
pub use error::{ImportError, Problem};
pub use format::Format;
pub use table::{Column, Table};

/// A signal: uniform samples with a name and a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Name of the column or channel, or of the file.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// Samples a second, Hz.
    pub rate: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// The samples, finite.
    pub samples: Vec<f64>,
}

impl Signal {
    /// Time of a sample, s.
    pub fn time(&self, index: usize) -> f64 {
        self.start + index as f64 / self.rate
    }

    /// How long it lasts: samples over rate, s.
    pub fn duration(&self) -> f64 {
        self.samples.len() as f64 / self.rate
    }
}

/// Which part of a file to read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Column or channel, by name or by place from 0; may be left out where there is only one.
    pub column: Option<String>,
    /// Samples a second, Hz, for a file without a clock.
    pub rate: Option<f64>,
    /// Samples before this time of the file (s) are left out.
    pub from: Option<f64>,
    /// Samples at this time of the file (s) and after it are left out.
    pub to: Option<f64>,
}

/// Reads a signal from a file.
///
/// # Errors
/// If the file cannot be read, is of no known [`Format`], or does not hold what is asked for:
/// [`Problem`] tells file, place and remedy.
pub fn read_signal(path: &Path, selection: &Selection) -> Result<Signal, ImportError> {
    read(path, selection).map_err(|problem| ImportError {
        path: path.to_owned(),
        problem,
    })
}

fn read(path: &Path, selection: &Selection) -> Result<Signal, Problem> {
    let bytes = format::bytes(path)?;
    let table = decode(&bytes, path)?;
    table.signal(selection)
}

/// All columns of a file's content; `path` gives a lone column its name.
fn decode(bytes: &[u8], path: &Path) -> Result<Table, Problem> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    match Format::of_bytes(bytes, path)? {
        Format::Wav => wav::decode(bytes, &stem),
        Format::Text => text::decode(bytes, &stem),
        Format::Npy => npy::decode_npy(bytes, &stem),
        Format::Npz => npy::decode_npz(bytes),
        Format::Rrd => Err(Problem::Recording),
    }
}

#[cfg(test)]
mod tests;
