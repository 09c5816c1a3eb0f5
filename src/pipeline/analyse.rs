//! The analyses of a run: frames in, records out.

use std::sync::Arc;

use rayon::prelude::*;

use super::error::AnalyseError;
use super::message::{Frame, Header, Record, Summary};
use super::sink::Sink;
use super::stages::{StageGroup, StageGroups, stages};
use crate::scene::AnalysisSpec;

/// The requested analyses.
///
/// Records of one kind are in time order, at times fixed by the scene and the first sample. They do not
/// depend on how the samples are split into frames. Analyses that do not depend on each other run at the same
/// time, on the threads of the current thread pool; neither the records nor their order depend on the number of
/// these threads.
pub struct Analyser {
    groups: StageGroups,
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
            groups: stages(spec, header),
        }
    }

    /// From now on, computes only every `divisor`-th window of the analyses that are only displayed.
    pub fn set_rate_divisor(&mut self, divisor: u64) {
        for group in self.groups_mut() {
            group.context.rate_divisor = divisor;
        }
    }

    /// Passes the events and the samples of the frame ([`Record::Samples`]) to `sink`, followed by the results of the
    /// analyses up to its last sample.
    ///
    /// # Errors
    /// [`AnalyseError`]; the run cannot continue after it.
    pub fn push(&mut self, frame: &Arc<Frame>, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        let StageGroups { independent, last } = &mut self.groups;
        last.context.clock.check(frame)?;
        let events = frame.events.iter().map(|text| Record::Event {
            time: frame.t0,
            text: text.clone(),
        });
        let mut records: Vec<Record> = events.collect();
        records.push(Record::Samples(Arc::clone(frame)));
        // Before they are analysed, so that a fault of an analysis loses no samples.
        for record in &records {
            sink.accept(record.clone()).map_err(AnalyseError::Sink)?;
        }
        let sent = records.len();
        let results: Vec<_> = independent
            .par_iter_mut()
            .map(|group| group.analyse(frame))
            .collect();
        for result in results {
            records.extend(result?);
        }
        last.observe(frame, &mut records)?;
        let mut results = records.into_iter().skip(sent);
        results.try_for_each(|record| sink.accept(record).map_err(AnalyseError::Sink))
    }

    /// Emits the remaining results after the last frame.
    ///
    /// # Errors
    /// [`AnalyseError`].
    pub fn finish(&mut self, sink: &mut dyn Sink) -> Result<(), AnalyseError> {
        for group in self.groups_mut() {
            for record in group.finish()? {
                sink.accept(record).map_err(AnalyseError::Sink)?;
            }
        }
        Ok(())
    }

    /// Results of the frames so far: simulated time, solver statistics and transitions; spectral lines,
    /// amplitude and peak velocity of the last window (that of the spectrum, else 20 ms); the last exponents
    /// and the distance of the perturbed trajectory. All other fields have default values.
    pub fn summary(&self) -> Summary {
        let StageGroups { independent, last } = &self.groups;
        let mut summary = Summary {
            simulated: last.context.clock.elapsed(),
            ..Summary::default()
        };
        for group in independent.iter().chain([last]) {
            group.summarise(&mut summary);
        }
        summary
    }

    /// All groups, in the order of their records.
    fn groups_mut(&mut self) -> impl Iterator<Item = &mut StageGroup> {
        let StageGroups { independent, last } = &mut self.groups;
        independent.iter_mut().chain([last])
    }
}

#[cfg(test)]
#[path = "analyse_tests.rs"]
mod tests;
