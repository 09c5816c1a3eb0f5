//! One array: from the bytes of a `.npy` file to numbers.

use std::io::{self, Read};

use npyz::{DType, Endianness, NpyHeader, Order, TypeChar};

use crate::memory::{self, MemoryShortage};

/// Brackets within brackets in a header; the time to parse it grows exponentially with them. A
/// record of arrays, which is not read here, has five.
const DEEPEST: usize = 8;

/// The longest header, bytes: the most that version 1.0 of the format can have. NumPy itself reads
/// 10,000.
const LONGEST_HEADER: usize = 65_535;

/// Bytes that are read at once.
const BLOCK: usize = 1 << 16;

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

/// Why the bytes of an array give no numbers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArrayProblem {
    /// They do not follow the format.
    #[error("it is damaged: {0}; save it again")]
    Damaged(String),
    /// They are no real numbers.
    #[error("its type is {0}, which is not read; save real numbers (a float or an integer type)")]
    Unsupported(String),
    /// They end before their time.
    #[error("it is cut short: {have} bytes where {need} are announced; save it again")]
    CutShort {
        /// Bytes there.
        have: u64,
        /// Bytes announced.
        need: u64,
    },
    /// There are more than are read.
    #[error("it has {have} numbers, and {most} are read of one file; save fewer")]
    TooLarge {
        /// Numbers in it.
        have: usize,
        /// The most that are still read.
        most: usize,
    },
    /// They do not fit into the memory.
    #[error("{0}; save fewer numbers")]
    Memory(#[from] MemoryShortage),
}

/// An array in a file, its numbers still unread.
///
/// As an iterator it gives the numbers in the file's order, and holds one block of them at a time. After
/// an error it ends.
pub struct ArrayReader<R> {
    shape: Vec<usize>,
    fortran: bool,
    rounding: f64,
    kind: Kind,
    source: R,
    /// Bytes of numbers announced, and those of them that are read.
    need: u64,
    have: u64,
    block: Vec<u8>,
    /// The next number in the block.
    next: usize,
}

/// How a number is written.
struct Kind {
    /// Bytes of one.
    size: usize,
    big_endian: bool,
    /// The number that its bytes, the least significant first, make.
    number: fn(u64) -> f64,
}

impl<R: Read> ArrayReader<R> {
    /// Reads the header of a `.npy` file of so many bytes.
    ///
    /// # Errors
    /// If it does not follow the format, announces more than the file has, or something else than real
    /// numbers.
    pub fn open(mut source: R, length: u64) -> Result<Self, ArrayProblem> {
        let text = header(&mut source)?;
        let header = NpyHeader::from_reader(&text[..]).map_err(damaged)?;
        let shape: Vec<usize> = header.shape().iter().map(|&n| n as usize).collect();
        let (kind, rounding) = kind(&header.dtype())?;
        let count = shape.iter().try_fold(1_usize, |all, &n| all.checked_mul(n));
        let need = count
            .and_then(|count| count.checked_mul(kind.size))
            .ok_or_else(|| ArrayProblem::Damaged("its shape is beyond all bounds".to_owned()))?;
        let (have, need) = (length.saturating_sub(text.len() as u64), need as u64);
        if have < need {
            return Err(ArrayProblem::CutShort { have, need });
        }
        Ok(Self {
            shape,
            fortran: header.order() == Order::Fortran,
            rounding,
            kind,
            source,
            need,
            have: 0,
            block: Vec::new(),
            next: 0,
        })
    }

    /// Length along each axis; empty for a single number.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Whether the first axis changes fastest in the file.
    pub fn fortran(&self) -> bool {
        self.fortran
    }

    /// Relative rounding of the type in the file; 0 for integers.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// How many numbers it has.
    pub fn total(&self) -> usize {
        self.shape.iter().product()
    }

    /// All numbers, in row-major order.
    ///
    /// # Errors
    /// [`ArrayProblem::Memory`] before anything is read, and what reading meets.
    pub fn into_array(self) -> Result<Array, ArrayProblem> {
        let mut values = memory::room(self.total())?;
        values.resize(self.total(), 0.0);
        let shape = self.shape.clone();
        // The axes, that which changes fastest in the file first: length, and distance of one index to the
        // next in row-major order.
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
        let mut place = 0;
        for value in self {
            values[place] = value?;
            for (index, (length, stride)) in index.iter_mut().zip(&axes) {
                *index += 1;
                place += stride;
                if *index < *length {
                    break;
                }
                place -= length * stride;
                *index = 0;
            }
        }
        Ok(Array { shape, values })
    }

    /// Reads the next block; false after the last.
    fn fill(&mut self) -> Result<bool, ArrayProblem> {
        let whole = BLOCK - BLOCK % self.kind.size;
        let wanted = (self.need - self.have).min(whole as u64);
        self.block.clear();
        self.next = 0;
        let mut part = self.source.by_ref().take(wanted);
        part.read_to_end(&mut self.block).map_err(damaged)?;
        self.have += self.block.len() as u64;
        if (self.block.len() as u64) < wanted {
            return Err(ArrayProblem::CutShort {
                have: self.have,
                need: self.need,
            });
        }
        if wanted > 0 && self.have == self.need {
            // An archive compares its checksum when there is nothing left.
            self.source.read(&mut [0]).map_err(damaged)?;
        }
        Ok(wanted > 0)
    }
}

impl<R: Read> Iterator for ArrayReader<R> {
    type Item = Result<f64, ArrayProblem>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.next == self.block.len() {
            match self.fill() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(problem) => {
                    self.have = self.need;
                    self.block.clear();
                    return Some(Err(problem));
                }
            }
        }
        let bytes = &self.block[self.next..self.next + self.kind.size];
        self.next += self.kind.size;
        let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        let bits = match self.kind.big_endian {
            true => bytes.iter().fold(0, join),
            false => bytes.iter().rev().fold(0, join),
        };
        Some(Ok((self.kind.number)(bits)))
    }
}

/// What a library says, in one line: to a syntax error it adds a picture of the header.
fn damaged(error: io::Error) -> ArrayProblem {
    let reason = error.to_string();
    let line = reason.lines().next().unwrap_or_default();
    let words = line.split(" --> ").next().unwrap_or_default();
    ArrayProblem::Damaged(words.trim_end_matches([' ', ':']).to_owned())
}

/// The header with all that is before it, of a length that can be parsed.
fn header(source: &mut impl Read) -> Result<Vec<u8>, ArrayProblem> {
    // Magic, version and a length of two bytes, in later versions of four.
    let mut text = vec![0; 10];
    source.read_exact(&mut text).map_err(damaged)?;
    if !text.starts_with(b"\x93NUMPY") {
        return Err(ArrayProblem::Damaged(
            "it does not begin as an array".to_owned(),
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
    if length > LONGEST_HEADER {
        return Err(ArrayProblem::Damaged(format!(
            "its header has {length} bytes, above {LONGEST_HEADER}"
        )));
    }
    text.resize(begin + length, 0);
    source.read_exact(&mut text[begin..]).map_err(damaged)?;
    if nesting(&text[begin..]) > DEEPEST {
        return Err(ArrayProblem::Damaged(
            "its header is nested too deeply".to_owned(),
        ));
    }
    Ok(text)
}

/// How deeply the brackets of a header are nested.
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

/// How numbers of a type are written, and their relative rounding.
fn kind(dtype: &DType) -> Result<(Kind, f64), ArrayProblem> {
    let unsupported = || ArrayProblem::Unsupported(dtype.descr());
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
        Kind {
            size,
            big_endian,
            number,
        },
        rounding,
    ))
}
