//! The analyses of a run: frames in, records out, independent of threads.

use std::sync::Arc;

use super::error::AnalyseError;
use super::message::{Frame, Header, Record, Summary};
use super::sink::Sink;
use super::stages::{Context, Stage, stages};
use crate::scene::AnalysisSpec;

/// The requested analyses.
///
/// Records of one kind are in time order, at times fixed by the scene and the first sample. They do not
/// depend on how the samples are split into frames.
pub struct Analyser {
    context: Context,
    stages: Vec<Box<dyn Stage>>,
}

/// Memory of an analysis per sample of its window, bytes: four copies of the window while it slides, and its
/// transform.
const BYTES_A_SAMPLE: f64 = 128.0;

/// Memory of the windows of all analyses of samples at `rate` (Hz), bytes.
pub fn memory(spec: &AnalysisSpec, rate: f64) -> u64 {
    let spectrum = spec.spectrum.as_ref().map(|s| s.sliding.window);
    let windows = [
        spectrum,
        // The summary of the run needs a second spectrum.
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
    /// Sets up the analyses of the run described by `header`.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Self {
        Self {
            context: Context::new(header.sample_rate),
            stages: stages(spec, header),
        }
    }

    /// From now on, computes only every `divisor`-th window of the analyses that are only displayed.
    pub fn set_rate_divisor(&mut self, divisor: u64) {
        self.context.rate_divisor = divisor;
    }

    /// Passes the frame to `sink` as [`Record::Samples`], followed by the results of the analyses up to its
    /// last sample.
    ///
    /// # Errors
    /// [`AnalyseError`]; the run cannot continue after it.
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

    /// Emits the remaining results after the last frame.
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

    /// Results of the frames so far: simulated time, solver statistics and transitions; spectral lines,
    /// amplitude and peak velocity of the last window (that of the spectrum, else 20 ms); the last exponents
    /// and the distance of the perturbed trajectory. All other fields have default values.
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
