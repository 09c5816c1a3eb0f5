//! MATLAB files of version 5 to 7: numeric arrays.
//!
//! Read by the library matfile, as a whole. Of an array with two axes, the longer one is the time, as in `.npy`.

use std::io::Read;
use std::sync::Arc;

use matfile::{Array, MatFile, NumericData};

use super::clock::Timing;
use super::npy::RATES;
use super::table::{Column, ColumnHeader, Table, check_column_count};
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
    let (mut named, mut times, mut rate) = (Vec::new(), None, None);
    for array in file.arrays() {
        let name = array.name();
        let (bare, unit) = units::split(name);
        let second = units::seconds(unit).filter(|_| units::is_time(bare));
        let mut columns = columns(array).ok_or_else(|| {
            let shape = format!("the array `{name}` has the size {:?}", array.size());
            damaged(shape)
        })?;
        match (&mut columns[..], second) {
            ([(_, value)], _) if value.len() == 1 => {
                rate = rate.or(RATES.contains(&name).then_some(value[0]));
            }
            ([(_, values)], Some(second)) => {
                times = Some(values.iter().map(|time| time * second).collect());
            }
            _ => {
                named.append(&mut columns);
                check_column_count(named.len())?;
            }
        }
    }
    if named.is_empty() {
        return Err(Problem::no_samples("no array of real numbers"));
    }
    let timing = match (times, rate) {
        (Some(times), _) => Timing::Times {
            times: Arc::new(times),
            resolution: 0.0,
            relative: 0.0,
        },
        (None, Some(rate)) => Timing::Rate(rate),
        (None, None) => Timing::Unknown,
    };
    let columns = named.into_iter().map(|(header, samples)| Column {
        header: ColumnHeader::new(header),
        timing: timing.clone(),
        samples,
    });
    Ok(Table {
        columns: columns.collect(),
        damage: None,
    })
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
    // The samples of a column are adjacent in the file.
    let (count, length, step, next) = if rows >= places {
        (places, rows, 1, rows)
    } else {
        (rows, places, rows, 1)
    };
    let column = |k: usize| {
        let samples = values.iter().skip(k * next).step_by(step).take(length);
        let name = if count == 1 {
            name.to_owned()
        } else {
            format!("{name}[{k}]")
        };
        (name, samples.copied().collect())
    };
    Some((0..count).map(column).collect())
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
