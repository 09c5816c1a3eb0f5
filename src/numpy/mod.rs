//! NumPy arrays in files: one in a `.npy`, named ones in a `.npz`.
//!
//! Reads single and double precision, integers, little and big endian, C and Fortran order, compressed
//! or not. Types other than real numbers are rejected by name. The format is that of the NumPy
//! enhancement proposal 1.
//!
//! The values of an array are read block by block. Arrays read as a whole have at most [`MAX_NUMBERS`] values
//! per file, 8 bytes each in memory for any type in the file, and are read only if the memory is available.

mod array;
mod npz;

pub use array::Array;
pub(crate) use array::ArrayReader;
pub(crate) use npz::write_array;
pub use npz::{MAX_NUMBERS, Npz, encode_npz, read_npz};
