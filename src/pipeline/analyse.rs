//! Frames in, records out: the analyses of a run, in one place and without a thread.

use std::sync::Arc;

use super::message::{Frame, Header, Record, Summary};
use super::stages::{
    Clock, ClosingStage, NarrationStage, RecurrenceStage, SpectrogramStage, SpectrumStage,
};
use super::{Sink, SinkError};
use crate::analysis::AnalysisError;
use crate::scene::Scene;

/// The error of the analyses.
#[derive(Debug, thiserror::Error)]
pub enum AnalyseError {
    /// A frame does not start where the one before it ended.
    #[error(
        "frame {index} starts at {found} s with samples every {dt} s, but sample {sample} of the \
         run is due at {due} s; frames must follow one another without a gap, at the rate of the header"
    )]
    Gap {
        /// Number of the frame.
        index: u64,
        /// Where it starts, s.
        found: f64,
        /// Its sample spacing, s.
        dt: f64,
        /// The sample it should start with, counted from the first of the run.
        sample: u64,
        /// Where that sample is due, s.
        due: f64,
    },
    /// A window of the scene is too short for its analysis.
    #[error("analysis of the probe's signal: {0}")]
    Signal(#[from] AnalysisError),
    /// The sink refused a record.
    #[error("a record could not be kept: {0}")]
    Sink(#[source] SinkError),
}

/// The analyses that a scene asks for; one it does not ask for does not exist here.
///
/// Records of one kind come in time order, at instants fixed by the scene and the first sample:
/// they do not depend on how the samples are cut into frames.
pub struct Analyser {
    clock: Clock,
    spectrum: Option<SpectrumStage>,
    narration: Option<NarrationStage>,
    spectrogram: Option<SpectrogramStage>,
    recurrence: Option<RecurrenceStage>,
    closing: ClosingStage,
}

impl Analyser {
    /// The analyses of `scene`, of a run announced by `header`.
    pub fn new(scene: &Scene, header: &Header) -> Self {
        let rate = header.sample_rate;
        let spec = &scene.analysis;
        Self {
            clock: Clock::new(rate),
            spectrum: spec.spectrum.map(|s| SpectrumStage::new(&s, rate)),
            // The words are of a joint that slides.
            narration: spec
                .spectrum
                .zip(header.joint())
                .map(|(s, joint)| NarrationStage::new(s.every, rate, joint)),
            spectrogram: spec.spectrogram.map(|s| SpectrogramStage::new(&s, rate)),
            recurrence: spec.recurrence.map(|s| RecurrenceStage::new(&s, rate)),
            closing: ClosingStage::new(spec.spectrum.as_ref(), rate),
        }
    }

    /// Forwards the frame to `sink` as [`Record::Samples`], followed by what the analyses have to
    /// say up to its last sample.
    ///
    /// # Errors
    /// [`AnalyseError`]; the run cannot go on after one.
    pub fn push(&mut self, frame: &Arc<Frame>, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        self.clock.check(frame)?;
        sink.accept(Record::Samples(Arc::clone(frame)))
            .map_err(AnalyseError::Sink)?;
        let mut emit = |record| sink.accept(record).map_err(AnalyseError::Sink);
        if let Some(stage) = &mut self.spectrum {
            stage.push(frame, &self.clock, &mut emit)?;
        }
        if let Some(stage) = &mut self.narration {
            stage.push(frame, &self.clock, &mut emit)?;
        }
        if let Some(stage) = &mut self.spectrogram {
            stage.push(frame, &self.clock, &mut emit)?;
        }
        if let Some(stage) = &mut self.recurrence {
            stage.push(frame, &self.clock, &mut emit)?;
        }
        self.closing.push(frame);
        self.clock.advance(frame);
        Ok(())
    }

    /// What the frames so far came to: simulated time, tally and transitions, and the lines,
    /// amplitude and peak velocity of the last window (that of the spectrum, else 20 ms). The
    /// other fields are left at their defaults for those who know them.
    pub fn summary(&self) -> Summary {
        Summary {
            simulated: self.clock.elapsed(),
            ..self.closing.summary()
        }
    }
}

#[cfg(test)]
#[path = "analyse_tests.rs"]
mod tests;
