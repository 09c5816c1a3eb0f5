//! NumPy arrays in files: one in a `.npy`, named ones in a `.npz`.
//!
//! Other programs write them in many ways: single or double precision, integers, little or big
//! endian, C or Fortran order, compressed or not. All of these are read; what is no real number is
//! refused by name. The format is that of the NumPy enhancement proposal 1.
//!
//! An [`ArrayReader`] knows shape and type from the header, and gives the numbers block by block. What is
//! read as a whole has at most [`MOST_NUMBERS`] numbers a file, 8 bytes each however few they have in
//! it, and only if there is so much memory.

mod array;
mod npz;

pub use array::{Array, ArrayProblem, ArrayReader};
pub(crate) use npz::NpzWriter;
pub use npz::{MOST_NUMBERS, Npz, NpzError, encode_npz, read_npz};
