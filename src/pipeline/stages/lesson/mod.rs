//! The lesson of a scene that demonstrates a mechanism: measurements of the run, for comparison with the
//! linear prediction.
//!
//! The stage observes the records of the other stages: its numbers agree with the displayed ones. It
//! measures the rest itself. The prediction is in [`MechanismPrediction`].

mod level;
mod measured;
mod second_tone;
mod tilt_history;
mod turning;

use std::sync::Arc;

use measured::LessonMeasurements;

use super::stage::samples;
use crate::pipeline::message::{
    Frame, Header, Lesson, LevelSample, Measurements, MechanismPrediction, Record, TiltedTone,
};
use crate::scene::{AnalysisSpec, Evidence};

/// Minimum time between two lessons, s: a text that changes more often is unreadable.
const EVERY: f64 = 25e-3;

/// Emits [`Record::Lesson`] if a measurement has changed, at most every 25 ms, and [`Record::LevelSample`] twice
/// per natural period.
pub struct LessonStage {
    computed: Arc<MechanismPrediction>,
    measured: LessonMeasurements,
    /// Number of samples between two lessons.
    every: u64,
    seen: u64,
    sent: Option<Measurements>,
}

impl LessonStage {
    /// For the run described by `header`; `None` if its scene has no mechanism.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Option<Self> {
        let computed = header.computed.clone()?;
        Some(Self {
            measured: LessonMeasurements::new(spec, header, &computed),
            computed,
            every: samples(EVERY, header.sample_rate, 1) as u64,
            seen: 0,
            sent: None,
        })
    }

    /// The velocity level at a time (s), or the strongest line at a tilt.
    fn level_sample(&self, time: f64, tone: Option<TiltedTone>) -> Record {
        let predicts = self.computed.mechanism.evidence() == Evidence::Growth;
        let growth = self.computed.fastest().filter(|_| predicts);
        let level = &self.measured.level;
        Record::LevelSample(LevelSample {
            time,
            level: level.last,
            predicted: growth.and_then(|growth| level.predicted(time, growth)),
            tone,
        })
    }

    /// Emits the measurements if they have changed.
    fn send(&mut self, time: f64, records: &mut Vec<Record>) {
        let measured = self.measured.measurements();
        if self.sent.as_ref() != Some(&measured) {
            self.sent = Some(measured.clone());
            records.push(Record::Lesson(Arc::new(Lesson {
                time,
                computed: Arc::clone(&self.computed),
                measured,
            })));
        }
    }

    /// Processes a frame, and adds records to those of the other stages.
    pub fn push(&mut self, frame: &Frame, records: &mut Vec<Record>) {
        let timed = |record: &Record| Some((time_of(record)?, record.clone()));
        let mut found: Vec<(f64, Record)> = records.iter().filter_map(timed).collect();
        // The stages report one after the other, each in time order.
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found = found.into_iter().peekable();
        if self.sent.is_none() {
            self.send(frame.t0, records);
        }
        self.measured.begin_frame(frame);
        for k in 0..frame.len() {
            let time = frame.time(k);
            // Half a sample of tolerance: times are sums of rounded numbers.
            let until = time + 0.5 * frame.dt;
            while let Some((at, record)) = found.next_if(|(at, _)| *at <= until) {
                if let Some(tone) = self.measured.take(at, record) {
                    records.push(self.level_sample(at, Some(tone)));
                }
            }
            if self.measured.sample(frame, k) {
                records.push(self.level_sample(time, None));
            }
            self.seen += 1;
            if self.seen.is_multiple_of(self.every) {
                self.measured.evaluate();
                self.send(time, records);
            }
        }
    }

    /// The remaining records after the last sample, at a time, s.
    pub fn finish(&mut self, time: f64) -> Vec<Record> {
        let mut records = Vec::new();
        if self.seen > 0 {
            self.send(time, &mut records);
        }
        records
    }
}

/// Time of a result of another stage that a lesson uses, s.
fn time_of(record: &Record) -> Option<f64> {
    match record {
        Record::Spectrum { time, .. } | Record::Regime { time, .. } => Some(*time),
        Record::TrajectoryDivergence(divergence) => Some(divergence.time_s),
        Record::Exponents(exponents) => Some(exponents.time),
        _ => None,
    }
}
