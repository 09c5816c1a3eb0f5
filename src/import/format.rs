//! Detection of the file format from its content.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::Problem;
use super::sound::CONVERT;
use super::uff::is_universal;
use crate::foreign::open_file;

/// Block size for reading, bytes.
pub(super) const BLOCK: usize = 1 << 16;

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Sound: WAV, AIFF, and compressed.
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
    /// The ending of a name, in lower case, if it is that of a format.
    pub fn ending(path: &Path) -> Option<&'static str> {
        let known =
            "wav flac mp3 aac m4a mp4 ogg opus aiff csv tsv txt dat uff unv npy npz mat rrd";
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        known.split(' ').find(|known| *known == ending)
    }

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
        let at = |place, magic: &[u8]| head.get(place..place + magic.len()) == Some(magic);
        let begins = |magics: &[&[u8]]| magics.iter().any(|magic| head.starts_with(magic));
        Ok(if begins(&[b"\x93NUMPY"]) {
            Self::Npy
        } else if begins(&[b"PK\x03\x04", b"PK\x05\x06"]) {
            Self::Npz
        } else if begins(&[b"RRF"]) {
            Self::Rrd
        } else if begins(&[b"fLaC", b"OggS", b"ID3"])
            || at(4, b"ftyp")
            || begins(&[b"RIFF", b"RF64"]) && at(8, b"WAVE")
            || begins(&[b"FORM"]) && (at(8, b"AIFF") || at(8, b"AIFC"))
        {
            Self::Sound
        } else if begins(&[
            b"caff\x00",
            b"#!AMR",
            b"riff\x2e\x91\xcf\x11",
            b".snd\x00",
            b"\x30\x26\xb2\x75",
            b"\x1a\x45\xdf\xa3",
        ]) {
            // Core Audio, AMR, Wave64, AU, Windows Media, Matroska and WebM.
            return Err(Problem::unsupported("this kind of sound", CONVERT));
        } else if begins(&[b"MATLAB 5.0"]) {
            Self::Mat
        } else if begins(&[b"MATLAB 7.3", b"\x89HDF"]) {
            return Err(Problem::unsupported(
                "an HDF5 file, such as MATLAB writes with -v7.3,",
                "save it with -v7 in MATLAB, or as .npz in Python (h5py, numpy.savez)",
            ));
        } else if begins(&[b"TDSm"]) {
            return Err(Problem::unsupported(
                "a TDMS file",
                "export it as text (.lvm or CSV) in LabVIEW, or as .npz in Python (nptdms, numpy.savez)",
            ));
        } else if is_universal(&head) {
            Self::Universal
        } else if begins(&[b"\xff\xfe", b"\xfe\xff"]) || is_text(&head) {
            Self::Text
        } else if head[0] == 0xFF
            && head
                .get(1)
                .is_some_and(|second| second & 0xE6 == 0xE2 || second & 0xF6 == 0xF0)
        {
            // A frame of MP3 (11 bits set, layer III) or of AAC (12 bits set, layer 0) without a tag before it.
            Self::Sound
        } else {
            return Err(unknown(path));
        })
    }
}

/// The error for a content of no known format.
fn unknown(path: &Path) -> Problem {
    let called = Format::ending(path).map_or_else(String::new, |extension| {
        format!(" (the extension is .{extension}, but the content is different)")
    });
    Problem::Content(format!(
        "unknown file format{called}; convert the file to one of: WAV, FLAC, MP3, M4A, Ogg, AIFF, CSV (or other columns of \
         text), .uff, .npy, .npz, .mat, .rrd"
    ))
}

/// Whether the bytes contain no control characters except those of text.
fn is_text(bytes: &[u8]) -> bool {
    let control = |&byte: &u8| byte < 32 && !byte.is_ascii_whitespace();
    !bytes.iter().any(control)
}
