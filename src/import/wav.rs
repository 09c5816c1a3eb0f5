//! WAV: sampled sound.
//!
//! A RIFF file is a row of chunks, each an identifier, a length and its bytes. `fmt ` says how
//! samples are coded, `data` holds them, channel after channel for each instant. Integers fill
//! their bytes from the top (8 bits count from 128, the others are signed), so that full scale is
//! `2^(bits - 1)` of the bytes they take (Multimedia Programming Interface and Data
//! Specifications 1.0, IBM and Microsoft, 1991; the extensible form: Microsoft, 2007). RF64 has
//! lengths of 64 bits in a chunk of its own (EBU Tech 3306, 2009).

use super::{Clock, Column, Problem, Table};

const FORMAT: &str = "WAV";

/// A length that says "until the end": written by programs that do not know it beforehand.
const OPEN_END: u32 = u32::MAX;

/// How samples are coded.
struct Coding {
    float: bool,
    channels: usize,
    rate: u32,
    /// Bytes of one sample of one channel.
    width: usize,
}

/// All channels.
pub(super) fn decode(bytes: &[u8], stem: &str) -> Result<Table, Problem> {
    let (coding, data) = chunks(bytes)?;
    let frame = coding.channels * coding.width;
    if !data.len().is_multiple_of(frame) {
        return Err(Problem::CutShort {
            format: FORMAT,
            what: "its last sample".to_owned(),
            have: (data.len() % frame) as u64,
            need: frame as u64,
        });
    }
    if data.is_empty() {
        return Err(Problem::NoSamples("a header"));
    }
    let number = number(&coding)?;
    let columns = (0..coding.channels).map(|channel| {
        let place = channel * coding.width;
        let frames = data.chunks_exact(frame);
        let values = frames.map(|frame| number(&frame[place..place + coding.width]));
        let name = match (coding.channels, channel) {
            (1, _) => stem.to_owned(),
            (2, 0) => "left".to_owned(),
            (2, _) => "right".to_owned(),
            _ => channel.to_string(),
        };
        Column::new(name, "FS", values.collect())
    });
    Ok(Table {
        columns: columns.collect(),
        clock: Clock::Rate(f64::from(coding.rate)),
    })
}

/// Finds coding and data.
fn chunks(bytes: &[u8]) -> Result<(Coding, &[u8]), Problem> {
    let mut long_data = None;
    let mut coding = None;
    let mut at = 12;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32_at(head, 4);
        let rest = &bytes[at + 8..];
        if &head[..4] == b"data" {
            let coding = coding.ok_or_else(|| damaged("there is no `fmt ` before the data"))?;
            let need = match (length, long_data) {
                (OPEN_END, Some(long)) => long,
                (OPEN_END, None) => rest.len() as u64,
                _ => u64::from(length),
            };
            let data = usize::try_from(need).ok().and_then(|n| rest.get(..n));
            let data = data.ok_or_else(|| cut_short("data", rest, need))?;
            return Ok((coding, data));
        }
        let name = String::from_utf8_lossy(&head[..4]);
        let chunk = rest
            .get(..length as usize)
            .ok_or_else(|| cut_short(&name, rest, u64::from(length)))?;
        match &head[..4] {
            b"fmt " => coding = Some(read_coding(chunk)?),
            b"ds64" if chunk.len() >= 16 => {
                let long = chunk[8..16].try_into().unwrap_or_default();
                long_data = Some(u64::from_le_bytes(long));
            }
            _ => {}
        }
        // Chunks begin at even places.
        at += 8 + chunk.len() + chunk.len() % 2;
    }
    Err(damaged("there is no `data` in it"))
}

fn read_coding(chunk: &[u8]) -> Result<Coding, Problem> {
    if chunk.len() < 16 {
        return Err(damaged("its `fmt ` is too short"));
    }
    let tag = match u16_at(chunk, 0) {
        // The extensible form says it at the beginning of a longer identifier.
        0xFFFE if chunk.len() >= 26 => u16_at(chunk, 24),
        tag => tag,
    };
    let float = match tag {
        1 => false,
        3 => true,
        tag => {
            return Err(Problem::Unsupported {
                what: format!("compressed sound (WAV coding {tag})"),
                remedy: "save it as plain PCM",
            });
        }
    };
    let channels = usize::from(u16_at(chunk, 2));
    let block = usize::from(u16_at(chunk, 12));
    if channels == 0 || block == 0 || !block.is_multiple_of(channels) {
        let what = format!("{channels} channels in blocks of {block} bytes");
        return Err(damaged(&what));
    }
    Ok(Coding {
        float,
        channels,
        rate: u32_at(chunk, 4),
        width: block / channels,
    })
}

/// What turns the bytes of one sample into a number.
fn number(coding: &Coding) -> Result<fn(&[u8]) -> f64, Problem> {
    Ok(match (coding.float, coding.width) {
        (false, 1) => |b| (f64::from(b[0]) - 128.0) / 128.0,
        (false, 2) => |b| integer(b),
        (false, 3) => |b| integer(b),
        (false, 4) => |b| integer(b),
        (true, 4) => |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        (true, 8) => |b| f64::from_le_bytes(b.try_into().unwrap_or_default()),
        (_, width) => {
            return Err(Problem::Unsupported {
                what: format!("a sample of {width} bytes"),
                remedy: "save it with 8 to 32 bits, or as 32- or 64-bit float",
            });
        }
    })
}

/// A signed integer of up to four bytes over its full scale.
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
    Problem::Damaged {
        format: FORMAT,
        what: what.to_owned(),
    }
}

fn cut_short(name: &str, rest: &[u8], need: u64) -> Problem {
    Problem::CutShort {
        format: FORMAT,
        what: format!("its `{name}`"),
        have: rest.len() as u64,
        need,
    }
}
