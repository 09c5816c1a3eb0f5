//! WAV: sampled sound.
//!
//! A RIFF file is a sequence of chunks, each with an identifier, a length and its bytes. `fmt ` describes the
//! coding of the samples, and `data` contains them, channel by channel for each instant. Integers are
//! left-aligned in their bytes (8-bit samples have an offset of 128, the others are signed); full scale is
//! therefore `2^(bits - 1)` of the bytes they occupy (Multimedia Programming Interface and Data
//! Specifications 1.0, IBM and Microsoft, 1991; the extensible form: Microsoft, 2007). RF64 has 64-bit
//! lengths in a separate chunk (EBU Tech 3306, 2009).

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;

use super::Problem;
use super::clock::Timing;
use super::format::BLOCK;
use super::table::{ColumnHeader, Source};

const FORMAT: &str = "WAV";

/// Length that means "until the end", used by programs that do not know the length in advance.
const OPEN_END: u32 = u32::MAX;

/// Number of bytes of a chunk that are evaluated.
const MAX_CHUNK_READ: u64 = 40;

/// Coding of the samples.
struct Coding {
    channels: usize,
    rate: u32,
    /// Bytes per sample of one channel.
    width: usize,
    /// Bytes per instant.
    frame: usize,
    /// Converts the bytes of one sample to a number.
    number: fn(&[u8]) -> f64,
}

/// A file whose header has been read.
pub(super) struct Wav<R> {
    content: R,
    coding: Coding,
    /// Position of the first sample, bytes.
    begin: u64,
    /// Number of samples per channel.
    frames: usize,
    /// Name of a single channel.
    stem: String,
}

impl<R: Read + Seek> Wav<R> {
    pub fn open(mut content: R, stem: &str) -> Result<Self, Problem> {
        let (coding, begin, length) = chunks(&mut content)?;
        let frame = coding.frame as u64;
        if !length.is_multiple_of(frame) {
            return Err(cut_short("the last sample", length % frame, frame));
        }
        if length == 0 {
            return Err(Problem::no_samples("a header"));
        }
        Ok(Self {
            content,
            begin,
            frames: (length / frame) as usize,
            coding,
            stem: stem.to_owned(),
        })
    }
}

impl<R: Read + Seek> Source for Wav<R> {
    fn headings(&self) -> Vec<ColumnHeader> {
        channel_headings(self.coding.channels, &self.stem, self.frames)
    }

    fn timing(&self) -> Timing {
        Timing::Rate(f64::from(self.coding.rate))
    }

    fn samples(
        &mut self,
        column: usize,
        range: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        let Coding {
            width,
            frame,
            number,
            ..
        } = self.coding;
        let place = column * width;
        let begin = self.begin + (range.start * frame) as u64;
        self.content.seek(SeekFrom::Start(begin))?;
        let mut block = vec![0; (BLOCK / frame).max(1) * frame];
        let mut left = range.len() * frame;
        while left > 0 {
            let count = left.min(block.len());
            self.content.read_exact(&mut block[..count])?;
            for frame in block[..count].chunks_exact(frame) {
                each(number(&frame[place..place + width]));
            }
            left -= count;
        }
        Ok(())
    }
}

/// Headings of the channels of a sound; a single one has the name `stem`.
pub(super) fn channel_headings(channels: usize, stem: &str, count: usize) -> Vec<ColumnHeader> {
    let name = |channel: usize| match (channels, channel) {
        (1, _) => stem.to_owned(),
        (2, 0) => "left".to_owned(),
        (2, _) => "right".to_owned(),
        _ => channel.to_string(),
    };
    (0..channels)
        .map(|channel| ColumnHeader::with_unit(name(channel), "FS", count))
        .collect()
}

/// Finds the coding, and position and length of the samples, bytes.
fn chunks(content: &mut (impl Read + Seek)) -> Result<(Coding, u64, u64), Problem> {
    let end = content.seek(SeekFrom::End(0))?;
    let mut long_data = None;
    let mut coding = None;
    let mut at = 12;
    content.seek(SeekFrom::Start(at))?;
    while at + 8 <= end {
        let mut head = [0; 8];
        content.read_exact(&mut head)?;
        let rest = end - at - 8;
        let is_data = &head[..4] == b"data";
        let length = match u32_at(&head, 4) {
            OPEN_END if is_data => long_data.unwrap_or(rest),
            length => length.into(),
        };
        if length > rest {
            let name = String::from_utf8_lossy(&head[..4]);
            return Err(cut_short(&format!("the chunk `{name}`"), rest, length));
        }
        if is_data {
            let coding = coding.ok_or_else(|| damaged("the data have no `fmt ` chunk"))?;
            return Ok((coding, at + 8, length));
        }
        let mut chunk = Vec::new();
        let read = length.min(MAX_CHUNK_READ);
        content.by_ref().take(read).read_to_end(&mut chunk)?;
        match &head[..4] {
            b"fmt " => coding = Some(read_coding(&chunk)?),
            b"ds64" if chunk.len() >= 16 => {
                let long = chunk[8..16].try_into().unwrap_or_default();
                long_data = Some(u64::from_le_bytes(long));
            }
            _ => {}
        }
        // Chunks start at even positions.
        at += 8 + length + length % 2;
        // Keeps the buffer, which would otherwise be refilled for each of many small chunks.
        content.seek_relative((length + length % 2 - read) as i64)?;
    }
    Err(damaged("the `data` chunk is missing"))
}

fn read_coding(chunk: &[u8]) -> Result<Coding, Problem> {
    if chunk.len() < 16 {
        return Err(damaged("the `fmt ` chunk is too short"));
    }
    let tag = match u16_at(chunk, 0) {
        // The extensible form has the tag at the start of a longer identifier.
        0xFFFE if chunk.len() >= 26 => u16_at(chunk, 24),
        tag => tag,
    };
    let channels = usize::from(u16_at(chunk, 2));
    let frame = usize::from(u16_at(chunk, 12));
    let width = frame.checked_div(channels).unwrap_or(0);
    let number: fn(&[u8]) -> f64 = match (tag, width) {
        (1, 1) => |b| (f64::from(b[0]) - 128.0) / 128.0,
        (1, 2..=4) => integer,
        (3, 4) => |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        (3, 8) => |b| f64::from_le_bytes(b.try_into().unwrap_or_default()),
        _ => {
            return Err(Problem::unsupported(
                format!("the WAV coding {tag} with {width} bytes per sample"),
                "save it as PCM of 8 to 32 bits, or as float of 32 or 64 bits",
            ));
        }
    };
    let bits = usize::from(u16_at(chunk, 14));
    // Integers may not use the lowest bits of their bytes.
    let fits = bits == 8 * width || (tag == 1 && bits < 8 * width);
    if !fits || frame != channels * width {
        let what = format!(
            "it declares {bits} bits in {width} bytes per sample, and {channels} channels in {frame} bytes"
        );
        return Err(damaged(&what));
    }
    Ok(Coding {
        channels,
        rate: u32_at(chunk, 4),
        width,
        frame,
        number,
    })
}

/// A signed integer of up to four bytes divided by full scale.
fn integer(bytes: &[u8]) -> f64 {
    let mut top = [0; 4];
    top[4 - bytes.len()..].copy_from_slice(bytes);
    f64::from(i32::from_le_bytes(top)) / 2_147_483_648.0
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

fn cut_short(what: &str, have: u64, need: u64) -> Problem {
    Problem::truncated(FORMAT, what, have, need)
}
