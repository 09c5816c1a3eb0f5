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

use measured::{LessonMeasurements, StageResult};

use super::clock::samples;
use super::stage::{Context, Emit, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{
    Frame, Header, Lesson, LevelSample, Measurements, MechanismPrediction, Record, TiltedTone,
};
use crate::scene::{AnalysisSpec, Mechanism};

/// Minimum time between two lessons, s: a text that changes more often is unreadable.
const EVERY: f64 = 25e-3;

/// Emits [`Record::Lesson`] if a measurement has changed, at most every 25 ms, and [`Record::LevelSample`] twice
/// per natural period.
pub struct LessonStage {
    computed: Arc<MechanismPrediction>,
    measured: LessonMeasurements,
    /// Results of other stages that are not processed yet, with their times, s, in time order.
    found: VecDeque<(f64, StageResult)>,
    /// Number of samples between two lessons.
    every: u64,
    seen: u64,
    sent: Option<Measurements>,
    /// Whether the growth is compared with the predicted one.
    predicts: bool,
}

impl LessonStage {
    /// For the run described by `header`; `None` if its scene has no mechanism.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Option<Self> {
        let computed = header.computed.clone()?;
        let predicts = matches!(
            computed.mechanism,
            Mechanism::NegativeSlope
                | Mechanism::ModeCoupling
                | Mechanism::ExchangedFriction
                | Mechanism::Bristles
                | Mechanism::ContactAge
                | Mechanism::MeasuredFriction
        );
        Some(Self {
            measured: LessonMeasurements::new(spec, header, &computed),
            computed,
            found: VecDeque::new(),
            every: samples(EVERY, header.sample_rate, 1) as u64,
            seen: 0,
            sent: None,
            predicts,
        })
    }

    /// Processes the results of other stages up to a time, s.
    fn take_found(&mut self, until: f64) -> Vec<Record> {
        let mut courses = Vec::new();
        while let Some((time, found)) = self.found.pop_front_if(|(time, _)| *time <= until) {
            let tone = self.measured.take(time, found);
            courses.extend(tone.map(|tone| self.course(time, Some(tone))));
        }
        courses
    }

    /// Level and prediction at a time, s.
    fn course(&self, time: f64, tone: Option<TiltedTone>) -> Record {
        let growth = self.computed.fastest().filter(|_| self.predicts);
        let level = &self.measured.level;
        Record::LevelSample(LevelSample {
            time,
            level: level.last,
            predicted: growth.and_then(|growth| level.predicted(time, growth)),
            tone,
        })
    }

    /// Emits the measurements if they have changed.
    fn send(&mut self, time: f64, emit: &mut Emit<'_>) -> Result<(), AnalyseError> {
        let measured = self.measured.measurements();
        if self.sent.as_ref() == Some(&measured) {
            return Ok(());
        }
        self.sent = Some(measured.clone());
        emit(Record::Lesson(Arc::new(Lesson {
            time,
            computed: Arc::clone(&self.computed),
            measured,
        })))
    }
}

impl Stage for LessonStage {
    fn observe(&mut self, record: &Record) {
        let found = match record {
            Record::Spectrum { time, peaks, .. } => (*time, StageResult::Lines(peaks.clone())),
            Record::TrajectoryDivergence(divergence) => (
                divergence.time,
                StageResult::TrajectoryDivergence(*divergence),
            ),
            Record::Regime { time, verdict, .. } => (*time, StageResult::Regime(verdict.regime)),
            Record::Exponents(exponents) => (
                exponents.time,
                StageResult::Exponents(Arc::clone(exponents)),
            ),
            _ => return,
        };
        // The stages of one frame report one after the other, each in time order.
        let place = self.found.partition_point(|(time, _)| *time <= found.0);
        self.found.insert(place, found);
    }

    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        if self.sent.is_none() {
            self.send(frame.t0, emit)?;
        }
        self.measured.begin_frame(frame);
        for k in 0..frame.len() {
            // Half a sample of tolerance: times are sums of rounded numbers.
            let time = frame.time(k);
            for course in self.take_found(time + 0.5 * frame.dt) {
                emit(course)?;
            }
            if self.measured.sample(frame, k) {
                emit(self.course(time, None))?;
            }
            self.seen += 1;
            if self.seen.is_multiple_of(self.every) {
                self.measured.evaluate();
                self.send(time, emit)?;
            }
        }
        Ok(())
    }

    fn finish(&mut self, context: &mut Context, emit: &mut Emit<'_>) -> Result<(), AnalyseError> {
        let end = context.newest(self.seen);
        for course in self.take_found(f64::INFINITY) {
            emit(course)?;
        }
        if self.seen == 0 {
            return Ok(());
        }
        self.send(end, emit)
    }
}
