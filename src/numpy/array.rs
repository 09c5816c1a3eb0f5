//! One array: from the bytes of a `.npy` file to numbers.

use npyz::{DType, Deserialize, NpyFile, NpyHeader, Order, TypeChar};

/// Brackets within brackets in a header; the time to parse it grows exponentially with them. A
/// record of arrays, which is not read here, has five.
const DEEPEST: usize = 8;

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
}

/// An array as it is in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct RawArray {
    /// Length along each axis; empty for a single number.
    pub shape: Vec<usize>,
    /// Whether the first axis changes fastest.
    pub fortran: bool,
    /// The numbers in the file's order; none if an axis has no length.
    pub values: Vec<f64>,
    /// Relative rounding of their type in the file; 0 for integers.
    pub rounding: f64,
}

impl RawArray {
    /// Reads the bytes of a `.npy` file.
    ///
    /// # Errors
    /// If they do not follow the format, end too early, or hold something else than real numbers.
    pub fn decode(bytes: &[u8]) -> Result<Self, ArrayProblem> {
        if nesting(bytes) > DEEPEST {
            return Err(ArrayProblem::Damaged(
                "its header is nested too deeply".to_owned(),
            ));
        }
        let damaged = |error: std::io::Error| ArrayProblem::Damaged(error.to_string());
        let mut rest = bytes;
        let header = NpyHeader::from_reader(&mut rest).map_err(damaged)?;
        let file = NpyFile::with_header(header, rest);
        let shape: Vec<usize> = file.shape().iter().map(|&n| n as usize).collect();
        let dtype = file.dtype();
        let unsupported = || ArrayProblem::Unsupported(dtype.descr());
        let DType::Plain(kind) = &dtype else {
            return Err(unsupported());
        };
        let size = kind.num_bytes().ok_or_else(unsupported)?;
        let count = shape.iter().try_fold(1_usize, |all, &n| all.checked_mul(n));
        let need = count
            .and_then(|count| count.checked_mul(size))
            .ok_or_else(|| ArrayProblem::Damaged("its shape is beyond all bounds".to_owned()))?;
        if rest.len() < need {
            return Err(ArrayProblem::CutShort {
                have: rest.len() as u64,
                need: need as u64,
            });
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
        Ok(Self {
            shape,
            fortran,
            values: values.map_err(damaged)?,
            rounding,
        })
    }

    /// The same numbers in row-major order.
    pub fn into_row_major(self) -> Array {
        let Self { shape, values, .. } = self;
        if !self.fortran || shape.len() < 2 {
            return Array { shape, values };
        }
        // Distance in the file from one index of each axis to the next.
        let strides: Vec<usize> = shape
            .iter()
            .scan(1, |stride, &length| {
                let own = *stride;
                *stride *= length;
                Some(own)
            })
            .collect();
        let mut index = vec![0; shape.len()];
        let mut rows = Vec::with_capacity(values.len());
        while rows.len() < values.len() {
            let at: usize = index
                .iter()
                .zip(&strides)
                .map(|(i, stride)| i * stride)
                .sum();
            rows.push(values[at]);
            for axis in (0..shape.len()).rev() {
                index[axis] += 1;
                if index[axis] < shape[axis] {
                    break;
                }
                index[axis] = 0;
            }
        }
        Array {
            shape,
            values: rows,
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

fn numbers<T: Deserialize>(
    file: NpyFile<&[u8]>,
    to: impl Fn(T) -> f64,
) -> std::io::Result<Vec<f64>> {
    Ok(file.into_vec::<T>()?.into_iter().map(to).collect())
}
