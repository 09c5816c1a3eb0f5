//! Named arrays of doubles in one `.npz` file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Seek, Write};
use std::path::Path;

use npyz::WriterBuilder;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{OutputError, replace_file};

/// An array in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length along each axis; empty for a single number.
    pub shape: Vec<usize>,
    /// The numbers.
    pub values: Vec<f64>,
}

impl Array {
    /// A one-dimensional array.
    pub fn vector(values: Vec<f64>) -> Self {
        Self {
            shape: vec![values.len()],
            values,
        }
    }

    /// An array of `rows` rows, of as many columns as the values give.
    pub fn matrix(rows: usize, values: Vec<f64>) -> Self {
        let columns = values.len().checked_div(rows).unwrap_or(0);
        Self {
            shape: vec![rows, columns],
            values,
        }
    }

    /// A single number.
    pub fn number(value: f64) -> Self {
        Self {
            shape: vec![],
            values: vec![value],
        }
    }
}

/// Writes arrays under their names to a file. The same arrays give the same bytes.
///
/// # Errors
/// If the file cannot be written; an older one of that name is then untouched.
pub fn write_npz(path: &Path, arrays: &[(&str, Array)]) -> Result<(), OutputError> {
    replace_file(path, |file| encode_npz(file, arrays))
}

/// Writes arrays under their names.
///
/// # Errors
/// If `out` cannot be written.
pub fn encode_npz(out: impl Write + Seek, arrays: &[(&str, Array)]) -> io::Result<()> {
    let mut npz = NpzWriter::new(out);
    for (name, array) in arrays {
        npz.array(name, &array.shape, array.values.iter().map(|x| Ok(*x)))?;
    }
    npz.finish()
}

/// Writes arrays one after another.
pub(super) struct NpzWriter<W: Write + Seek> {
    zip: ZipWriter<W>,
}

impl<W: Write + Seek> NpzWriter<W> {
    pub fn new(out: W) -> Self {
        Self {
            zip: ZipWriter::new(out),
        }
    }

    /// An array of some shape, its numbers in row-major order.
    pub fn array(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl Iterator<Item = io::Result<f64>>,
    ) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(true);
        self.zip.start_file(format!("{name}.npy"), options)?;
        let shape: Vec<u64> = shape.iter().map(|&n| n as u64).collect();
        let mut writer = npyz::WriteOptions::new()
            .default_dtype()
            .shape(&shape)
            .writer(&mut self.zip)
            .begin_nd()?;
        for value in values {
            writer.push(&value?)?;
        }
        writer.finish()
    }

    pub fn finish(self) -> io::Result<()> {
        self.zip.finish()?;
        Ok(())
    }
}

/// Reads all arrays of an `.npz` file of doubles.
///
/// # Errors
/// If the file cannot be read or holds something else.
pub fn read_npz(path: &Path) -> io::Result<BTreeMap<String, Array>> {
    let mut zip = ZipArchive::new(BufReader::new(File::open(path)?))?;
    let mut arrays = BTreeMap::new();
    for index in 0..zip.len() {
        let entry = zip.by_index(index)?;
        let name = entry.name()?.trim_end_matches(".npy").to_owned();
        let file = npyz::NpyFile::new(entry)?;
        let shape = file.shape().iter().map(|&n| n as usize).collect();
        arrays.insert(
            name,
            Array {
                shape,
                values: file.into_vec()?,
            },
        );
    }
    Ok(arrays)
}
