//! Which format a file has: its content decides, its name may lie.

use std::path::Path;
use std::{fs, io};

use super::Problem;

/// The formats, for messages.
pub(super) const KNOWN: &str = "WAV, CSV (or other columns of text), .npy, .npz, .rrd";

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Sampled sound.
    Wav,
    /// Columns of numbers as text.
    Text,
    /// A NumPy array.
    Npy,
    /// Several NumPy arrays.
    Npz,
    /// A Rerun recording.
    Rrd,
}

/// How much of the beginning tells text from other bytes.
const TASTE: usize = 8192;

impl Format {
    /// The format of a file.
    ///
    /// # Errors
    /// If it cannot be read, is empty or of no known format.
    pub fn of(path: &Path) -> Result<Self, Problem> {
        Self::of_bytes(&bytes(path)?, path)
    }

    /// The format of a content; `path` is for the message.
    pub(super) fn of_bytes(bytes: &[u8], path: &Path) -> Result<Self, Problem> {
        let begins = |magic: &[u8]| bytes.starts_with(magic);
        let is_riff = [b"RIFF", b"RF64"].iter().any(|magic| begins(*magic));
        if is_riff && bytes.get(8..12) == Some(b"WAVE") {
            Ok(Self::Wav)
        } else if begins(b"\x93NUMPY") {
            Ok(Self::Npy)
        } else if begins(b"PK\x03\x04") || begins(b"PK\x05\x06") {
            Ok(Self::Npz)
        } else if begins(b"RRF") {
            Ok(Self::Rrd)
        } else if is_text(bytes) {
            Ok(Self::Text)
        } else {
            let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
            let known = ["wav", "csv", "tsv", "txt", "dat", "npy", "npz", "rrd"];
            Err(Problem::UnknownFormat {
                called: extension.filter(|e| known.contains(&e.as_str())),
            })
        }
    }
}

/// Whether no byte at the beginning is a control character other than those of text.
fn is_text(bytes: &[u8]) -> bool {
    let control = |&byte: &u8| byte < 32 && !byte.is_ascii_whitespace();
    !bytes.iter().take(TASTE).any(control)
}

/// The content of a file.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, Problem> {
    if path.is_dir() {
        return Err(Problem::Directory);
    }
    // Some devices never end. A pipe may be what another program writes into.
    if fs::metadata(path).is_ok_and(|about| is_device(about.file_type())) {
        return Err(Problem::Device);
    }
    let bytes = fs::read(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Problem::Missing,
        _ => Problem::Unreadable(error),
    })?;
    if bytes.is_empty() {
        return Err(Problem::Empty);
    }
    Ok(bytes)
}

#[cfg(unix)]
fn is_device(kind: fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: fs::FileType) -> bool {
    false
}
