//! Frames in, records out: the analyses of a run, in one place and without a thread.

use std::sync::Arc;

use super::message::{Frame, Header, Record, Summary};
use super::stages::{
    ButterflyStage, ChaosStage, ChatterStage, ClosingStage, Context, DelayStage, ExponentsStage,
    LessonStage, NarrationStage, QuantificationStage, RecurrenceStage, RegimeStage, SectionStage,
    SpectrogramStage, SpectrumStage, Stage,
};
use super::{Sink, SinkError};
use crate::analysis::AnalysisError;
use crate::scene::AnalysisSpec;

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

/// The analyses that are asked for; one that is not asked for does not exist here.
///
/// Records of one kind come in time order, at instants fixed by the scene and the first sample:
/// they do not depend on how the samples are cut into frames.
pub struct Analyser {
    context: Context,
    stages: Vec<Box<dyn Stage>>,
    /// Hears what the others say.
    lesson: Option<LessonStage>,
    closing: ClosingStage,
}

/// Bytes that an analysis takes for a sample of its window: the window four times over, as it slides, and the
/// transform of it.
const BYTES_A_SAMPLE: f64 = 128.0;

/// What the windows of all analyses of samples at `rate` (Hz) take together, bytes.
pub fn memory(spec: &AnalysisSpec, rate: f64) -> u64 {
    let spectrum = spec.spectrum.as_ref().map(|s| s.window);
    let windows = [
        spectrum,
        // What a run comes to is read off a spectrum of its own.
        spectrum,
        spec.spectrogram.as_ref().map(|s| s.sliding.window),
        spec.delay.as_ref().map(|s| s.sliding.window),
        spec.recurrence.as_ref().map(|s| s.sliding.window),
        spec.quantification.as_ref().map(|s| s.sliding.window),
        spec.chaos.as_ref().map(|s| s.sliding.window),
        spec.regime.as_ref().map(|s| s.sliding.window),
    ];
    (BYTES_A_SAMPLE * rate * windows.into_iter().flatten().sum::<f64>()) as u64
}

impl Analyser {
    /// The analyses of a run announced by `header`.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Self {
        let rate = header.sample_rate;
        let delay = spec.delay.as_ref();
        let mut stages: Vec<Box<dyn Stage>> = Vec::new();
        if let Some(spec) = &spec.spectrum {
            stages.push(Box::new(SpectrumStage::new(spec, rate)));
            // The words are of a joint that slides.
            if let Some(joint) = header.joint() {
                stages.push(Box::new(NarrationStage::new(spec.every, rate, joint)));
            }
        }
        if let Some(spec) = &spec.spectrogram {
            stages.push(Box::new(SpectrogramStage::new(spec, rate)));
        }
        // Before those that take what it chooses.
        if let Some(spec) = &spec.delay {
            stages.push(Box::new(DelayStage::new(spec, rate)));
        }
        if let Some(spec) = &spec.recurrence {
            stages.push(Box::new(RecurrenceStage::new(spec, delay, rate)));
        }
        if let Some(spec) = &spec.quantification {
            stages.push(Box::new(QuantificationStage::new(spec, delay, rate)));
        }
        if let Some(spec) = &spec.section {
            stages.push(Box::new(SectionStage::new(spec, delay, rate)));
        }
        if let Some(spec) = &spec.chaos {
            stages.push(Box::new(ChaosStage::new(spec, delay, rate)));
        }
        if let Some(spec) = &spec.regime {
            stages.push(Box::new(RegimeStage::new(spec, rate)));
        }
        if spec.exponents.is_some() {
            stages.push(Box::new(ExponentsStage::default()));
        }
        if let Some(spec) = spec.butterfly {
            stages.push(Box::new(ButterflyStage::new(spec, rate)));
        }
        if header.joint().is_some() {
            stages.push(Box::new(ChatterStage::default()));
        }
        Self {
            context: Context::new(rate),
            stages,
            lesson: LessonStage::new(spec, header),
            closing: ClosingStage::new(spec.spectrum.as_ref(), rate),
        }
    }

    /// Forwards the frame to `sink` as [`Record::Samples`], followed by what the analyses have to
    /// say up to its last sample.
    ///
    /// # Errors
    /// [`AnalyseError`]; the run cannot go on after one.
    pub fn push(&mut self, frame: &Arc<Frame>, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        self.context.clock.check(frame)?;
        for text in &frame.events {
            let (time, text) = (frame.t0, text.clone());
            sink.accept(Record::Event { time, text })
                .map_err(AnalyseError::Sink)?;
        }
        sink.accept(Record::Samples(Arc::clone(frame)))
            .map_err(AnalyseError::Sink)?;
        let lesson = &mut self.lesson;
        let mut emit = |record| {
            if let Some(lesson) = lesson {
                lesson.hear(&record);
            }
            sink.accept(record).map_err(AnalyseError::Sink)
        };
        for stage in &mut self.stages {
            stage.push(frame, &mut self.context, &mut emit)?;
        }
        if let Some(lesson) = &mut self.lesson {
            let mut emit = |record| sink.accept(record).map_err(AnalyseError::Sink);
            lesson.push(frame, &mut self.context, &mut emit)?;
        }
        self.closing.push(frame);
        self.context.clock.advance(frame);
        Ok(())
    }

    /// Lets the analyses say what they have to say after the last frame.
    ///
    /// # Errors
    /// [`AnalyseError`].
    pub fn finish(&mut self, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        let mut emit = |record| sink.accept(record).map_err(AnalyseError::Sink);
        for stage in &mut self.stages {
            stage.finish(&mut self.context, &mut emit)?;
        }
        if let Some(lesson) = &mut self.lesson {
            lesson.finish(&mut self.context, &mut emit)?;
        }
        Ok(())
    }

    /// What the frames so far came to: simulated time, tally and transitions, and the lines,
    /// amplitude and peak velocity of the last window (that of the spectrum, else 20 ms), the last
    /// exponents and how far two copies have parted. The other fields are left at their defaults for those who know them.
    pub fn summary(&self) -> Summary {
        let mut summary = Summary {
            simulated: self.context.clock.elapsed(),
            ..self.closing.summary()
        };
        for stage in &self.stages {
            stage.summarise(&mut summary);
        }
        summary
    }
}

#[cfg(test)]
#[path = "analyse_tests.rs"]
mod tests;
