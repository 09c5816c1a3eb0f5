//! NumPy arrays, a single one or several in a file.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;

use zip::ZipArchive;
use zip::read::ZipFile;

use super::clock::Timing;
use super::table::{ColumnHeader, Each, Source, check_column_count};
use super::{Problem, units};
use crate::numpy::{ArrayError, ArrayReader};

/// Names of a number with the sample rate.
pub(super) const RATES: [&str; 3] = ["rate", "fs", "sample_rate"];

/// A single array.
pub(super) struct Npy<R> {
    content: R,
    layout: Layout,
    /// Name of a single column.
    stem: String,
}

impl<R: Read + Seek> Npy<R> {
    pub fn open(mut content: R, stem: &str) -> Result<Self, Problem> {
        let layout = Layout::of(&open_file(&mut content, stem)?)?;
        let array = Self {
            content,
            layout,
            stem: stem.to_owned(),
        };
        if array.layout.columns == 0 {
            return Err(Problem::no_samples("a single number"));
        }
        Ok(array)
    }
}

/// Opens the array of a file at its start.
fn open_file<'a, R: Read + Seek>(
    content: &'a mut R,
    name: &str,
) -> Result<ArrayReader<&'a mut R>, Problem> {
    let length = content.seek(SeekFrom::End(0))?;
    content.seek(SeekFrom::Start(0))?;
    ArrayReader::open(content, length).map_err(|p| problem(p, name))
}

impl<R: Read + Seek> Source for Npy<R> {
    fn headings(&self) -> Vec<ColumnHeader> {
        let name = if self.layout.is_lone { &self.stem } else { "" };
        self.layout.headings(name)
    }

    fn timing(&self) -> Timing {
        Timing::Unknown
    }

    fn samples(&mut self, column: usize, range: Range<usize>, each: Each) -> Result<(), Problem> {
        let array = open_file(&mut self.content, &self.stem)?;
        let end = self.layout.index(column, range.end - 1) + 1;
        let read = self.layout.visit(array.take(end), column, range, each);
        read.map_err(|p| problem(p, &self.stem))
    }
}

/// Named arrays.
pub(super) struct Npz<R> {
    zip: ZipArchive<R>,
    /// Arrays with columns.
    arrays: Vec<Entry>,
    /// The array of times with its unit, s.
    times: Option<(Entry, f64)>,
    timing: Timing,
}

/// An array in an archive.
struct Entry {
    index: usize,
    name: String,
    layout: Layout,
}

impl<R: Read + Seek> Npz<R> {
    pub fn open(content: R) -> Result<Self, Problem> {
        let mut zip = ZipArchive::new(content).map_err(archive)?;
        let mut arrays = Vec::new();
        let (mut times, mut timing) = (None, Timing::Unknown);
        let mut columns = 0;
        for index in 0..zip.len() {
            let entry = zip.by_index(index).map_err(archive)?;
            let entry_name = entry.name().to_owned();
            drop(entry);
            let Some(name) = entry_name.strip_suffix(".npy") else {
                continue;
            };
            let mut array = open_entry(&mut zip, index, name)?;
            let (bare, unit) = units::split(name);
            let second = units::seconds(unit).filter(|_| units::is_time(bare));
            let entry = Entry {
                index,
                name: name.to_owned(),
                layout: Layout::of(&array)?,
            };
            match (array.shape().len(), second) {
                (1, Some(second)) => {
                    timing = Timing::Times {
                        count: entry.layout.length,
                        resolution: 0.0,
                        relative: array.rounding(),
                    };
                    times = Some((entry, second));
                }
                (0, _) if RATES.contains(&name) && matches!(timing, Timing::Unknown) => {
                    if let Some(rate) = array.next() {
                        timing = Timing::Rate(rate.map_err(|p| problem(p, name))?);
                    }
                }
                _ => {
                    columns += entry.layout.columns;
                    check_column_count(columns)?;
                    arrays.push(entry);
                }
            }
        }
        if columns == 0 {
            return Err(Problem::no_samples(
                "an archive without an array of samples",
            ));
        }
        Ok(Self {
            zip,
            arrays,
            times,
            timing,
        })
    }
}

/// Opens an array of an archive.
fn open_entry<'a, R: Read + Seek>(
    zip: &'a mut ZipArchive<R>,
    index: usize,
    name: &str,
) -> Result<ArrayReader<ZipFile<'a, R>>, Problem> {
    let entry = zip.by_index(index).map_err(archive)?;
    let length = entry.size();
    ArrayReader::open(entry, length).map_err(|p| problem(p, name))
}

impl<R: Read + Seek> Source for Npz<R> {
    fn headings(&self) -> Vec<ColumnHeader> {
        let headings = |entry: &Entry| entry.layout.headings(&entry.name);
        self.arrays.iter().flat_map(headings).collect()
    }

    fn timing(&self) -> Timing {
        self.timing
    }

    fn times(&mut self, each: Each) -> Result<(), Problem> {
        let Some((entry, second)) = &self.times else {
            return Ok(());
        };
        for time in open_entry(&mut self.zip, entry.index, &entry.name)? {
            each(time.map_err(|p| problem(p, &entry.name))? * second);
        }
        Ok(())
    }

    fn samples(&mut self, column: usize, range: Range<usize>, each: Each) -> Result<(), Problem> {
        let mut column = column;
        for entry in &self.arrays {
            if column < entry.layout.columns {
                let array = open_entry(&mut self.zip, entry.index, &entry.name)?;
                let read = entry.layout.visit(array, column, range, each);
                return read.map_err(|p| problem(p, &entry.name));
            }
            column -= entry.layout.columns;
        }
        Ok(())
    }
}

/// Columns of an array: a single axis is one column; with two axes, the longer one is the time.
struct Layout {
    is_lone: bool,
    /// Number of columns; 0 for a single number.
    columns: usize,
    /// Number of samples per column.
    length: usize,
    /// Whether the samples of one instant are adjacent, rather than those of one column.
    interleaved: bool,
}

impl Layout {
    fn of<R: Read>(array: &ArrayReader<R>) -> Result<Self, Problem> {
        if array.total() == 0 {
            return Err(Problem::no_samples("an empty array"));
        }
        let (columns, length, along_rows) = match *array.shape() {
            [] => (0, 1, true),
            [length] => (1, length, true),
            [rows, places] => (rows.min(places), rows.max(places), rows >= places),
            _ => {
                return Err(Problem::unsupported(
                    format!("an array of {} axes", array.shape().len()),
                    "save a single column, or several columns in a two-dimensional array",
                ));
            }
        };
        check_column_count(columns)?;
        Ok(Self {
            is_lone: array.shape().len() == 1,
            columns,
            length,
            interleaved: along_rows != array.fortran(),
        })
    }

    /// Headings of an array with this name: `name`, or `name[0]`, `name[1]`, ...
    fn headings(&self, name: &str) -> Vec<ColumnHeader> {
        let label = |k: usize| match name {
            name if self.is_lone => name.to_owned(),
            "" => k.to_string(),
            name => format!("{name}[{k}]"),
        };
        let heading = |k| ColumnHeader::new(label(k), self.length);
        (0..self.columns).map(heading).collect()
    }

    /// Index of a sample of a column in the file.
    fn index(&self, column: usize, sample: usize) -> usize {
        if self.interleaved {
            sample * self.columns + column
        } else {
            column * self.length + sample
        }
    }

    /// Calls `each` for some samples of a column. Reads all given numbers: at the end of an archived array
    /// its checksum is compared.
    fn visit(
        &self,
        numbers: impl Iterator<Item = Result<f64, ArrayError>>,
        column: usize,
        range: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), ArrayError> {
        let mut samples = range;
        let mut next = samples.next();
        for (place, number) in numbers.enumerate() {
            let number = number?;
            if next.is_some_and(|sample| place == self.index(column, sample)) {
                each(number);
                next = samples.next();
            }
        }
        Ok(())
    }
}

fn archive(error: impl std::fmt::Display) -> Problem {
    Problem::damaged(".npz", error)
}

/// Converts an error of a named array.
fn problem(problem: ArrayError, name: &str) -> Problem {
    let array = format!("array `{name}`");
    match problem {
        ArrayError::Unsupported(kind) => Problem::unsupported(
            format!("the type {kind} of {array}"),
            "save real numbers (a float or an integer type)",
        ),
        ArrayError::CutShort { have, need } => Problem::truncated("NumPy", array, have, need),
        ArrayError::Damaged(what) => Problem::damaged("NumPy", format!("{array}: {what}")),
        // Cannot occur, since arrays are not stored here.
        other @ (ArrayError::TooLarge { .. } | ArrayError::Memory(_)) => {
            Problem::damaged("NumPy", format!("{array}: {other}"))
        }
    }
}
