//! Reads one array from the bytes of a `.npy` file.

use std::io::{self, BufReader, Read};

use npyz::{DType, Endianness, NpyHeader, Order, TypeChar};

use crate::memory::{self, MemoryShortage};

/// Maximum nesting of brackets in a header, because the parsing time grows exponentially with it. An
/// array of records, which is not supported, has five levels.
const MAX_NESTING: usize = 8;

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

/// Error while an array is decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArrayError {
    /// The bytes do not follow the format.
    #[error("it is damaged: {0}; save it again")]
    Damaged(String),
    /// The values are not real numbers.
    #[error("its type {0} is not supported; save real numbers (a float or an integer type)")]
    Unsupported(String),
    /// The bytes are truncated.
    #[error("it is truncated: {have} of {need} bytes; save it again")]
    CutShort {
        /// Bytes present.
        have: u64,
        /// Bytes announced in the header.
        need: u64,
    },
    /// The array exceeds the limit.
    #[error("it has {have} numbers, above the limit of {most} per file; save fewer")]
    TooLarge {
        /// Number of values in the array.
        have: usize,
        /// Maximum number of values.
        most: usize,
    },
    /// The values exceed the available memory.
    #[error("{0}; save fewer numbers")]
    Memory(#[from] MemoryShortage),
}

/// An array in a file; its values are read on demand.
///
/// As an iterator it yields the values in the order of the file and keeps one block of them in memory.
/// It ends after an error.
pub struct ArrayReader<R> {
    shape: Vec<usize>,
    fortran: bool,
    rounding: f64,
    element: ElementType,
    source: BufReader<R>,
    /// Bytes of values announced in the header, and bytes read.
    need: u64,
    have: u64,
}

/// Binary format of a value.
struct ElementType {
    /// Bytes per value.
    size: usize,
    big_endian: bool,
    /// Converts the bytes, assembled least significant first, to a number.
    number: fn(u64) -> f64,
}

impl<R: Read> ArrayReader<R> {
    /// Reads the header of a `.npy` file of `length` bytes.
    ///
    /// # Errors
    /// If the header does not follow the format, announces more bytes than the file has, or a type other
    /// than real numbers.
    pub fn open(mut source: R, length: u64) -> Result<Self, ArrayError> {
        let text = header(&mut source)?;
        let header = NpyHeader::from_reader(&text[..]).map_err(damaged)?;
        let shape: Vec<usize> = header.shape().iter().map(|&n| n as usize).collect();
        let (element, rounding) = element_type(&header.dtype())?;
        let count = shape.iter().try_fold(1_usize, |all, &n| all.checked_mul(n));
        let need = count
            .and_then(|count| count.checked_mul(element.size))
            .ok_or_else(|| ArrayError::Damaged("its shape overflows".to_owned()))?;
        let (have, need) = (length.saturating_sub(text.len() as u64), need as u64);
        if have < need {
            return Err(ArrayError::CutShort { have, need });
        }
        Ok(Self {
            shape,
            fortran: header.order() == Order::Fortran,
            rounding,
            element,
            source: BufReader::with_capacity(BLOCK, source),
            need,
            have: 0,
        })
    }

    /// Length along each axis; empty for a single number.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Whether the file is in Fortran order (the first axis changes fastest).
    pub fn fortran(&self) -> bool {
        self.fortran
    }

    /// Relative rounding error of the type in the file; 0 for integers.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Number of values.
    pub fn total(&self) -> usize {
        self.shape.iter().product()
    }

    /// Reads all values into row-major order.
    ///
    /// # Errors
    /// [`ArrayError::Memory`] before anything is read, and all errors of reading.
    pub fn into_array(self) -> Result<Array, ArrayError> {
        let mut values = memory::allocate(self.total())?;
        values.resize(self.total(), 0.0);
        let shape = self.shape.clone();
        // Axes in the order of the file, fastest first: length, and stride in row-major order.
        let mut stride = 1;
        let mut axes: Vec<(usize, usize)> = (shape.iter().rev())
            .map(|&length| {
                let own = stride;
                stride *= length;
                (length, own)
            })
            .collect();
        if self.fortran {
            axes.reverse();
        }
        let mut index = vec![0; axes.len()];
        let mut position = 0;
        for value in self {
            values[position] = value?;
            for (index, (length, stride)) in index.iter_mut().zip(&axes) {
                *index += 1;
                position += stride;
                if *index < *length {
                    break;
                }
                position -= length * stride;
                *index = 0;
            }
        }
        Ok(Array { shape, values })
    }
}

impl<R: Read> Iterator for ArrayReader<R> {
    type Item = Result<f64, ArrayError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.have == self.need {
            return None;
        }
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..self.element.size];
        if let Err(error) = self.source.read_exact(bytes) {
            let (have, need) = (self.have, self.need);
            self.have = need;
            return Some(Err(match error.kind() {
                io::ErrorKind::UnexpectedEof => ArrayError::CutShort { have, need },
                _ => damaged(error),
            }));
        }
        self.have += self.element.size as u64;
        // An archive verifies its checksum at the end of the data.
        if self.have == self.need
            && let Err(error) = self.source.read(&mut [0])
        {
            return Some(Err(damaged(error)));
        }
        let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        let bits = if self.element.big_endian {
            bytes.iter().fold(0, join)
        } else {
            bytes.iter().rev().fold(0, join)
        };
        Some(Ok((self.element.number)(bits)))
    }
}

/// Keeps the first line of a library's message: syntax errors include a copy of the header.
fn damaged(error: io::Error) -> ArrayError {
    let reason = error.to_string();
    let line = reason.lines().next().unwrap_or_default();
    let words = line.split(" --> ").next().unwrap_or_default();
    ArrayError::Damaged(words.trim_end_matches([' ', ':']).to_owned())
}

/// Reads the preamble and the header, if its length is within the limit.
fn header(source: &mut impl Read) -> Result<Vec<u8>, ArrayError> {
    // Magic bytes, version, and a length of two bytes (four in later versions).
    let mut text = vec![0; 10];
    source.read_exact(&mut text).map_err(damaged)?;
    if !text.starts_with(b"\x93NUMPY") {
        return Err(ArrayError::Damaged(
            "it does not start with the NumPy magic bytes".to_owned(),
        ));
    }
    if text[6] > 1 {
        text.resize(12, 0);
        source.read_exact(&mut text[10..]).map_err(damaged)?;
    }
    let begin = text.len();
    let length = text[8..]
        .iter()
        .rev()
        .fold(0, |all, &byte| all << 8 | usize::from(byte));
    if length > MAX_HEADER {
        return Err(ArrayError::Damaged(format!(
            "its header has {length} bytes, above the limit of {MAX_HEADER}"
        )));
    }
    text.resize(begin + length, 0);
    source.read_exact(&mut text[begin..]).map_err(damaged)?;
    if nesting(&text[begin..]) > MAX_NESTING {
        return Err(ArrayError::Damaged(
            "its header is nested too deeply".to_owned(),
        ));
    }
    Ok(text)
}

/// Maximum nesting of the brackets of a header.
fn nesting(header: &[u8]) -> usize {
    let mut depth = 0_usize;
    let mut deepest = 0;
    for byte in header {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(depth);
    }
    deepest
}

/// Binary format of a type, and its relative rounding error.
fn element_type(dtype: &DType) -> Result<(ElementType, f64), ArrayError> {
    let unsupported = || ArrayError::Unsupported(dtype.descr());
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
    let big_endian = plain.endianness() == Endianness::Big;
    Ok((
        ElementType {
            size,
            big_endian,
            number,
        },
        rounding,
    ))
}
