//! NumPy arrays, a single one or several in a file.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use super::clock::Timing;
use super::table::{ColumnHeader, Into, Source, check_column_count};
use super::{Problem, units};
use crate::numpy::{ArrayReader, Npz};

/// Names of a number with the sample rate.
pub(super) const RATES: [&str; 3] = ["rate", "fs", "sample_rate"];

/// A file of arrays.
pub(super) enum Container<R> {
    /// One array, with its name.
    Npy(R, String),
    /// Named arrays.
    Npz(Npz<R>),
}

impl<R: Read + Seek> Container<R> {
    /// Opens an array at its first value.
    fn array(&mut self, name: &str) -> Result<ArrayReader<Box<dyn Read + '_>>, Problem> {
        match self {
            Self::Npy(content, _) => {
                let length = content.seek(SeekFrom::End(0))?;
                content.rewind()?;
                ArrayReader::open(Box::new(content), name, length)
            }
            Self::Npz(archive) => {
                let (entry, length) = archive.entry(name)?.ok_or_else(Problem::changed)?;
                ArrayReader::open(Box::new(entry), name, length)
            }
        }
    }
}

/// Arrays as columns.
pub(super) struct Arrays<R> {
    container: Container<R>,
    arrays: Vec<Layout>,
    /// Name and unit (s) of the array of times.
    times: Option<(String, f64)>,
    rate: Option<f64>,
}

impl<R: Read + Seek> Arrays<R> {
    pub fn open(mut container: Container<R>) -> Result<Self, Problem> {
        let (names, is_archive) = match &container {
            Container::Npy(_, stem) => (vec![stem.clone()], false),
            Container::Npz(archive) => (archive.names(), true),
        };
        let (mut arrays, mut count) = (Vec::new(), 0);
        let (mut times, mut rate) = (None, None);
        for name in names {
            let mut array = container.array(&name)?;
            let (bare, unit) = units::split(&name);
            let second = units::seconds(unit).filter(|_| units::is_time(bare));
            match (array.shape.len(), second) {
                (1, Some(second)) if is_archive => times = Some((name, second)),
                (0, _) if RATES.contains(&&*name) && rate.is_none() => {
                    rate = array.next().transpose()?;
                }
                _ => {
                    let layout = Layout::of(&array, name, is_archive)?;
                    count += layout.headings.len();
                    check_column_count(count)?;
                    arrays.push(layout);
                }
            }
        }
        if count == 0 {
            let content = "an archive or a number without an array of samples";
            return Err(Problem::no_samples(content));
        }
        Ok(Self {
            container,
            arrays,
            times,
            rate,
        })
    }

    /// The array of a column, and the place of the column in it.
    fn find(&self, column: usize) -> Option<(&Layout, usize)> {
        let mut places = self.arrays.iter().flat_map(|layout| {
            let columns = 0..layout.headings.len();
            columns.map(move |column| (layout, column))
        });
        places.nth(column)
    }
}

impl<R: Read + Seek> Source for Arrays<R> {
    fn headings(&self) -> Vec<ColumnHeader> {
        let headings = self.arrays.iter().flat_map(|layout| &layout.headings);
        headings.cloned().collect()
    }

    fn clock(&mut self, column: usize) -> Result<(Timing, usize), Problem> {
        let timing = match (&self.times, self.rate) {
            (Some((name, second)), _) => {
                let array = self.container.array(name)?;
                let relative = array.rounding;
                let mut times = array.into_array()?.values;
                times.iter_mut().for_each(|time| *time *= second);
                Timing::Times {
                    times: Arc::new(times),
                    resolution: 0.0,
                    relative,
                }
            }
            (None, Some(rate)) => Timing::Rate(rate),
            (None, None) => Timing::Unknown,
        };
        let count = self.find(column).map_or(0, |(layout, _)| layout.length);
        Ok((timing, count))
    }

    fn samples(&mut self, column: usize, range: Range<usize>, into: Into) -> Result<(), Problem> {
        let Some((layout, column)) = self.find(column) else {
            return Ok(());
        };
        let (name, length) = (layout.name.clone(), layout.length);
        let (step, start) = if layout.is_interleaved {
            (layout.headings.len(), column)
        } else {
            (1, column * length)
        };
        // An archive is read to its end, where its checksum is compared.
        let end = match &self.container {
            Container::Npy(..) => start + range.end * step,
            Container::Npz(_) => usize::MAX,
        };
        let mut wanted = range.map(|sample| start + sample * step).peekable();
        for (place, number) in self.container.array(&name)?.enumerate().take(end) {
            let number = number?;
            if wanted.next_if_eq(&place).is_some() {
                into.push(number);
            }
        }
        Ok(())
    }
}

/// Columns of an array: a single axis is one column; with two axes, the longer one is the time.
struct Layout {
    name: String,
    /// None for a single number.
    headings: Vec<ColumnHeader>,
    /// Number of samples per column.
    length: usize,
    /// Whether the samples of one instant are adjacent, rather than those of one column.
    is_interleaved: bool,
}

impl Layout {
    fn of<R: Read>(
        array: &ArrayReader<R>,
        name: String,
        is_archive: bool,
    ) -> Result<Self, Problem> {
        if array.total == 0 {
            return Err(Problem::no_samples("an empty array"));
        }
        let (columns, length, along_rows) = match array.shape[..] {
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
        check_column_count(columns)?;
        let label = |k: usize| match (array.shape.len(), is_archive) {
            (1, _) => name.clone(),
            (_, true) => format!("{name}[{k}]"),
            (_, false) => k.to_string(),
        };
        Ok(Self {
            headings: (0..columns).map(label).map(ColumnHeader::new).collect(),
            name,
            length,
            is_interleaved: along_rows != array.fortran,
        })
    }
}
