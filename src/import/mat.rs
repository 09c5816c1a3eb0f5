//! MATLAB files of version 5 to 7: numeric arrays.
//!
//! Read by the library matfile, as a whole.

use std::io::{Cursor, Read, Seek};

use matfile::{MatFile, NumericData};

use super::Problem;
use crate::foreign::{one_line, without_panic};
use crate::numpy::{Array, Npz, encode_npz};

const FORMAT: &str = "MATLAB";

/// Length of the header of a file, bytes; its last two name the byte order.
const HEADER: usize = 128;

/// Reads all arrays of real numbers with one or two axes, as an archive of NumPy.
pub(super) fn read(mut content: impl Read) -> Result<Npz<impl Read + Seek>, Problem> {
    let damaged = |reason: String| Problem::damaged(FORMAT, reason);
    let mut bytes = Vec::new();
    content.read_to_end(&mut bytes)?;
    check_lengths(&bytes)?;
    let file = without_panic(|| MatFile::parse(&bytes[..]));
    let file = file.ok_or_else(|| damaged("it cannot be decoded".to_owned()))?;
    let file = file.map_err(|error| damaged(one_line(error)))?;
    let mut arrays = Vec::new();
    for array in file.arrays() {
        let (name, size) = (array.name(), &array.size()[..]);
        let (Some(values), [rows, columns]) = (real(array.data()), size) else {
            continue;
        };
        if rows.checked_mul(*columns) != Some(values.len()) {
            return Err(damaged(format!("the array `{name}` has the size {size:?}")));
        }
        if !values.is_empty() {
            // By rows; in the file by columns.
            let by_rows = (0..*rows).flat_map(|row| values.iter().skip(row).step_by(*rows));
            let values = by_rows.copied().collect();
            let shape = size.iter().copied().filter(|&length| length > 1).collect();
            arrays.push((name, Array { shape, values }));
        }
    }
    let mut npz = Cursor::new(Vec::new());
    encode_npz(&mut npz, &arrays).map_err(|error| damaged(error.to_string()))?;
    Npz::new(npz)
}

/// Checks that the elements of a file, which begin with their lengths, are complete: the library would leave out a
/// truncated one without a word.
fn check_lengths(bytes: &[u8]) -> Result<(), Problem> {
    let is_little = bytes.get(HEADER - 2..HEADER) == Some(b"IM");
    let mut rest = bytes.get(HEADER..).unwrap_or_default();
    for number in 1.. {
        let Some((tag, content)) = rest.split_first_chunk::<8>() else {
            break;
        };
        let length = [tag[4], tag[5], tag[6], tag[7]];
        let length = if is_little {
            u32::from_le_bytes(length)
        } else {
            u32::from_be_bytes(length)
        };
        let Some(after) = content.get(length as usize..) else {
            let (what, have) = (format!("array {number}"), content.len() as u64);
            return Err(Problem::truncated(FORMAT, what, have, length.into()));
        };
        rest = after;
    }
    Ok(())
}

/// Real numbers; `None` of complex ones.
fn real(data: &NumericData) -> Option<Vec<f64>> {
    macro_rules! real {
        ($($kind:ident)*) => {
            match data {
                $(NumericData::$kind { real, imag: None } => {
                    Some(real.iter().map(|x| *x as f64).collect())
                })*
                _ => None,
            }
        };
    }
    real!(Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Single Double)
}
