//! Named arrays in one `.npz` file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, Write};
use std::path::Path;

use npyz::WriterBuilder;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{Array, ArrayReader};
use crate::foreign::{Problem, open_file};
use crate::joint::{ArrayError, NamedArrays};

/// Maximum number of values that [`Npz::array`] reads from one file, all arrays together (1 GiB of
/// `f64`): far above a sparse mass matrix, far below what a few bytes of a compressed file can announce.
pub const MAX_NUMBERS: usize = 1 << 27;

/// An open `.npz` file; its arrays are read one by one.
#[derive(Debug)]
pub struct Npz<R> {
    zip: ZipArchive<R>,
    /// Number of values read so far.
    read: usize,
}

impl Npz<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be read or is not an archive.
    pub fn open(path: &Path) -> Result<Self, Problem> {
        Self::new(BufReader::new(open_file(path)?.0))
    }
}

impl<R: Read + Seek> Npz<R> {
    /// Reads the directory of an archive.
    ///
    /// # Errors
    /// If the content is not an archive.
    pub fn new(content: R) -> Result<Self, Problem> {
        let zip = ZipArchive::new(content).map_err(|error| {
            Problem::Content(format!(
                "the .npz file is damaged ({error}); write it with numpy.savez"
            ))
        })?;
        Ok(Self { zip, read: 0 })
    }

    /// Names of the arrays, in the order of the file.
    pub fn names(&self) -> Vec<String> {
        let entries = self.zip.file_names();
        entries
            .filter_map(|entry| Some(entry.strip_suffix(".npy")?.to_owned()))
            .collect()
    }

    /// Reads the header of an array; `None` if there is no array of this name.
    pub(crate) fn reader(&mut self, name: &str) -> Result<Option<ArrayReader<'_>>, Problem> {
        let Some(index) = self.zip.index_for_name(&format!("{name}.npy")) else {
            return Ok(None);
        };
        let damaged = |error| Problem::damaged(".npz", format!("array `{name}`: {error}"));
        let entry = self.zip.by_index(index).map_err(damaged)?;
        let length = entry.size();
        ArrayReader::open(entry, name, length).map(Some)
    }

    /// Reads an array by its name; `None` if there is no array of this name.
    ///
    /// # Errors
    /// If it cannot be read, contains other types than real numbers, or is too large: at most
    /// [`MAX_NUMBERS`] values per file, within the available memory.
    pub fn array(&mut self, name: &str) -> Result<Option<Array>, Problem> {
        let left = MAX_NUMBERS - self.read;
        let Some(array) = self.reader(name)? else {
            return Ok(None);
        };
        let have = array.total;
        if have > left {
            return Err(Problem::Content(format!(
                "the array `{name}` has {have} numbers, above the limit of {MAX_NUMBERS} per file; save fewer"
            )));
        }
        let array = array.into_array()?;
        self.read += have;
        Ok(Some(array))
    }
}

impl<R: Read + Seek> NamedArrays for Npz<R> {
    fn shape(&mut self, name: &str) -> Result<Option<Vec<usize>>, ArrayError> {
        Ok(self.reader(name)?.map(|array| array.shape))
    }

    fn values(&mut self, name: &str) -> Result<Vec<f64>, ArrayError> {
        Ok(self
            .array(name)?
            .map_or_else(Vec::new, |array| array.values))
    }
}

/// Reads all arrays of an `.npz` file.
///
/// # Errors
/// If the file cannot be read, or an array contains other types than real numbers.
pub fn read_npz(path: &Path) -> Result<BTreeMap<String, Array>, Problem> {
    let mut npz = Npz::open(path)?;
    let mut arrays = BTreeMap::new();
    for name in npz.names() {
        if let Some(array) = npz.array(&name)? {
            arrays.insert(name, array);
        }
    }
    Ok(arrays)
}

/// Writes arrays with their names. Equal arrays give equal bytes.
///
/// # Errors
/// If `out` cannot be written.
pub fn encode_npz(out: impl Write + Seek, arrays: &[(&str, Array)]) -> io::Result<()> {
    let mut npz = ZipWriter::new(out);
    for (name, array) in arrays {
        write_array(
            &mut npz,
            name,
            &array.shape,
            array.values.iter().map(|x| Ok(*x)),
        )?;
    }
    npz.finish()?;
    Ok(())
}

/// Adds an array of the given shape to an archive, with its values in row-major order.
pub(crate) fn write_array(
    npz: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    shape: &[usize],
    values: impl Iterator<Item = io::Result<f64>>,
) -> io::Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(true);
    npz.start_file(format!("{name}.npy"), options)?;
    let shape: Vec<u64> = shape.iter().map(|&n| n as u64).collect();
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&shape)
        .writer(npz)
        .begin_nd()?;
    for value in values {
        writer.push(&value?)?;
    }
    writer.finish()
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use npyz::{AutoSerialize, Order, WriteOptions};

    use super::*;

    /// The bytes of an array.
    fn npy<T: AutoSerialize>(
        order: Order,
        shape: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = WriteOptions::new()
            .default_dtype()
            .order(order)
            .shape(shape)
            .writer(&mut bytes)
            .begin_nd()
            .unwrap();
        writer.extend(values).unwrap();
        writer.finish().unwrap();
        bytes.into_inner()
    }

    /// The same bytes with the name of another type of the same size.
    fn retyped(mut bytes: Vec<u8>, to: &[u8; 3]) -> Vec<u8> {
        let at = bytes.windows(7).position(|w| w == b"'descr'").unwrap() + 10;
        bytes[at..at + 3].copy_from_slice(to);
        bytes
    }

    /// A compressed file with the given entries.
    fn file(entries: &[(&str, Vec<u8>)]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut zip = ZipWriter::new(file.as_file());
        for (name, bytes) in entries {
            let options =
                SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
            zip.start_file(*name, options).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        file
    }

    #[test]
    fn foreign_arrays_are_read_in_row_major_order() {
        // The rows 0 1 2 and 3 4 5, stored column by column.
        let columns = [0.0, 3.0, 1.0, 4.0, 2.0, 5.0];
        let singles = columns.map(|x| f32::from_bits((x as f32).to_bits().swap_bytes()));
        let file = file(&[
            ("double.npy", npy::<f64>(Order::Fortran, &[2, 3], columns)),
            (
                "single.npy",
                retyped(npy(Order::Fortran, &[2, 3], singles), b">f4"),
            ),
            ("whole.npy", npy(Order::C, &[2, 3], 0..6_i64)),
            ("notes.txt", b"hello".to_vec()),
        ]);
        let arrays = read_npz(file.path()).unwrap();
        let expected = Array::matrix(2, (0..6).map(f64::from).collect());
        assert_eq!(arrays.len(), 3);
        for (name, array) in arrays {
            assert_eq!(array, expected, "{name}");
        }
        // Three axes, the first changing fastest.
        let cube = npy(Order::Fortran, &[2, 2, 3], (0..12).map(f64::from));
        let cube = ArrayReader::open(&cube[..], "cube", cube.len() as u64).unwrap();
        let rows = [0.0, 4.0, 8.0, 2.0, 6.0, 10.0, 1.0, 5.0, 9.0, 3.0, 7.0, 11.0];
        assert_eq!(cube.into_array().unwrap().values, rows);
    }

    #[test]
    fn unreadable_arrays_are_named_in_the_error() {
        let folder = tempfile::tempdir().unwrap();
        let rejected = |path: &Path| read_npz(path).unwrap_err().to_string();
        assert!(rejected(&folder.path().join("none.npz")).contains("check its path"));
        assert!(rejected(folder.path()).contains("is a directory"));
        let plain = folder.path().join("plain.npz");
        std::fs::write(&plain, b"not a zip").unwrap();
        assert!(rejected(&plain).contains("numpy.savez"));
        let mut cut = npy(Order::C, &[3], [1.0, 2.0, 3.0]);
        cut.pop();
        let message = rejected(file(&[("short.npy", cut)]).path());
        assert!(
            message.contains("`short`") && message.contains("23 of 24 bytes"),
            "{message}"
        );
        let text = || retyped(npy(Order::C, &[2], [1.0, 2.0]), b"<U2");
        let message = rejected(file(&[("words.npy", text())]).path());
        assert!(
            message.contains("`words`") && message.contains("save real numbers"),
            "{message}"
        );
        let torn = retyped(npy(Order::C, &[2], [1.0, 2.0]), b"<f'");
        let message = rejected(file(&[("torn.npy", torn)]).path());
        assert!(
            message.contains("`torn`") && message.ends_with("syntax error; export it again"),
            "{message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
        // Arrays that are not requested are not read.
        let both = file(&[("words.npy", text()), ("x.npy", npy(Order::C, &[1], [2.0]))]);
        let mut npz = Npz::open(both.path()).unwrap();
        assert_eq!(npz.array("x").unwrap(), Some(Array::vector(vec![2.0])));
        assert_eq!(npz.array("y").unwrap(), None);
    }
}
