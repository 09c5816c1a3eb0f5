//! The header of a WAV file, replaced by one that the library symphonia decodes.
//!
//! A RIFF file is a sequence of chunks, each with an identifier, a length and its bytes. `fmt ` describes the
//! coding of the samples, and `data` contains them, channel by channel for each instant (Multimedia Programming
//! Interface and Data Specifications 1.0, IBM and Microsoft, 1991; the extensible form: Microsoft, 2007). RF64 has
//! 64-bit lengths in a separate chunk (EBU Tech 3306, 2009).
//!
//! The lengths in a header may be wrong: a recorder that loses its power leaves zeros, and a copy may be truncated. Then
//! the samples up to the end of the file count.

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};

use symphonia::core::io::{MediaSource, ReadOnlySource};

use super::Problem;
use super::sound::Form;

const FORMAT: &str = "WAV";

/// Length that means "until the end", used by programs that do not know the length in advance.
const OPEN_END: u32 = u32::MAX;

/// Number of bytes of a chunk that are evaluated.
const MAX_CHUNK_READ: u64 = 1024;

/// A content for the library; the sample rate (Hz) and the number of channels of a WAV file, whose samples are the rest of
/// the content; and what is wrong with the lengths in the header.
///
/// The new header states a rate of 1 Hz for 0, as the library would refuse that, and one channel with the samples of all
/// of them, as the library knows 26 channels at most.
type Input = (Box<dyn MediaSource>, Option<Form>, Option<String>);

/// Replaces the header of a WAV file; other sound stays as it is.
pub(super) fn with_normal_header(mut file: File) -> Result<Input, Problem> {
    let mut start = Vec::new();
    (&mut file).take(4).read_to_end(&mut start)?;
    if start != b"RIFF" && start != b"RF64" {
        file.rewind()?;
        return Ok((Box::new(file), None, None));
    }
    let mut content = BufReader::new(file);
    let (format, length, damage) = chunks(&mut content)?;
    let (mut format, frame, channels) = normal_format(format)?;
    let rate = u32_at(&format, 4);
    format[4..8].copy_from_slice(&rate.max(1).to_le_bytes());
    let whole = length - length % frame;
    if whole == 0 {
        return Err(Problem::no_samples("a header"));
    }
    let incomplete = (whole < length).then(|| "its last sample is incomplete".to_owned());
    let mut header = b"RIFF\xff\xff\xff\xffWAVEfmt ".to_vec();
    header.extend((format.len() as u32).to_le_bytes());
    header.extend(format);
    header.extend(b"data");
    header.extend(u32::try_from(whole).unwrap_or(OPEN_END).to_le_bytes());
    let content = ReadOnlySource::new(Cursor::new(header).chain(content.take(whole)));
    let damage = damage.or(incomplete);
    Ok((Box::new(content), Some((rate, channels)), damage))
}

/// Reads a content up to its samples: the format chunk, the number of bytes of samples, and what is wrong with the
/// stated number.
fn chunks(content: &mut BufReader<File>) -> Result<(Vec<u8>, u64, Option<String>), Problem> {
    let end = content.seek(SeekFrom::End(0))?;
    content.rewind()?;
    let mut riff = [0; 12];
    content.read_exact(&mut riff)?;
    let is_closed = u64::from(u32_at(&riff, 4)) + 8 == end;
    let (mut long_data, mut format) = (None, None);
    let mut at = 12;
    while at + 8 <= end {
        let mut head = [0; 8];
        content.read_exact(&mut head)?;
        let rest = end - at - 8;
        let is_data = &head[..4] == b"data";
        let stated = match u32_at(&head, 4) {
            OPEN_END if is_data => long_data.unwrap_or(rest),
            length => length.into(),
        };
        if is_data {
            let format = format.ok_or_else(|| damaged("the data have no `fmt ` chunk"))?;
            let length = if stated == 0 && !is_closed {
                rest
            } else {
                stated.min(rest)
            };
            let damage = (length != stated).then(|| {
                format!("its header states {stated} bytes of samples, and the file has {length}")
            });
            return Ok((format, length, damage));
        }
        let mut chunk = Vec::new();
        let read = stated.min(MAX_CHUNK_READ);
        content.take(read).read_to_end(&mut chunk)?;
        match &head[..4] {
            b"ds64" if chunk.len() >= 16 => {
                let long = chunk[8..16].try_into().unwrap_or_default();
                long_data = Some(u64::from_le_bytes(long));
            }
            b"fmt " => format = Some(chunk),
            _ => {}
        }
        // Chunks start at even positions.
        at += 8 + stated + stated % 2;
        // Keeps the buffer, which would otherwise be refilled for each of many small chunks.
        content.seek_relative((stated + stated % 2 - read) as i64)?;
    }
    Err(damaged("the `data` chunk is missing"))
}

/// A format chunk for the library, the bytes of an instant or a block, and the number of channels.
fn normal_format(mut chunk: Vec<u8>) -> Result<(Vec<u8>, u64, usize), Problem> {
    if chunk.len() < 16 {
        return Err(damaged("the `fmt ` chunk is too short"));
    }
    let tag = match u16_at(&chunk, 0) {
        // The extensible form has the tag at the start of a longer identifier.
        0xFFFE if chunk.len() >= 26 => u16_at(&chunk, 24),
        tag => tag,
    };
    let [channels, frame, bits] = [2, 12, 14].map(|at| usize::from(u16_at(&chunk, at)));
    match (tag, bits) {
        // PCM, floats, A-law, mu-law.
        (1, 1..=32) | (3, 32 | 64) | (6 | 7, 8) => {}
        // ADPCM of Microsoft or of the IMA: blocks of several samples.
        (2 | 17, 4) if frame > 0 => return Ok((chunk, frame as u64, channels)),
        _ => {
            return Err(Problem::unsupported(
                format!("the WAV coding {tag} with {bits} bits per sample"),
                "save it as PCM of 8 to 32 bits, as float of 32 or 64 bits, A-law, mu-law or ADPCM",
            ));
        }
    }
    // Integers may not use the lowest bits of their bytes.
    let width = bits.div_ceil(8);
    if channels == 0 || frame != channels * width {
        return Err(damaged(&format!(
            "its header states {channels} x {bits} bits per sample, but a block size of {frame} x 8 bits"
        )));
    }
    let rate = u32_at(&chunk, 4);
    let bytes = rate.wrapping_mul(width as u32);
    chunk = [tag, 1].map(u16::to_le_bytes).concat();
    chunk.extend([rate, bytes].map(u32::to_le_bytes).concat());
    chunk.extend(
        [width as u16, 8 * width as u16, 0]
            .map(u16::to_le_bytes)
            .concat(),
    );
    Ok((chunk, frame as u64, channels))
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn damaged(what: &str) -> Problem {
    Problem::damaged(FORMAT, what)
}
