//! A run as a WAV file.

use std::io::{Cursor, Error, Write};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use hound::{SampleFormat, WavSpec, WavWriter};

use super::{NoSurface, RATE, Resampler, Source, SurfaceProbe};
use crate::export::{OutputError, replace_file};
use crate::pipeline::message::{Header, Record};
use crate::pipeline::{Sink, SinkError};

/// Peak level, relative to full scale: -1 dB.
const LOUDEST: f32 = 0.891;
/// Full scale of 24-bit samples.
const FULL: f32 = 8_388_607.0;
/// Duration of the fade-in and fade-out, ms, which prevents clicks.
const FADE: usize = 5;

/// Writes the audio of a run to a WAV file: one channel of 24 bits at [`RATE`], at the level of [`Source::full_scale`] or
/// normalised to a peak of -1 dB. The file gets its name when the run has been completed or stopped.
pub struct WavSink {
    path: PathBuf,
    /// Time stretch.
    slower: f64,
    probe: SurfaceProbe,
    /// Value at full scale, m/s or m/s^2; `None` normalises.
    full_scale: Option<f32>,
    resampler: Resampler,
    sound: Vec<f32>,
    /// Simulated time so far, s.
    time: f64,
    loudest: Arc<OnceLock<String>>,
}

impl WavSink {
    /// Writes the audio of a run to a file with a time stretch `slower` (1 for real time, above 0).
    ///
    /// # Errors
    /// If a surface point is selected and the run has no surface.
    pub fn new(
        path: PathBuf,
        source: Source,
        header: &Header,
        slower: f64,
    ) -> Result<Self, NoSurface> {
        Ok(Self {
            path,
            slower,
            probe: SurfaceProbe::new(source, header)?,
            full_scale: source.full_scale.map(|value| value as f32),
            resampler: Resampler::new(header.sample_rate / slower),
            sound: Vec::new(),
            time: 0.0,
            loudest: Arc::default(),
        })
    }

    /// Description of the audio signal.
    pub fn description(&self) -> String {
        let signal = self.probe.description();
        match self.full_scale {
            Some(value) => format!("{signal}, full scale {}", self.probe.format_value(value)),
            None => signal,
        }
    }

    /// Value of the peak with its unit, and whether it is clipped, from the end of the run on. A normalised file does not
    /// contain it: a decaying vibration is as loud as a squeak.
    pub fn loudest(&self) -> Arc<OnceLock<String>> {
        Arc::clone(&self.loudest)
    }

    /// Number of audio samples up to the present simulated time.
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
        let full_scale = self.full_scale.unwrap_or(loudest / LOUDEST);
        let mut peak = self.probe.format_value(loudest);
        if loudest > full_scale {
            peak += " is clipped; raise --wav-level";
        }
        let _ = self.loudest.set(peak);
        // A silent signal is not amplified.
        let gain = if full_scale > 0.0 {
            FULL / full_scale
        } else {
            0.0
        };
        replace_file(&self.path, |file| {
            let mut bytes = Cursor::new(Vec::new());
            let mut writer = WavWriter::new(&mut bytes, spec).map_err(Error::other)?;
            for k in 0..count {
                let sample = (gain * faded(k)).round().clamp(-FULL, FULL) as i32;
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
            let samples = self.probe.samples(&frame);
            self.resampler.push(samples, &mut self.sound);
            self.time += frame.end() - frame.t0;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        let left = self.due().saturating_sub(self.sound.len());
        self.resampler.finish(&mut self.sound, left);
        Ok(self.write()?)
    }
}
