//! From records to rows: what each record draws.

use std::sync::Arc;

use rerun::RecordingStream;

use super::{
    body::Body,
    error::RecordError,
    patch::Patch,
    paths,
    portrait::{self, Embedding, Portrait},
    recurrence::{Picture, Recurrence},
    samples::{self, Samples, Waveform},
    spectrum::{self, Spectrogram, SpectrumPlot},
    text,
};
use crate::{
    pipeline::message::{Frame, Header, Record, Subject},
    scene::RecordSpec,
};

/// Encodes the records that follow a header.
#[derive(Debug)]
pub struct Encoder {
    header: Arc<Header>,
    frames: Frames,
    embedding: Embedding,
    spectrum: SpectrumPlot,
    spectrogram: Spectrogram,
    recurrence: Recurrence,
}

/// What frames of samples draw.
#[derive(Debug)]
enum Frames {
    /// Those of a joint.
    Joint {
        samples: Samples,
        patch: Box<Patch>,
        body: Box<Body>,
        portrait: Portrait,
    },
    /// Those of a signal from a file.
    Signal(Waveform),
}

impl Frames {
    fn new(rec: &RecordingStream, header: &Header, spec: RecordSpec) -> Result<Self, RecordError> {
        match &header.subject {
            Subject::Joint(joint) => {
                samples::name_health(rec)?;
                portrait::style_point(rec)?;
                Ok(Self::Joint {
                    samples: Samples::new(rec, joint)?,
                    patch: Box::new(Patch::new(rec, joint)?),
                    body: Box::new(Body::new(rec, joint, spec.body_rate, spec.exaggeration)?),
                    portrait: Portrait::new(),
                })
            }
            Subject::Signal(signal) => Ok(Self::Signal(Waveform::new(rec, signal)?)),
        }
    }

    fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        match self {
            Self::Joint {
                samples,
                patch,
                body,
                portrait,
            } => {
                samples.push(rec, frame)?;
                patch.push(rec, frame)?;
                body.push(rec, frame)?;
                portrait.push(rec, frame)
            }
            Self::Signal(waveform) => waveform.push(rec, frame),
        }
    }

    fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        match self {
            Self::Joint {
                samples,
                patch,
                body,
                ..
            } => {
                samples.finish(rec)?;
                patch.finish(rec)?;
                body.finish(rec)
            }
            Self::Signal(waveform) => waveform.finish(rec),
        }
    }
}

impl Encoder {
    /// Logs what the header tells.
    pub fn new(
        rec: &RecordingStream,
        header: Arc<Header>,
        spec: RecordSpec,
    ) -> Result<Self, RecordError> {
        text::send_properties(rec, &header)?;
        text::log_about(rec, &header)?;
        let spectrum = spectrum::spectrum_plot(&header);
        spectrum.plot.draw(rec, paths::SPECTRUM_AXES, None)?;
        Ok(Self {
            frames: Frames::new(rec, &header, spec)?,
            embedding: Embedding::new(&header.subject),
            spectrum,
            spectrogram: Spectrogram::new(rec, &header)?,
            recurrence: Recurrence::new(rec, &header.subject)?,
            header,
        })
    }

    /// Logs a record.
    pub fn accept(&mut self, rec: &RecordingStream, record: &Record) -> Result<(), RecordError> {
        match record {
            // The header made this encoder; a second one would say the same.
            Record::Header(_) => Ok(()),
            Record::Samples(frame) => self.frames.push(rec, frame),
            Record::Spectrum {
                time,
                bin,
                amplitude,
                peaks,
            } => spectrum::draw_spectrum(rec, &self.spectrum, *time, *bin, amplitude, peaks),
            Record::SpectrogramColumn {
                time,
                bin,
                level_db,
            } => self.spectrogram.push(rec, *time, *bin, level_db),
            Record::Recurrence {
                time,
                window,
                size,
                distance,
                recurrent,
                threshold,
                rate,
                lag,
                dimension,
            } => self.recurrence.draw(
                rec,
                Picture {
                    time: *time,
                    window: *window,
                    size: *size,
                    distance,
                    recurrent,
                    threshold: *threshold,
                    rate: *rate,
                    lag: *lag,
                    dimension: *dimension,
                },
            ),
            Record::Embedding { time, points } => self.embedding.draw(rec, *time, points),
            Record::Delay { .. }
            | Record::Quantification { .. }
            | Record::Section { .. }
            | Record::Chaos { .. }
            | Record::Regime { .. } => Ok(()),
            // Playing a file back is no simulation whose health could matter.
            Record::Health(health) => match self.frames {
                Frames::Joint { .. } => samples::log_health(rec, health),
                Frames::Signal(_) => Ok(()),
            },
            Record::Narration { time, text } => text::narrate(rec, &self.header, *time, text),
            Record::Warning { time, text } => text::warn(rec, *time, text),
            Record::Summary(summary) => text::summarise(rec, summary),
        }
    }

    /// Sends all that waits for a fuller batch.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.frames.finish(rec)?;
        self.spectrogram.finish(rec)
    }
}
