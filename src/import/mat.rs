//! MATLAB files of version 5 to 7: numeric arrays.
//!
//! Read by the library matfile, as a whole. Of an array with two axes, the longer one is the time, as in `.npy`.

use std::io::Read;

use matfile::{Array, MatFile, NumericData};

use super::clock::Timing;
use super::npy::RATES;
use super::table::{ColumnHeader, Table, check_column_count};
use super::{Problem, units};
use crate::foreign::{one_line, without_panic};

const FORMAT: &str = "MATLAB";

/// Length of the header of a file, bytes; its last two name the byte order.
const HEADER: usize = 128;

/// Reads all arrays: columns, a time or a rate.
pub(super) fn read(mut content: impl Read) -> Result<Table, Problem> {
    let damaged = |reason: String| Problem::damaged(FORMAT, reason);
    let mut bytes = Vec::new();
    content.read_to_end(&mut bytes)?;
    check_lengths(&bytes)?;
    let file = without_panic(|| MatFile::parse(&bytes[..]));
    let file = file.ok_or_else(|| damaged("it cannot be decoded".to_owned()))?;
    let file = file.map_err(|error| damaged(one_line(error)))?;
    let mut table = Table {
        columns: Vec::new(),
        times: Vec::new(),
        timing: Timing::Unknown,
    };
    let mut count = 0;
    for array in file.arrays() {
        let name = array.name();
        let (bare, unit) = units::split(name);
        let second = units::seconds(unit).filter(|_| units::is_time(bare));
        let columns = columns(array).ok_or_else(|| {
            let shape = format!("the array `{name}` has the size {:?}", array.size());
            damaged(shape)
        })?;
        match (&columns[..], second) {
            ([(_, value)], _) if value.len() == 1 => {
                if RATES.contains(&name) && matches!(table.timing, Timing::Unknown) {
                    table.timing = Timing::Rate(value[0]);
                }
            }
            ([(_, times)], Some(second)) => {
                table.times = times.iter().map(|time| time * second).collect();
                table.timing = Timing::Times {
                    count: times.len(),
                    resolution: 0.0,
                    relative: 0.0,
                };
            }
            _ => {
                count += columns.len();
                check_column_count(count)?;
                let columns = columns
                    .into_iter()
                    .map(|(header, values)| (ColumnHeader::new(header, values.len()), values));
                table.columns.extend(columns);
            }
        }
    }
    if table.columns.is_empty() {
        return Err(Problem::no_samples("no array of real numbers"));
    }
    Ok(table)
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

/// The columns of an array with their names; none of complex numbers and of three axes; `None` if the size does not
/// match the numbers.
fn columns(array: &Array) -> Option<Vec<(String, Vec<f64>)>> {
    let (Some(values), &[rows, places]) = (real(array.data()), &array.size()[..]) else {
        return Some(Vec::new());
    };
    if rows.checked_mul(places)? != values.len() {
        return None;
    }
    let name = array.name();
    Some(match (rows, places) {
        (0, _) | (_, 0) => Vec::new(),
        (1, _) | (_, 1) => vec![(name.to_owned(), values)],
        // The samples of a column are adjacent.
        _ if rows >= places => {
            let columns = values.chunks_exact(rows).enumerate();
            let named = columns.map(|(k, column)| (format!("{name}[{k}]"), column.to_vec()));
            named.collect()
        }
        _ => {
            let column = |k| values.iter().skip(k).step_by(rows).copied().collect();
            (0..rows)
                .map(|k| (format!("{name}[{k}]"), column(k)))
                .collect()
        }
    })
}

/// Real numbers; `None` of complex ones.
fn real(data: &NumericData) -> Option<Vec<f64>> {
    fn all<T: Copy>(values: &[T], number: fn(T) -> f64) -> Option<Vec<f64>> {
        Some(values.iter().map(|value| number(*value)).collect())
    }
    match data {
        NumericData::Int8 { real, imag: None } => all(real, f64::from),
        NumericData::UInt8 { real, imag: None } => all(real, f64::from),
        NumericData::Int16 { real, imag: None } => all(real, f64::from),
        NumericData::UInt16 { real, imag: None } => all(real, f64::from),
        NumericData::Int32 { real, imag: None } => all(real, f64::from),
        NumericData::UInt32 { real, imag: None } => all(real, f64::from),
        NumericData::Int64 { real, imag: None } => all(real, |x| x as f64),
        NumericData::UInt64 { real, imag: None } => all(real, |x| x as f64),
        NumericData::Single { real, imag: None } => all(real, f64::from),
        NumericData::Double { real, imag: None } => all(real, |x| x),
        _ => None,
    }
}
