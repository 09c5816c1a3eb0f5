//! Detection of the file format from its content.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::Problem;
use super::uff::is_universal;
use crate::foreign::open_file;

/// Block size for reading, bytes.
pub(super) const BLOCK: usize = 1 << 16;

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Sampled sound.
    Wav,
    /// Other sound: AIFF, and compressed.
    Sound,
    /// Columns of numbers as text.
    Text,
    /// A NumPy array.
    Npy,
    /// Several NumPy arrays.
    Npz,
    /// A MATLAB file.
    Mat,
    /// A universal file.
    Universal,
    /// A Rerun recording.
    Rrd,
}

/// Number of bytes from which the format is detected.
const HEAD: usize = 8192;

impl Format {
    /// The format of a file.
    ///
    /// # Errors
    /// If the file cannot be read, is empty or has no known format.
    pub fn of(path: &Path) -> Result<Self, Problem> {
        Self::of_content(&mut open_file(path)?.0, path)
    }

    /// The format of a content, which is then rewound; `path` is used for the message.
    pub(super) fn of_content(
        content: &mut (impl Read + Seek),
        path: &Path,
    ) -> Result<Self, Problem> {
        let mut head = Vec::new();
        content.by_ref().take(HEAD as u64).read_to_end(&mut head)?;
        content.seek(SeekFrom::Start(0))?;
        if head.is_empty() {
            let text = "the file is empty; record or export it again";
            return Err(Problem::Content(text.to_owned()));
        }
        let bytes = &head[..];
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
        } else if is_sound(bytes) {
            Ok(Self::Sound)
        } else if begins(b"MATLAB 5.0") {
            Ok(Self::Mat)
        } else if begins(b"MATLAB 7.3") || begins(b"\x89HDF") {
            Err(Problem::unsupported(
                "an HDF5 file, such as MATLAB writes with -v7.3,",
                "save it with -v7 in MATLAB, or as .npz in Python (h5py, numpy.savez)",
            ))
        } else if begins(b"TDSm") {
            Err(Problem::unsupported(
                "a TDMS file",
                "export it as text (.lvm or CSV) in LabVIEW, or as .npz in Python (nptdms, numpy.savez)",
            ))
        } else if is_universal(bytes) {
            Ok(Self::Universal)
        } else if begins(b"\xff\xfe") || begins(b"\xfe\xff") || is_text(bytes) {
            Ok(Self::Text)
        } else {
            let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
            // An MP3 file without a tag begins with a frame: 11 bits set, layer III.
            if bytes[0] == 0xFF && bytes.get(1).is_some_and(|second| second & 0xE6 == 0xE2) {
                return Ok(Self::Sound);
            }
            let known = [
                "wav", "flac", "mp3", "m4a", "mp4", "ogg", "opus", "aiff", "csv", "tsv", "txt",
                "dat", "uff", "unv", "npy", "npz", "mat", "rrd",
            ];
            let called = extension.filter(|e| known.contains(&e.as_str()));
            let called = called.map_or_else(String::new, |e| {
                format!(" (the extension is .{e}, but the content is different)")
            });
            Err(Problem::Content(format!(
                "unknown file format{called}; convert the file to one of: WAV, FLAC, MP3, M4A, Ogg, AIFF, CSV (or other \
                 columns of text), .uff, .npy, .npz, .mat, .rrd"
            )))
        }
    }
}

/// Whether a content is FLAC, Ogg, MP3 with a tag, MP4, or AIFF with and without compression.
fn is_sound(bytes: &[u8]) -> bool {
    let magics: [&[u8]; 3] = [b"fLaC", b"OggS", b"ID3"];
    magics.iter().any(|magic| bytes.starts_with(magic))
        || bytes.get(4..8) == Some(b"ftyp")
        || bytes.starts_with(b"FORM") && matches!(bytes.get(8..12), Some(b"AIFF" | b"AIFC"))
}

/// Whether the bytes contain no control characters except those of text.
fn is_text(bytes: &[u8]) -> bool {
    let control = |&byte: &u8| byte < 32 && !byte.is_ascii_whitespace();
    !bytes.iter().any(control)
}

/// A file that reports the fraction, 0 to 1, that has been read.
pub(super) struct Reported<'a> {
    file: File,
    length: u64,
    at: u64,
    progress: &'a mut dyn FnMut(f64),
}

impl<'a> Reported<'a> {
    pub fn open(path: &Path, progress: &'a mut dyn FnMut(f64)) -> io::Result<Self> {
        let (file, length) = open_file(path)?;
        Ok(Self {
            file,
            length,
            at: 0,
            progress,
        })
    }
}

impl Read for Reported<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.at += count as u64;
        (self.progress)((self.at as f64 / self.length.max(1) as f64).min(1.0));
        Ok(count)
    }
}

impl Seek for Reported<'_> {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        self.at = self.file.seek(place)?;
        Ok(self.at)
    }
}
