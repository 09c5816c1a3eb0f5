//! The analyses of a run: frames in, records out.

use std::sync::Arc;

use rayon::prelude::*;

use super::PipelineError;
use super::endpoints::{Sink, SinkError};
use super::lesson::LessonStage;
use super::message::{Frame, Header, Observation, Record, Summary};
use super::stages::{Clock, StageGroup, SummaryStage, stages};
use crate::scene::AnalysisSpec;

/// The requested analyses.
///
/// Records of one kind are in time order, at times fixed by the scene and the first sample. They do not
/// depend on how the samples are split into frames. Analyses that do not depend on each other run at the same
/// time, on the threads of the current thread pool; neither the records nor their order depend on the number of
/// these threads.
pub struct Analyser {
    clock: Clock,
    /// Analyses that do not depend on those of other groups.
    groups: Vec<StageGroup>,
    /// Observes the records of the groups.
    lesson: Option<LessonStage>,
    /// Observes the records of the groups, too. Every run has a summary.
    summary: SummaryStage,
}

/// Memory of an analysis per sample of its window, bytes: four copies of the window while it slides, and its
/// transform.
const BYTES_A_SAMPLE: f64 = 128.0;

/// Memory of the windows of all analyses of samples at `rate` (Hz), bytes.
pub fn memory(spec: &AnalysisSpec, rate: f64) -> u64 {
    let spectrum = spec.spectrum.as_ref().map(|s| s.window);
    let windows = [
        spectrum,
        // The summary of the run needs a second spectrum.
        spectrum,
        spec.spectrogram.as_ref().map(|s| s.window),
        spec.delay.as_ref().map(|s| s.window),
        spec.recurrence.as_ref().map(|s| s.window),
        spec.quantification.as_ref().map(|s| s.window),
        spec.chaos.as_ref().map(|s| s.window),
        spec.regime.as_ref().map(|s| s.window),
    ];
    (BYTES_A_SAMPLE * rate * windows.into_iter().flatten().sum::<f64>()) as u64
}

impl Analyser {
    /// Sets up the analyses of the run described by `header`.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Self {
        Self {
            clock: Clock::new(header.sample_rate),
            groups: stages(spec, header),
            lesson: LessonStage::new(spec, header),
            summary: SummaryStage::new(spec.spectrum.as_ref(), header),
        }
    }

    /// From now on, computes only every `divisor`-th window of the analyses that are only displayed.
    pub fn set_rate_divisor(&mut self, divisor: u64) {
        for group in &mut self.groups {
            group.context.rate_divisor = divisor;
        }
    }

    /// Passes the events and the samples of the frame ([`Record::Samples`]) to `sink`, followed by the results of the
    /// analyses up to its last sample.
    ///
    /// # Errors
    /// [`PipelineError`], of an analysis or of the sink; the run cannot continue after it.
    pub fn push(&mut self, frame: &Arc<Frame>, sink: &mut dyn Sink) -> Result<(), PipelineError> {
        // Before they are analysed, so that a fault of an analysis loses no samples.
        for text in frame.events.iter().cloned() {
            let time = frame.t0;
            sink.accept(Record::Event { time, text })?;
        }
        sink.accept(Record::Samples(Arc::clone(frame)))?;
        if let Some(time) = frame.unlocated_since {
            let text = format!(
                "from {:.3} ms on, contact nodes separate and close too often to stop at each event: \
                 some steps integrate over their events, as all steps do with time.events = \"through\"; \
                 error control still applies to these steps",
                1e3 * time
            );
            sink.accept(Record::Warning { time, text })?;
        }
        self.clock.advance(frame);
        let results: Vec<_> = self
            .groups
            .par_iter_mut()
            .map(|group| group.analyse(frame))
            .collect();
        let exponents = frame.exponents.iter().cloned().map(Arc::new);
        let mut records: Vec<Record> = exponents.map(Record::Exponents).collect();
        for result in results {
            records.extend(result?);
        }
        self.summary.push(frame, &records);
        if let Some(lesson) = &mut self.lesson {
            lesson.push(frame, &mut records);
        }
        records
            .into_iter()
            .try_for_each(|record| Ok(sink.accept(record)?))
    }

    /// Emits the remaining results after the last frame.
    ///
    /// # Errors
    /// [`SinkError`].
    pub fn finish(&mut self, sink: &mut dyn Sink) -> Result<(), SinkError> {
        let time = self.clock.newest();
        if let Some(exponents) = self.summary.decided_exponents() {
            let observation = Observation::Exponents(Arc::new(exponents.clone()));
            sink.accept(Record::Narration { time, observation })?;
        }
        let lesson = self.lesson.as_mut();
        let records = lesson.map_or_else(Vec::new, |lesson| lesson.finish(time));
        records
            .into_iter()
            .try_for_each(|record| sink.accept(record))
    }

    /// Results of the frames so far: simulated time, solver statistics and transitions; spectral lines,
    /// amplitude and peak velocity of the last window (that of the spectrum, else 20 ms); the last exponents
    /// and the distance of the perturbed trajectory; the facts of the lesson. All other fields have default values.
    pub fn summary(&self) -> Summary {
        let lesson = self.lesson.as_ref();
        Summary {
            simulated_s: self.clock.elapsed(),
            facts: lesson.map_or_else(Vec::new, |lesson| lesson.lesson(0.0).facts()),
            ..self.summary.summary()
        }
    }
}

#[cfg(test)]
#[path = "analyse_tests.rs"]
mod tests;
