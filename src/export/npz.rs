//! Named arrays of doubles as a file of its own.

use std::path::Path;

use super::{OutputError, replace_file};
use crate::numpy::{Array, encode_npz};

/// Writes arrays under their names to a file. The same arrays give the same bytes.
///
/// # Errors
/// If the file cannot be written; an older one of that name is then untouched.
pub fn write_npz(path: &Path, arrays: &[(&str, Array)]) -> Result<(), OutputError> {
    replace_file(path, |file| encode_npz(file, arrays))
}
