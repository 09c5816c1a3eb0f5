//! Compressed sound: FLAC, MP3, Ogg Vorbis; and AIFF.
//!
//! Decoded by the library symphonia. A file is decoded twice: once to count its samples, which not all formats state,
//! and once more for those that are selected.

use std::ops::Range;
use std::path::{Path, PathBuf};

use symphonia::core::audio::GenericAudioBufferRef;
use symphonia::core::codecs::audio::AudioDecoderOptions;
use symphonia::core::errors::Error;
use symphonia::core::formats::probe::Hint;
use symphonia::core::formats::{FormatOptions, TrackType};
use symphonia::core::io::MediaSourceStream;
use symphonia::core::meta::MetadataOptions;

use super::clock::Timing;
use super::table::{ColumnHeader, Source};
use super::{Problem, wav};
use crate::foreign::{open_file, without_panic};

const FORMAT: &str = "sound";

/// A file whose samples have been counted.
pub(super) struct Compressed {
    path: PathBuf,
    stem: String,
    rate: u32,
    channels: usize,
    /// Number of samples per channel.
    frames: usize,
}

impl Compressed {
    pub fn open(path: &Path, stem: &str) -> Result<Self, Problem> {
        let (mut form, mut frames) = (None, 0);
        decode(path, &mut |block| {
            let of_block = (block.spec().rate(), block.num_planes());
            if *form.get_or_insert(of_block) != of_block {
                let what = "sound whose rate or number of channels changes";
                return Err(Problem::unsupported(what, "save it as WAV"));
            }
            frames += block.frames();
            Ok(true)
        })?;
        let Some((rate, channels)) = form.filter(|(_, channels)| frames > 0 && *channels > 0)
        else {
            return Err(Problem::no_samples("a header"));
        };
        Ok(Self {
            path: path.to_owned(),
            stem: stem.to_owned(),
            rate,
            channels,
            frames,
        })
    }
}

impl Source for Compressed {
    fn headings(&self) -> Vec<ColumnHeader> {
        wav::channel_headings(self.channels, &self.stem, self.frames)
    }

    fn timing(&self) -> Timing {
        Timing::Rate(f64::from(self.rate))
    }

    fn samples(
        &mut self,
        column: usize,
        range: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        let mut first = 0;
        let mut planes: Vec<Vec<f64>> = Vec::new();
        decode(&self.path, &mut |block| {
            let frames = block.frames();
            let from = range.start.clamp(first, first + frames) - first;
            let to = range.end.clamp(first, first + frames) - first;
            if from < to {
                block.copy_to_vecs_planar(&mut planes);
                planes[column][from..to].iter().for_each(|x| each(*x));
            }
            first += frames;
            Ok(first < range.end)
        })?;
        if first < range.end {
            return Err(Problem::changed());
        }
        Ok(())
    }
}

/// Takes a block of samples; returns whether more are needed.
type TakeBlock<'a> = &'a mut dyn FnMut(&GenericAudioBufferRef<'_>) -> Result<bool, Problem>;

/// Decodes a file block by block, until no more are needed.
fn decode(path: &Path, each: TakeBlock<'_>) -> Result<(), Problem> {
    without_panic(|| decode_blocks(path, each))
        .unwrap_or_else(|| Err(Problem::damaged(FORMAT, "it cannot be decoded")))
}

fn decode_blocks(path: &Path, each: TakeBlock<'_>) -> Result<(), Problem> {
    let content = MediaSourceStream::new(Box::new(open_file(path)?.0), Default::default());
    let mut file = symphonia::default::get_probe()
        .probe(
            &Hint::new(),
            content,
            FormatOptions::default(),
            MetadataOptions::default(),
        )
        .map_err(problem)?;
    let track = file.default_track(TrackType::Audio);
    let track = track.ok_or_else(|| Problem::no_samples("a header"))?;
    let id = track.id;
    let coding = track.codec_params.as_ref().and_then(|p| p.audio());
    let coding = coding.ok_or_else(|| Problem::no_samples("a header"))?;
    let mut decoder = symphonia::default::get_codecs()
        .make_audio_decoder(coding, &AudioDecoderOptions::default())
        .map_err(problem)?;
    while let Some(packet) = file.next_packet().map_err(problem)? {
        if packet.track_id == id && !each(&decoder.decode(&packet).map_err(problem)?)? {
            break;
        }
    }
    Ok(())
}

/// An error of the library.
fn problem(error: Error) -> Problem {
    match error {
        Error::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
            Problem::Unreadable(error)
        }
        Error::Unsupported(what) => {
            let what = format!("this kind of sound ({what})");
            Problem::unsupported(what, "save it as WAV or FLAC")
        }
        error => Problem::damaged(FORMAT, error),
    }
}
