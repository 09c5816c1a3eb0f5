//! NumPy arrays, one in a file or several.

use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::{Clock, Column, Problem, Table, units};
use crate::numpy::{ArrayProblem, RawArray};

/// Names of a number that is the sample rate.
const RATES: [&str; 3] = ["rate", "fs", "sample_rate"];

/// The columns of a lone array.
pub(super) fn decode_npy(bytes: &[u8], stem: &str) -> Result<Table, Problem> {
    let array = read(bytes, stem)?;
    let columns = match array.shape.len() {
        1 => array.columns(stem)?,
        _ => array.columns("")?,
    };
    if columns.is_empty() {
        return Err(Problem::NoSamples("a single number"));
    }
    Ok(Table {
        columns,
        clock: Clock::Unknown,
    })
}

/// The columns of named arrays.
pub(super) fn decode_npz(bytes: &[u8]) -> Result<Table, Problem> {
    let damaged = |what: String| Problem::Damaged {
        format: ".npz",
        what,
    };
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(|e| damaged(e.to_string()))?;
    let mut columns = Vec::new();
    let mut clock = Clock::Unknown;
    for index in 0..zip.len() {
        let mut entry = zip.by_index(index).map_err(|e| damaged(e.to_string()))?;
        let entry_name = entry
            .name()
            .map_err(|e| damaged(e.to_string()))?
            .into_owned();
        let Some(name) = entry_name.strip_suffix(".npy") else {
            continue;
        };
        let mut content = Vec::new();
        entry
            .read_to_end(&mut content)
            .map_err(|e| damaged(format!("array `{name}`: {e}")))?;
        let array = read(&content, name)?;
        let (bare, unit) = units::split(name);
        let second = units::seconds(unit).filter(|_| units::is_time(bare));
        match (array.shape.len(), second) {
            (1, Some(second)) => {
                let largest = array.values.iter().fold(0.0_f64, |max, t| max.max(t.abs()));
                clock = Clock::Times {
                    resolution: array.rounding * largest * second,
                    times: array.values.iter().map(|t| t * second).collect(),
                };
            }
            (0, _) if RATES.contains(&name) && clock == Clock::Unknown => {
                clock = Clock::Rate(array.values[0]);
            }
            _ => columns.extend(array.columns(name)?),
        }
    }
    if columns.is_empty() {
        return Err(Problem::NoSamples("an archive without an array of samples"));
    }
    Ok(Table { columns, clock })
}

impl RawArray {
    /// One column, or those of two axes, the longer of which is the time; none of a single number.
    fn columns(self, name: &str) -> Result<Vec<Column>, Problem> {
        let column = |name: String, values| {
            let (bare, unit) = units::split(&name);
            Column {
                name: bare.to_owned(),
                unit: unit.to_owned(),
                values,
                header: name.clone(),
            }
        };
        match self.shape[..] {
            [] => Ok(Vec::new()),
            [_] => Ok(vec![column(name.to_owned(), self.values)]),
            [rows, places] => {
                let along_rows = rows >= places;
                let count = rows.min(places);
                // Where the axis that changes faster in the file is that of the columns.
                let interleaved = along_rows != self.fortran;
                let of = |k: usize| -> Vec<f64> {
                    if interleaved {
                        self.values.iter().skip(k).step_by(count).copied().collect()
                    } else {
                        self.values[k * rows.max(places)..][..rows.max(places)].to_vec()
                    }
                };
                let label = |k: usize| match name {
                    "" => k.to_string(),
                    name => format!("{name}[{k}]"),
                };
                Ok((0..count).map(|k| column(label(k), of(k))).collect())
            }
            _ => Err(Problem::Unsupported {
                what: format!("an array of {} axes", self.shape.len()),
                remedy: "save a single column, or one column beside the other",
            }),
        }
    }
}

/// Reads one array that is not empty; `name` is for messages.
fn read(bytes: &[u8], name: &str) -> Result<RawArray, Problem> {
    let array = RawArray::decode(bytes).map_err(|problem| match problem {
        ArrayProblem::Unsupported(kind) => Problem::Unsupported {
            what: format!("the type {kind} of array `{name}`"),
            remedy: "save real numbers (a float or an integer type)",
        },
        ArrayProblem::CutShort { have, need } => Problem::CutShort {
            format: "NumPy",
            what: format!("array `{name}`"),
            have,
            need,
        },
        ArrayProblem::Damaged(what) => Problem::Damaged {
            format: "NumPy",
            what: format!("array `{name}`: {what}"),
        },
    })?;
    if array.values.is_empty() {
        return Err(Problem::NoSamples("an empty array"));
    }
    Ok(array)
}
