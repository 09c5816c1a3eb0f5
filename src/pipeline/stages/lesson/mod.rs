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

use std::collections::VecDeque;
use std::sync::Arc;

use measured::LessonMeasurements;

use super::clock::samples;
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
    /// Records of other stages that are not processed yet, with their times, s, in time order.
    found: VecDeque<(f64, Record)>,
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
            found: VecDeque::new(),
            every: samples(EVERY, header.sample_rate, 1) as u64,
            seen: 0,
            sent: None,
        })
    }

    /// Processes the records of other stages up to a time, s.
    fn take_found(&mut self, until: f64, records: &mut Vec<Record>) {
        while let Some((time, found)) = self.found.pop_front_if(|(time, _)| *time <= until) {
            if let Some(tone) = self.measured.take(time, found) {
                records.push(self.level_sample(time, Some(tone)));
            }
        }
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

    /// Keeps a record of another stage until its time.
    fn observe(&mut self, record: &Record) {
        let time = match record {
            Record::Spectrum { time, .. } | Record::Regime { time, .. } => *time,
            Record::TrajectoryDivergence(divergence) => divergence.time_s,
            Record::Exponents(exponents) => exponents.time,
            _ => return,
        };
        // The stages of one frame report one after the other, each in time order.
        let place = self.found.partition_point(|(known, _)| *known <= time);
        self.found.insert(place, (time, record.clone()));
    }

    /// Processes a frame, and adds records to those of the other stages.
    pub fn push(&mut self, frame: &Frame, records: &mut Vec<Record>) {
        records.iter().for_each(|record| self.observe(record));
        if self.sent.is_none() {
            self.send(frame.t0, records);
        }
        self.measured.begin_frame(frame);
        for k in 0..frame.len() {
            // Half a sample of tolerance: times are sums of rounded numbers.
            let time = frame.time(k);
            self.take_found(time + 0.5 * frame.dt, records);
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
        self.take_found(f64::INFINITY, &mut records);
        if self.seen > 0 {
            self.send(time, &mut records);
        }
        records
    }
}
