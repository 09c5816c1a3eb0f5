//! Arrays: one of NumPy, or several in an archive of NumPy; files of MATLAB are converted to one.
//!
//! Of an array with two axes, the longer one is the time.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use super::clock::Timing;
use super::table::{Buffer, ColumnHeader, Source, check_column_count};
use super::{Problem, units};
use crate::memory;
use crate::numpy::{ArrayReader, Npz};

/// Names of a number with the sample rate.
const RATES: [&str; 3] = ["rate", "fs", "sample_rate"];

/// A file of arrays.
pub(super) enum Container<R> {
    /// One array of NumPy, with its name.
    Npy(R, String),
    /// Named arrays of NumPy.
    Npz(Npz<R>),
}

impl<R: Read + Seek> Container<R> {
    /// Names of the arrays.
    fn names(&self) -> Vec<String> {
        match self {
            Self::Npy(_, stem) => vec![stem.clone()],
            Self::Npz(archive) => archive.names(),
        }
    }

    /// Opens an array at its first value.
    fn array(&mut self, name: &str) -> Result<ArrayReader<'_>, Problem> {
        match self {
            Self::Npy(content, _) => {
                let length = content.seek(SeekFrom::End(0))?;
                content.rewind()?;
                ArrayReader::open(content, name, length)
            }
            Self::Npz(archive) => archive.reader(name)?.ok_or_else(Problem::changed),
        }
    }
}

/// Arrays as columns.
pub(super) struct Arrays<R> {
    container: Container<R>,
    columns: Vec<ArrayColumn>,
    /// Name and unit (s) of the array of times.
    times: Option<(String, f64)>,
    rate: Option<f64>,
}

/// A column of an array.
struct ArrayColumn {
    header: ColumnHeader,
    /// Name of the array.
    array: String,
    /// Number of samples.
    length: usize,
    /// Place of the first sample in the array, and distance between samples.
    start: usize,
    step: usize,
}

impl<R: Read + Seek> Arrays<R> {
    pub fn open(mut container: Container<R>) -> Result<Self, Problem> {
        let is_archive = !matches!(container, Container::Npy(..));
        let (mut columns, mut times, mut rate) = (Vec::new(), None, None);
        for name in container.names() {
            let mut array = container.array(&name)?;
            let (bare, unit) = units::split(&name);
            let second = units::seconds(unit).filter(|_| units::is_time(bare));
            match (array.shape.len(), second) {
                (1, Some(second)) if is_archive => times = Some((name, second)),
                (0, _) if RATES.contains(&&*name) && rate.is_none() => {
                    rate = array.next().transpose()?;
                }
                _ => columns.extend(columns_of(&array, &name, is_archive)?),
            }
            check_column_count(columns.len())?;
        }
        if columns.is_empty() {
            return Err(Problem::no_samples("no array of real numbers"));
        }
        Ok(Self {
            container,
            columns,
            times,
            rate,
        })
    }
}

impl<R: Read + Seek> Source for Arrays<R> {
    fn headings(&self) -> Vec<ColumnHeader> {
        let columns = self.columns.iter();
        columns.map(|column| column.header.clone()).collect()
    }

    fn clock(&mut self, column: usize) -> Result<(Timing, usize), Problem> {
        let timing = match (&self.times, self.rate) {
            (Some((name, second)), _) => {
                let array = self.container.array(name)?;
                let relative = array.rounding;
                let mut times = memory::allocate(array.total)
                    .map_err(|shortage| Problem::too_large(name, shortage))?;
                for time in array {
                    times.push(second * time?);
                }
                Timing::Times {
                    times: Arc::new(times),
                    resolution: 0.0,
                    relative,
                }
            }
            (None, rate) => Timing::Rate(rate),
        };
        Ok((timing, self.columns[column].length))
    }

    fn samples(&mut self, column: usize, range: Range<usize>, into: Buffer) -> Result<(), Problem> {
        let ArrayColumn {
            array, start, step, ..
        } = &self.columns[column];
        // An archive is read to its end, where its checksum is compared.
        let end = match &self.container {
            Container::Npz(_) => usize::MAX,
            Container::Npy(..) => start + range.end * step,
        };
        let mut wanted = range.map(|sample| start + sample * step).peekable();
        let values = self.container.array(array)?;
        for (place, number) in values.enumerate().take(end) {
            let number = number?;
            if wanted.next_if_eq(&place).is_some() {
                into.push(number);
            }
        }
        Ok(())
    }
}

/// The columns of an array, none of a single number: a single axis is one column; with two axes, the longer one is the
/// time.
fn columns_of(
    array: &ArrayReader<'_>,
    name: &str,
    is_archive: bool,
) -> Result<impl Iterator<Item = ArrayColumn> + use<>, Problem> {
    if array.shape.contains(&0) {
        return Err(Problem::no_samples("an empty array"));
    }
    let (count, length, along_rows) = match array.shape[..] {
        [] => (0, 1, true),
        [length] => (1, length, true),
        [rows, places] => (rows.min(places), rows.max(places), rows >= places),
        _ => {
            return Err(Problem::unsupported(
                format!("an array of {} axes", array.shape.len()),
                "save a single column, or several columns in a two-dimensional array",
            ));
        }
    };
    check_column_count(count)?;
    // Whether the samples of one instant are adjacent, rather than those of one column.
    let is_interleaved = along_rows != array.fortran;
    let (is_lone, name) = (array.shape.len() == 1, name.to_owned());
    Ok((0..count).map(move |k| ArrayColumn {
        header: ColumnHeader::new(match (is_lone, is_archive) {
            (true, _) => name.clone(),
            (false, true) => format!("{name}[{k}]"),
            (false, false) => k.to_string(),
        }),
        array: name.clone(),
        length,
        start: if is_interleaved { k } else { k * length },
        step: if is_interleaved { count } else { 1 },
    }))
}
