//! From records to rows: what each record draws.

use std::sync::Arc;

use rerun::RecordingStream;

use super::{
    body::Body,
    error::RecordError,
    patch::Patch,
    paths,
    plot::Plot,
    portrait::{self, Embedding, Portrait},
    recurrence::{Picture, Recurrence},
    samples::{self, Samples},
    spectrum::{self, Spectrogram},
    text,
};
use crate::{
    pipeline::message::{Header, Record},
    scene::RecordSpec,
};

/// Encodes the records that follow a header.
#[derive(Debug)]
pub struct Encoder {
    header: Arc<Header>,
    samples: Samples,
    patch: Patch,
    body: Body,
    portrait: Portrait,
    embedding: Embedding,
    spectrum: Plot,
    spectrogram: Spectrogram,
    recurrence: Recurrence,
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
        samples::name_health(rec)?;
        portrait::style_point(rec)?;
        let spectrum = spectrum::spectrum_plot(&header);
        spectrum.draw(rec, paths::SPECTRUM_AXES, None)?;
        Ok(Self {
            samples: Samples::new(rec, &header)?,
            patch: Patch::new(rec, &header)?,
            body: Body::new(rec, &header, spec.body_rate, spec.exaggeration)?,
            portrait: Portrait::new(),
            embedding: Embedding::new(),
            spectrum,
            spectrogram: Spectrogram::new(rec, &header)?,
            recurrence: Recurrence::new(rec)?,
            header,
        })
    }

    /// Logs a record.
    pub fn accept(&mut self, rec: &RecordingStream, record: &Record) -> Result<(), RecordError> {
        match record {
            // The header made this encoder; a second one would say the same.
            Record::Header(_) => Ok(()),
            Record::Samples(frame) => {
                self.samples.push(rec, frame)?;
                self.patch.push(rec, frame)?;
                self.body.push(rec, frame)?;
                self.portrait.push(rec, frame)
            }
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
            Record::Health(health) => samples::log_health(rec, health),
            Record::Narration { time, text } => text::narrate(rec, &self.header, *time, text),
            Record::Warning { time, text } => text::warn(rec, *time, text),
            Record::Summary(summary) => text::summarise(rec, summary),
        }
    }

    /// Sends all that waits for a fuller batch.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.samples.finish(rec)?;
        self.patch.finish(rec)?;
        self.body.finish(rec)?;
        self.spectrogram.finish(rec)
    }
}
