//! The arguments of the program.

use std::ffi::OsString;
use std::sync::OnceLock;

/// Those of the process differ if another program, such as Python, runs the command line.
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the arguments, of which the first is the name or path of the program. Only the first call has an effect.
pub(super) fn set_words(words: &[OsString]) {
    let _ = WORDS.set(words.to_owned());
}

/// The arguments, of which the first is the name or path of the program; empty before they are set.
pub(super) fn words() -> &'static [OsString] {
    WORDS.get().map_or(&[], Vec::as_slice)
}
