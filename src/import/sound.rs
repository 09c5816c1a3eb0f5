//! Sound: WAV, AIFF, FLAC, MP3, AAC, alone or in MP4 (.m4a), Ogg Vorbis and Opus.
//!
//! Decoded by the library symphonia, Opus by opus-decoder. A file is decoded twice: once to count its samples, which not
//! all formats state, and once more for those that are selected.

use std::io::{self, ErrorKind};
use std::ops::Range;
use std::path::{Path, PathBuf};

use opus_decoder::OpusDecoder;
use symphonia::core::codecs::audio::well_known::{CODEC_ID_ALAC, CODEC_ID_MP3, CODEC_ID_OPUS};
use symphonia::core::codecs::audio::{AudioCodecParameters, AudioDecoderOptions};
use symphonia::core::errors::Error;
use symphonia::core::formats::TrackType;
use symphonia::core::formats::probe::Hint;
use symphonia::core::io::MediaSourceStream;
use symphonia::core::packet::Packet;

use super::Problem;
use super::clock::Timing;
use super::table::{Buffer, ColumnHeader, Source};
use super::wav::with_normal_header;
use crate::foreign::{open_file, without_panic};

const FORMAT: &str = "sound";

/// The remedy for sound that is not decoded.
pub(super) const CONVERT: &str = "convert it: ffmpeg -i FILE FILE.wav";

/// A file whose samples have been counted.
pub(super) struct Sound {
    path: PathBuf,
    stem: String,
    rate: u32,
    channels: usize,
    /// Number of samples per channel.
    frames: usize,
    /// What is wrong with the file; the samples before the damage count.
    damage: Option<String>,
}

impl Sound {
    pub fn open(path: &Path, stem: &str) -> Result<Self, Problem> {
        let (mut form, mut count) = (None, 0);
        let damage = decode(path, &mut |found, block| {
            if *form.get_or_insert(found) != found {
                let what = "sound whose rate or number of channels changes";
                return Err(Problem::unsupported(what, "save it as WAV"));
            }
            count += block.len();
            Ok(true)
        })?;
        let Some((rate, channels)) = form.filter(|(_, channels)| (1..=count).contains(channels))
        else {
            return Err(Problem::no_samples("a header"));
        };
        Ok(Self {
            path: path.to_owned(),
            stem: stem.to_owned(),
            rate,
            channels,
            frames: count / channels,
            damage,
        })
    }
}

impl Source for Sound {
    fn headings(&self) -> Vec<ColumnHeader> {
        let name = |channel: usize| match (self.channels, channel) {
            (1, _) => self.stem.clone(),
            (2, 0) => "left".to_owned(),
            (2, _) => "right".to_owned(),
            _ => channel.to_string(),
        };
        (0..self.channels)
            .map(|channel| ColumnHeader::with_unit(name(channel), "FS"))
            .collect()
    }

    fn clock(&mut self, _column: usize) -> Result<(Timing, usize), Problem> {
        Ok((Timing::Rate(Some(f64::from(self.rate))), self.frames))
    }

    fn damage(&self) -> Option<&str> {
        self.damage.as_deref()
    }

    fn samples(&mut self, column: usize, range: Range<usize>, into: Buffer) -> Result<(), Problem> {
        let [start, end] = [range.start, range.end].map(|frame| frame * self.channels);
        let mut first = 0;
        decode(&self.path, &mut |_, block| {
            let from = start.saturating_sub(first).min(block.len());
            for (place, sample) in (first + from..end).zip(&block[from..]) {
                if place % self.channels == column {
                    into.push(*sample);
                }
            }
            first += block.len();
            Ok(first < end)
        })?;
        if first < end {
            return Err(Problem::changed());
        }
        Ok(())
    }
}

/// Sample rate, Hz, and number of channels.
pub(super) type Form = (u32, usize);

/// Takes a block of samples, channel by channel for each instant; returns whether more are needed.
type TakeBlock<'a> = &'a mut dyn FnMut(Form, &[f64]) -> Result<bool, Problem>;

/// Decodes a file block by block, until no more are needed or it is damaged; returns what is wrong with the file.
fn decode(path: &Path, each: TakeBlock<'_>) -> Result<Option<String>, Problem> {
    without_panic(|| decode_blocks(path, each))
        .unwrap_or_else(|| Err(Problem::damaged(FORMAT, "it cannot be decoded")))
}

fn decode_blocks(path: &Path, each: TakeBlock<'_>) -> Result<Option<String>, Problem> {
    let (content, header, damage) = with_normal_header(open_file(path)?.0)?;
    let content = MediaSourceStream::new(content, Default::default());
    let probe = symphonia::default::get_probe();
    let (format, metadata) = (Default::default(), Default::default());
    let file = probe.probe(&Hint::new(), content, format, metadata);
    let mut file = file.map_err(problem)?;
    let track = file.default_track(TrackType::Audio);
    let track = track.ok_or_else(|| Problem::no_samples("a header"))?;
    let id = track.id;
    let coding = track.codec_params.as_ref().and_then(|p| p.audio());
    let coding = coding.ok_or_else(|| Problem::no_samples("a header"))?;
    // An MP3 file that states its delay states its number of samples, too; otherwise the library estimates it.
    let is_stated = coding.codec == CODEC_ID_MP3 && track.delay.is_some();
    let stated = track.num_frames.filter(|_| is_stated).unwrap_or(0) as usize;
    let mut decode = decoder(coding, track.delay)?;
    let (mut frames, mut latest) = (0, 0);
    let mut samples = Vec::new();
    let mut has_begun = false;
    let is_end = |fault: &io::Error| header.is_some() && fault.kind() == ErrorKind::UnexpectedEof;
    loop {
        let packet = match file.next_packet() {
            // The samples of a WAV file are the rest of its content.
            Err(Error::IoError(fault)) if is_end(&fault) => None,
            packet => packet.map_err(problem).transpose(),
        };
        let block = packet.map(|packet| match packet? {
            packet if packet.track_id == id => decode(&packet, &mut samples),
            _ => Ok((0, 0)),
        });
        match block.transpose() {
            // More than a packet is missing.
            Ok(None) if frames + latest < stated => {
                let missing =
                    format!("its header states {stated} samples, and the file has {frames}");
                return Ok(Some(missing));
            }
            Ok(None) => return Ok(damage),
            Ok(Some((0, _))) => {}
            Ok(Some(decoded)) => {
                has_begun = true;
                latest = samples.len() / decoded.1.max(1);
                frames += latest;
                if !each(header.unwrap_or(decoded), &samples)? {
                    return Ok(damage);
                }
            }
            Err(Problem::Content(damage)) if has_begun => return Ok(Some(damage)),
            Err(problem) => return Err(problem),
        }
    }
}

/// Decodes a packet; returns the sample rate, Hz, and the number of channels.
type Decoder = Box<dyn FnMut(&Packet, &mut Vec<f64>) -> Result<Form, Problem>>;

/// A decoder of packets; `delay` samples are left out at the start of an Opus track.
fn decoder(coding: &AudioCodecParameters, delay: Option<u32>) -> Result<Decoder, Problem> {
    if coding.codec != CODEC_ID_OPUS {
        let options = AudioDecoderOptions::default();
        let decoder = symphonia::default::get_codecs().make_audio_decoder(coding, &options);
        let mut decoder = decoder.map_err(|error| match error {
            Error::Unsupported(_) if coding.codec == CODEC_ID_ALAC => {
                Problem::unsupported("Apple Lossless (ALAC)", CONVERT)
            }
            Error::Unsupported(_) => Problem::unsupported("the coding of this sound", CONVERT),
            error => problem(error),
        })?;
        return Ok(Box::new(move |packet: &Packet, samples: &mut Vec<f64>| {
            let block = decoder.decode(packet).map_err(problem)?;
            block.copy_to_vec_interleaved(samples);
            Ok((block.spec().rate(), block.spec().channels().count()))
        }));
    }
    let channels = coding
        .channels
        .as_ref()
        .map_or(1, |channels| channels.count());
    let mut decoder = OpusDecoder::new(OPUS_RATE, channels).map_err(|_| {
        let what = format!("Opus with {channels} channels");
        Problem::unsupported(what, CONVERT)
    })?;
    // The output gain that the header demands, in 1/256 dB, behind the version, the channels, the delay and the rate.
    let head = coding.extra_data.as_deref();
    let gain = head.and_then(|head| head.get(16..18));
    let gain = gain.map_or(0, |gain| i16::from_le_bytes([gain[0], gain[1]]));
    let gain = 10_f64.powf(f64::from(gain) / (256.0 * 20.0));
    let mut delay = delay.unwrap_or(0) as usize;
    let mut block = vec![0.0; channels * decoder.max_frame_size_per_channel()];
    Ok(Box::new(move |packet: &Packet, samples: &mut Vec<f64>| {
        let count = decoder.decode_float(&packet.data, &mut block, false);
        let count = count.map_err(|error| Problem::damaged(FORMAT, error))?;
        let end = count.saturating_sub(packet.trim_end.get() as usize);
        let start = end.min(delay);
        delay -= start;
        let wanted = &block[start * channels..end * channels];
        samples.clear();
        samples.extend(wanted.iter().map(|x| gain * f64::from(*x)));
        Ok((OPUS_RATE, channels))
    }))
}

/// Rate at which Opus is decoded, Hz.
const OPUS_RATE: u32 = 48_000;

/// An error of the library.
fn problem(error: Error) -> Problem {
    match error {
        Error::IoError(error) if error.kind() != ErrorKind::UnexpectedEof => {
            Problem::Unreadable(error)
        }
        // The index is written last.
        Error::Unsupported(what) if what.contains("moov") => {
            Problem::damaged(FORMAT, "its end with the index of the samples is missing")
        }
        Error::Unsupported(what) => {
            Problem::unsupported(format!("this kind of sound ({what})"), CONVERT)
        }
        error => Problem::damaged(FORMAT, error),
    }
}
