//! A run as a WAV file.

use std::io::{Cursor, Error, Write};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use hound::{SampleFormat, WavSpec, WavWriter};

use super::{NoSurface, Pickup, RATE, Resampler, Source};
use crate::export::{OutputError, replace_file};
use crate::pipeline::message::{Header, Record};
use crate::pipeline::{Sink, SinkError};

/// The loudest sample, of full scale: -1 dB.
const LOUDEST: f32 = 0.891;
/// Full scale of 24 bits.
const FULL: f32 = 8_388_607.0;
/// Sound that is faded in and out, ms, so that it neither begins nor ends with a click.
const FADE: usize = 5;

/// Writes what is heard of a run into a WAV file: one channel of 24 bits at [`RATE`], the loudest sample at
/// -1 dB. The file takes its name when the run ends well or is interrupted.
pub struct WavSink {
    path: PathBuf,
    /// How many times slower than life it is played.
    slower: f64,
    pickup: Pickup,
    /// Until the run is over.
    resampler: Option<Resampler>,
    sound: Vec<f32>,
    /// Simulated time so far, s.
    time: f64,
    loudest: Arc<OnceLock<String>>,
}

impl WavSink {
    /// Of a run into a file, played so many times slower than life (1 for real time, above 0).
    ///
    /// # Errors
    /// When the run has no surface, and that is to be heard.
    pub fn new(
        path: PathBuf,
        source: Source,
        header: &Header,
        slower: f64,
    ) -> Result<Self, NoSurface> {
        Ok(Self {
            path,
            slower,
            pickup: Pickup::new(source, header)?,
            resampler: Some(Resampler::new(header.sample_rate / slower)),
            sound: Vec::new(),
            time: 0.0,
            loudest: Arc::default(),
        })
    }

    /// What is heard, in a few words.
    pub fn words(&self) -> String {
        self.pickup.words()
    }

    /// What the loudest sample stands for, with its unit; from the end of the run on. The file does not tell: a
    /// motion that is dying out is as loud there as a squeak.
    pub fn loudest(&self) -> Arc<OnceLock<String>> {
        Arc::clone(&self.loudest)
    }

    /// Sound that comes to a time of the run, samples.
    fn due(&self) -> usize {
        (self.time * self.slower * f64::from(RATE)).round() as usize
    }

    fn write(&self) -> Result<(), OutputError> {
        let spec = WavSpec {
            channels: 1,
            sample_rate: RATE,
            bits_per_sample: 24,
            sample_format: SampleFormat::Int,
        };
        let fade = FADE * RATE as usize / 1000;
        let count = self.sound.len();
        let faded = |k: usize| {
            let edge = k.min(count - 1 - k).min(fade) as f32 / fade as f32;
            edge * self.sound[k]
        };
        let loudest = (0..count).fold(0.0, |m: f32, k| faded(k).abs().max(m));
        let _ = self.loudest.set(self.pickup.amount(loudest));
        // Silence stays silence.
        let gain = if loudest > 0.0 {
            FULL * LOUDEST / loudest
        } else {
            0.0
        };
        replace_file(&self.path, |file| {
            let mut bytes = Cursor::new(Vec::new());
            let mut writer = WavWriter::new(&mut bytes, spec).map_err(Error::other)?;
            for k in 0..count {
                let sample = (gain * faded(k)).round() as i32;
                writer.write_sample(sample).map_err(Error::other)?;
            }
            writer.finalize().map_err(Error::other)?;
            file.write_all(bytes.get_ref())
        })
    }
}

impl Sink for WavSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if let Record::Samples(frame) = record {
            if let Some(resampler) = &mut self.resampler {
                resampler.push(self.pickup.hear(&frame), &mut self.sound);
            }
            self.time += frame.end() - frame.t0;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        let left = self.due().saturating_sub(self.sound.len());
        if let Some(resampler) = self.resampler.take() {
            resampler.finish(&mut self.sound, left);
        }
        Ok(self.write()?)
    }
}
