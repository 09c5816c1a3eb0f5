//! Frames in, records out: the analyses of a run, in one place and without a thread.

use std::sync::Arc;

use super::error::AnalyseError;
use super::message::{Frame, Header, Record, Summary};
use super::sink::Sink;
use super::stages::{Context, Stage, stages};
use crate::scene::AnalysisSpec;

/// The analyses that are asked for; one that is not asked for does not exist here.
///
/// Records of one kind come in time order, at instants fixed by the scene and the first sample:
/// they do not depend on how the samples are cut into frames.
pub struct Analyser {
    context: Context,
    stages: Vec<Box<dyn Stage>>,
}

/// Bytes that an analysis takes for a sample of its window: the window four times over, as it slides, and the
/// transform of it.
const BYTES_A_SAMPLE: f64 = 128.0;

/// What the windows of all analyses of samples at `rate` (Hz) take together, bytes.
pub fn memory(spec: &AnalysisSpec, rate: f64) -> u64 {
    let spectrum = spec.spectrum.as_ref().map(|s| s.sliding.window);
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
        Self {
            context: Context::new(header.sample_rate),
            stages: stages(spec, header),
        }
    }

    /// Forwards the frame to `sink` as [`Record::Samples`], followed by the results of the analyses
    /// up to its last sample.
    ///
    /// # Errors
    /// [`AnalyseError`]; the run cannot continue after one.
    pub fn push(&mut self, frame: &Arc<Frame>, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        self.context.clock.check(frame)?;
        for text in &frame.events {
            let (time, text) = (frame.t0, text.clone());
            sink.accept(Record::Event { time, text })
                .map_err(AnalyseError::Sink)?;
        }
        sink.accept(Record::Samples(Arc::clone(frame)))
            .map_err(AnalyseError::Sink)?;
        let mut rest = &mut self.stages[..];
        while let Some((stage, later)) = rest.split_first_mut() {
            let mut emit = |record| {
                later.iter_mut().for_each(|stage| stage.observe(&record));
                sink.accept(record).map_err(AnalyseError::Sink)
            };
            stage.push(frame, &mut self.context, &mut emit)?;
            rest = later;
        }
        self.context.clock.advance(frame);
        Ok(())
    }

    /// Lets the analyses emit what remains after the last frame.
    ///
    /// # Errors
    /// [`AnalyseError`].
    pub fn finish(&mut self, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        let mut emit = |record| sink.accept(record).map_err(AnalyseError::Sink);
        for stage in &mut self.stages {
            stage.finish(&mut self.context, &mut emit)?;
        }
        Ok(())
    }

    /// The results of the frames so far: simulated time, tally and transitions, and the lines,
    /// amplitude and peak velocity of the last window (that of the spectrum, else 20 ms), the last
    /// exponents and the distance of the perturbed trajectory. The other fields keep their defaults.
    pub fn summary(&self) -> Summary {
        let mut summary = Summary {
            simulated: self.context.clock.elapsed(),
            ..Summary::default()
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
