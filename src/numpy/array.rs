//! Reads one array from the bytes of a `.npy` file.

use std::io::{self, BufReader, Read};

use npyz::{DType, Endianness, NpyHeader, Order, TypeChar};

use crate::foreign::Problem;
use crate::memory;

/// Maximum nesting of brackets in a header, because the parsing time grows exponentially with it. An
/// array of records, which is not supported, has five levels.
const MAX_NESTING: i32 = 8;

/// Maximum header length, bytes: the limit of format version 1.0. NumPy itself reads 10,000.
const MAX_HEADER: usize = 65_535;

/// Bytes per read.
const BLOCK: usize = 1 << 16;

/// An array in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length along each axis; empty for a single number.
    pub shape: Vec<usize>,
    /// Values, row-major.
    pub values: Vec<f64>,
}

impl Array {
    /// Creates a one-dimensional array.
    pub fn vector(values: Vec<f64>) -> Self {
        Self {
            shape: vec![values.len()],
            values,
        }
    }

    /// Creates an array of `rows` rows; the number of columns follows from the values.
    pub fn matrix(rows: usize, values: Vec<f64>) -> Self {
        let columns = values.len().checked_div(rows).unwrap_or(0);
        Self {
            shape: vec![rows, columns],
            values,
        }
    }

    /// Creates an array of a single number.
    pub fn number(value: f64) -> Self {
        Self {
            shape: vec![],
            values: vec![value],
        }
    }
}

/// An array in a file; its values are read on demand.
///
/// As an iterator it yields the values in the order of the file and keeps one block of them in memory.
/// It ends after an error.
pub(crate) struct ArrayReader<'a> {
    /// Name for messages.
    name: String,
    /// Length along each axis; empty for a single number.
    pub shape: Vec<usize>,
    /// Whether the first axis changes fastest (the order of Fortran).
    pub fortran: bool,
    /// Relative rounding error of the values; 0 for integers.
    pub rounding: f64,
    /// Number of values.
    pub total: usize,
    element: ElementType,
    source: BufReader<Box<dyn Read + 'a>>,
    /// Number of values read.
    read: usize,
}

/// Binary format of a value.
struct ElementType {
    /// Bytes per value.
    size: usize,
    big_endian: bool,
    /// Converts the bytes, assembled least significant first, to a number.
    number: fn(u64) -> f64,
}

impl<'a> ArrayReader<'a> {
    /// Reads the header of a `.npy` file of `length` bytes.
    ///
    /// # Errors
    /// If the header does not follow the format, announces more bytes than the file has, or a type other
    /// than real numbers.
    pub fn open(mut source: impl Read + 'a, name: &str, length: u64) -> Result<Self, Problem> {
        let (header, begin) = header(&mut source).map_err(|error| damaged(name, error))?;
        let (element, rounding) = element_type(&header.dtype(), name)?;
        let shape: Vec<usize> = header.shape().iter().map(|&n| n as usize).collect();
        let total = shape.iter().try_fold(1_usize, |all, &n| all.checked_mul(n));
        let need = total.and_then(|total| total.checked_mul(element.size));
        let (Some(total), Some(need)) = (total, need) else {
            return Err(damaged(name, io::Error::other("its shape overflows")));
        };
        let reader = Self {
            name: name.to_owned(),
            shape,
            fortran: header.order() == Order::Fortran,
            rounding,
            total,
            element,
            source: BufReader::with_capacity(BLOCK, Box::new(source)),
            read: 0,
        };
        let have = length.saturating_sub(begin as u64);
        if have < need as u64 {
            return Err(reader.truncated(have));
        }
        Ok(reader)
    }

    fn truncated(&self, have: u64) -> Problem {
        let need = (self.total * self.element.size) as u64;
        Problem::truncated("NumPy", format!("array `{}`", self.name), have, need)
    }

    /// Reads all values into row-major order.
    ///
    /// # Errors
    /// If they exceed the available memory, before anything is read, and all errors of reading.
    pub fn into_array(self) -> Result<Array, Problem> {
        let mut values = memory::allocate(self.total)
            .map_err(|shortage| Problem::too_large(&self.name, shortage))?;
        values.resize(self.total, 0.0);
        let (shape, fortran) = (self.shape.clone(), self.fortran);
        // The index along each axis, the fastest first, and with them the place in row-major order.
        let row_major = |mut place: usize| {
            shape.iter().fold(0, |position, &length| {
                let index = place % length;
                place /= length;
                position * length + index
            })
        };
        for (place, value) in self.enumerate() {
            values[if fortran { row_major(place) } else { place }] = value?;
        }
        Ok(Array { shape, values })
    }
}

impl Iterator for ArrayReader<'_> {
    type Item = Result<f64, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.read == self.total {
            return None;
        }
        let size = self.element.size;
        let mut bytes = [0; 8];
        let mut result = self.source.read_exact(&mut bytes[..size]);
        self.read += 1;
        // An archive verifies its checksum at the end of the data.
        if result.is_ok() && self.read == self.total {
            result = self.source.read(&mut [0]).map(drop);
        }
        if let Err(error) = result {
            let have = (self.read - 1) * size;
            self.read = self.total;
            return Some(Err(match error.kind() {
                io::ErrorKind::UnexpectedEof => self.truncated(have as u64),
                _ => damaged(&self.name, error),
            }));
        }
        if self.element.big_endian {
            bytes[..size].reverse();
        }
        Some(Ok((self.element.number)(u64::from_le_bytes(bytes))))
    }
}

/// Keeps the first line of a library's message: syntax errors include a copy of the header.
fn damaged(name: &str, error: io::Error) -> Problem {
    let reason = error.to_string();
    let line = reason.lines().next().unwrap_or_default();
    let words = line.split(" --> ").next().unwrap_or_default();
    let reason = words.trim_end_matches([' ', ':']);
    Problem::damaged("NumPy", format!("array `{name}`: {reason}"))
}

/// Reads the header, if its length is within the limit, and the position of the first value.
fn header(source: &mut impl Read) -> io::Result<(NpyHeader, usize)> {
    // Magic bytes, version, and a length of two bytes (four in later versions).
    let mut start = [0; 12];
    source.read_exact(&mut start)?;
    let [.., a, b, c, d] = start;
    let (begin, length) = if start[6] > 1 {
        (12, u32::from_le_bytes([a, b, c, d]) as usize)
    } else {
        (10, u16::from_le_bytes([a, b]).into())
    };
    if length > MAX_HEADER {
        let reason = format!("its header has {length} bytes, above the limit of {MAX_HEADER}");
        return Err(io::Error::other(reason));
    }
    let end = start.len().max(begin + length);
    let mut text = vec![0; end];
    text[..start.len()].copy_from_slice(&start);
    source.read_exact(&mut text[start.len()..])?;
    let mut depth = 0;
    let depths = text.iter().map(|byte| {
        let step = match byte {
            b'(' | b'[' | b'{' => 1,
            b')' | b']' | b'}' => -1,
            _ => 0,
        };
        depth = 0.max(depth + step);
        depth
    });
    if depths.max() > Some(MAX_NESTING) {
        return Err(io::Error::other("its header is nested too deeply"));
    }
    Ok((NpyHeader::from_reader(&text[..])?, begin + length))
}

/// Binary format of a type, and its relative rounding error.
fn element_type(dtype: &DType, name: &str) -> Result<(ElementType, f64), Problem> {
    let unsupported = || {
        let what = format!("the type {} of array `{name}`", dtype.descr());
        Problem::unsupported(what, "save real numbers (a float or an integer type)")
    };
    let DType::Plain(plain) = dtype else {
        return Err(unsupported());
    };
    let size = plain.num_bytes().ok_or_else(unsupported)?;
    let half = |bits| half::f16::from_bits(bits as u16).to_f64();
    let (number, rounding): (fn(u64) -> f64, f64) = match (plain.type_char(), size) {
        (TypeChar::Float, 8) => (f64::from_bits, f64::EPSILON),
        (TypeChar::Float, 4) => (
            |bits| f32::from_bits(bits as u32).into(),
            f32::EPSILON.into(),
        ),
        (TypeChar::Float, 2) => (half, half::f16::EPSILON.to_f64()),
        (TypeChar::Int, 1) => (|bits| f64::from(bits as i8), 0.0),
        (TypeChar::Int, 2) => (|bits| f64::from(bits as i16), 0.0),
        (TypeChar::Int, 4) => (|bits| f64::from(bits as i32), 0.0),
        (TypeChar::Int, 8) => (|bits| bits as i64 as f64, 0.0),
        (TypeChar::Uint, 1 | 2 | 4 | 8) => (|bits| bits as f64, 0.0),
        _ => return Err(unsupported()),
    };
    let element = ElementType {
        size,
        big_endian: plain.endianness() == Endianness::Big,
        number,
    };
    Ok((element, rounding))
}
