//! Named arrays of doubles in a single file.

use std::path::Path;

use super::{OutputError, replace_file};
use crate::numpy::{Array, encode_npz};

/// Writes named arrays to a file. The output is deterministic.
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub fn write_npz(path: &Path, arrays: &[(&str, Array)]) -> Result<(), OutputError> {
    replace_file(path, |file| encode_npz(file, arrays))
}
