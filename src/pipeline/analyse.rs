//! The analyses of a run: frames in, records out.

use std::sync::Arc;

use rayon::prelude::*;

use super::error::AnalyseError;
use super::message::{Frame, Header, Record, Summary};
use super::sink::Sink;
use super::stages::{StageGroup, stages};
use crate::scene::AnalysisSpec;

/// The requested analyses.
///
/// Records of one kind are in time order, at times fixed by the scene and the first sample. They do not
/// depend on how the samples are split into frames. Analyses that do not depend on each other run at the same
/// time, on the threads of the current thread pool; neither the records nor their order depend on the number of
/// these threads.
pub struct Analyser {
    /// The last one observes the records of the others.
    groups: Vec<StageGroup>,
    /// Whether it has warned that steps have passed over events.
    has_warned: bool,
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
            groups: stages(spec, header),
            has_warned: false,
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
    /// [`AnalyseError`]; the run cannot continue after it.
    pub fn push(&mut self, frame: &Arc<Frame>, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        for group in &mut self.groups {
            group.context.clock.advance(frame)?;
        }
        let mut send = |record| sink.accept(record).map_err(AnalyseError::Sink);
        // Before they are analysed, so that a fault of an analysis loses no samples.
        for text in frame.events.iter().cloned() {
            let time = frame.t0;
            send(Record::Event { time, text })?;
        }
        send(Record::Samples(Arc::clone(frame)))?;
        if let Some(time) = frame.unlocated_since.filter(|_| !self.has_warned) {
            self.has_warned = true;
            let text = format!(
                "from {:.3} ms on, contact nodes separate and close too often to stop at each event: \
                 some steps integrate over their events, as all steps do with time.events = \"through\"; \
                 error control still applies to these steps",
                1e3 * time
            );
            send(Record::Warning { time, text })?;
        }
        let Some((last, independent)) = self.groups.split_last_mut() else {
            return Ok(());
        };
        let results: Vec<_> = independent
            .par_iter_mut()
            .map(|group| group.analyse(frame, &[]))
            .collect();
        let mut records = Vec::new();
        for result in results {
            records.extend(result?);
        }
        records.extend(last.analyse(frame, &records)?);
        records.into_iter().try_for_each(send)
    }

    /// Emits the remaining results after the last frame.
    ///
    /// # Errors
    /// [`AnalyseError`].
    pub fn finish(&mut self, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        let mut records = self.groups.iter_mut().flat_map(StageGroup::finish);
        records.try_for_each(|record| sink.accept(record).map_err(AnalyseError::Sink))
    }

    /// Results of the frames so far: simulated time, solver statistics and transitions; spectral lines,
    /// amplitude and peak velocity of the last window (that of the spectrum, else 20 ms); the last exponents
    /// and the distance of the perturbed trajectory. All other fields have default values.
    pub fn summary(&self) -> Summary {
        let mut summary = Summary::default();
        for group in &self.groups {
            summary.simulated = group.context.clock.elapsed();
            for stage in &group.stages {
                stage.summarise(&mut summary);
            }
        }
        summary
    }
}

#[cfg(test)]
#[path = "analyse_tests.rs"]
mod tests;
