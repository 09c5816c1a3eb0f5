//! NumPy arrays, one in a file or several.

use std::io::{Cursor, Read};

use npyz::{DType, Deserialize, NpyFile, NpyHeader, Order, TypeChar};
use zip::ZipArchive;

use super::{Clock, Column, Problem, Table, units};

/// Names of a number that is the sample rate.
const RATES: [&str; 3] = ["rate", "fs", "sample_rate"];

/// Brackets within brackets in a header; the time to parse it grows exponentially with them. A
/// record of arrays, which is not read here, has five.
const DEEPEST: usize = 8;

/// An array as it is in the file.
struct RawArray {
    shape: Vec<usize>,
    fortran: bool,
    values: Vec<f64>,
    /// Relative rounding of its type.
    rounding: f64,
}

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

/// Magic, version and length before a header, of the longer kind; its first two characters may be
/// among them.
const PREFIX: usize = 12;

/// How deeply the brackets of the header, which ends with its line, are nested.
fn nesting(bytes: &[u8]) -> usize {
    let mut depth = 0_usize;
    let mut deepest = 0;
    for byte in bytes.iter().skip(PREFIX).take_while(|byte| **byte != b'\n') {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(depth);
    }
    deepest
}

/// Reads one array; `name` is for messages.
fn read(bytes: &[u8], name: &str) -> Result<RawArray, Problem> {
    let damaged = |what: String| Problem::Damaged {
        format: "NumPy",
        what: format!("array `{name}`: {what}"),
    };
    if nesting(bytes) > DEEPEST {
        return Err(damaged("its header is nested too deeply".to_owned()));
    }
    let mut rest = bytes;
    let header = NpyHeader::from_reader(&mut rest).map_err(|e| damaged(e.to_string()))?;
    let file = NpyFile::with_header(header, rest);
    let shape: Vec<usize> = file.shape().iter().map(|&n| n as usize).collect();
    let dtype = file.dtype();
    let unsupported = || Problem::Unsupported {
        what: format!("the type {} of array `{name}`", dtype.descr()),
        remedy: "save real numbers (a float or an integer type)",
    };
    let DType::Plain(kind) = &dtype else {
        return Err(unsupported());
    };
    let size = kind.num_bytes().ok_or_else(unsupported)?;
    let count = shape.iter().try_fold(1_usize, |all, &n| all.checked_mul(n));
    let need = count.and_then(|count| count.checked_mul(size));
    let need = need.ok_or_else(|| damaged("its shape is beyond all bounds".to_owned()))?;
    if rest.len() < need {
        return Err(Problem::CutShort {
            format: "NumPy",
            what: format!("array `{name}`"),
            have: rest.len() as u64,
            need: need as u64,
        });
    }
    if need == 0 {
        return Err(Problem::NoSamples("an empty array"));
    }
    let fortran = file.order() == Order::Fortran;
    let (values, rounding) = match (kind.type_char(), size) {
        (TypeChar::Float, 8) => (numbers(file, |x: f64| x), f64::EPSILON),
        (TypeChar::Float, 4) => (numbers(file, |x: f32| x.into()), f64::from(f32::EPSILON)),
        (TypeChar::Float, 2) => (
            numbers(file, half::f16::to_f64),
            half::f16::EPSILON.to_f64(),
        ),
        (TypeChar::Int, 1) => (numbers(file, |x: i8| x.into()), 0.0),
        (TypeChar::Int, 2) => (numbers(file, |x: i16| x.into()), 0.0),
        (TypeChar::Int, 4) => (numbers(file, |x: i32| x.into()), 0.0),
        (TypeChar::Int, 8) => (numbers(file, |x: i64| x as f64), 0.0),
        (TypeChar::Uint, 1) => (numbers(file, |x: u8| x.into()), 0.0),
        (TypeChar::Uint, 2) => (numbers(file, |x: u16| x.into()), 0.0),
        (TypeChar::Uint, 4) => (numbers(file, |x: u32| x.into()), 0.0),
        (TypeChar::Uint, 8) => (numbers(file, |x: u64| x as f64), 0.0),
        _ => return Err(unsupported()),
    };
    Ok(RawArray {
        shape,
        fortran,
        values: values.map_err(|e| damaged(e.to_string()))?,
        rounding,
    })
}

fn numbers<T: Deserialize>(
    file: NpyFile<&[u8]>,
    to: impl Fn(T) -> f64,
) -> std::io::Result<Vec<f64>> {
    Ok(file.into_vec::<T>()?.into_iter().map(to).collect())
}
