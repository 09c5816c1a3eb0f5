//! NumPy arrays in files: one in a `.npy`, named ones in a `.npz`.
//!
//! Other programs write them in many ways: single or double precision, integers, little or big
//! endian, C or Fortran order, compressed or not. All of these are read; what is no real number is
//! refused by name. The format is that of the NumPy enhancement proposal 1.

mod array;
mod npz;

pub use array::{Array, ArrayProblem, RawArray};
pub(crate) use npz::NpzWriter;
pub use npz::{Npz, NpzError, encode_npz, read_npz};
