//! Reading files that may be damaged or hostile: no length in them is trusted.
//!
//! Libraries that decode such files allocate what a header claims and panic on unexpected data. The functions
//! here compare lengths with the file size before anything is allocated, and convert a panic to an error.

#[cfg(any(feature = "record", feature = "table"))]
pub(crate) mod arrow;
mod problem;
#[cfg(feature = "table")]
pub(crate) mod table;

pub use problem::Problem;
pub(crate) use problem::shortened;

use std::cell::Cell;
use std::fmt::Display;
use std::fs::File;
use std::io;
#[cfg(any(feature = "record", feature = "table"))]
use std::io::Read;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Once;

/// Opens a file and returns its length, bytes. Folders, pipes and devices are rejected: they have no length
/// to compare claims with, and some are infinite.
///
/// # Errors
/// If it is not a regular file or cannot be opened.
pub(crate) fn open_file(path: &Path) -> io::Result<(File, u64)> {
    // Checked before opening, which blocks on a pipe.
    let about = path.metadata()?;
    if about.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !about.is_file() {
        return Err(io::Error::other(
            "this is a pipe or a device, not a regular file",
        ));
    }
    Ok((File::open(path)?, about.len()))
}

/// Reads exactly `count` bytes. Allocates according to the data read, not to `count`.
///
/// # Errors
/// If reading fails or fewer are left.
#[cfg(any(feature = "record", feature = "table"))]
pub(crate) fn read_exactly(reader: &mut impl Read, count: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(count).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == count {
        Ok(bytes)
    } else {
        Err(truncated())
    }
}

/// The error for data that end too early.
#[cfg(any(feature = "record", feature = "table"))]
fn truncated() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "the data are truncated")
}

/// The rows of a CSV text with the numbers of their lines: the fields without surrounding blanks. Comments after `#` and
/// empty lines are left out.
pub(crate) fn csv_rows(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    let lines = (1..).zip(text.trim_start_matches('\u{feff}').lines());
    let rows = lines.map(|(line, row)| (line, row.split('#').next().unwrap_or_default().trim()));
    let rows = rows.filter(|(_, row)| !row.is_empty());
    rows.map(|(line, row)| (line, row.split(',').map(str::trim).collect()))
}

/// Maximum length of a library message, characters: some contain the unreadable data.
const SHOWN: usize = 120;

/// First line of a library message.
pub(crate) fn one_line(reason: impl Display) -> String {
    let reason = reason.to_string();
    let line = reason.lines().next().unwrap_or_default();
    line.chars().take(SHOWN).collect()
}

thread_local! {
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Calls a library that may panic on damaged data; `None` if it panics. The panic message is suppressed on
/// this thread only.
pub(crate) fn without_panic<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !IS_QUIET.get() {
                usual(info);
            }
        }));
    });
    let before = IS_QUIET.replace(true);
    // The caller drops the inconsistent state left by a panic.
    let done = catch_unwind(AssertUnwindSafe(work));
    IS_QUIET.set(before);
    done.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "five!").unwrap();
        assert_eq!(open_file(&file).unwrap().1, 5);
        for path in [folder.path(), &folder.path().join("missing")] {
            assert!(open_file(path).is_err());
        }
        if cfg!(unix) {
            let refused = open_file(Path::new("/dev/zero")).unwrap_err();
            assert!(refused.to_string().contains("device"), "{refused}");
        }
    }

    #[test]
    fn a_claimed_length_beyond_the_end_allocates_nothing() {
        let mut bytes = &b"abc"[..];
        assert_eq!(read_exactly(&mut bytes, 2).unwrap(), b"ab");
        assert!(read_exactly(&mut bytes, u64::MAX).is_err());
    }

    #[test]
    fn a_message_is_shortened_to_one_line() {
        assert_eq!(one_line("out of range\n\twhile verifying"), "out of range");
        assert_eq!(one_line("ä".repeat(SHOWN + 1)), "ä".repeat(SHOWN));
        assert_eq!(one_line(""), "");
    }

    #[test]
    fn a_panic_is_none_and_outer_calls_are_unaffected() {
        assert_eq!(without_panic(|| 1), Some(1));
        let inner = || without_panic(|| panic!("the inner one"));
        let outer: Option<()> = without_panic(|| {
            assert_eq!(inner(), None::<()>);
            assert!(IS_QUIET.get());
            panic!("the outer one")
        });
        assert_eq!(outer, None);
        assert!(!IS_QUIET.get());
    }
}
