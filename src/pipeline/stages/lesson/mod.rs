//! The lesson of a scene that shows a mechanism: what is measured in this run, to set against what was
//! computed before it.
//!
//! It observes the records of the other stages, so that its numbers are those on the screen, and measures
//! the rest itself. What was computed comes from [`Computed`].

mod measured;
mod tilts;

use std::collections::VecDeque;
use std::sync::Arc;

use measured::{Found, Measured};

use super::clock::samples;
use super::stage::{Context, Emit, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{
    Computed, Course, Frame, Header, Lesson, Measurements, Record, TiltedTone,
};
use crate::scene::{AnalysisSpec, Mechanism};

/// Time from one lesson to the next, s: one that changes more often cannot be read.
const EVERY: f64 = 25e-3;

/// Emits [`Record::Lesson`] when a measurement has changed, every 25 ms at most, and [`Record::Course`]
/// twice a natural period.
pub struct LessonStage {
    computed: Arc<Computed>,
    measured: Measured,
    /// What the other stages have found and is not yet taken in, by its time, s.
    found: VecDeque<(f64, Found)>,
    /// Samples from one lesson to the next.
    every: u64,
    seen: u64,
    sent: Option<Measurements>,
    /// Whether growth is compared with the computed one.
    predicts: bool,
}

impl LessonStage {
    /// For the run announced by `header`; `None` if its scene shows no mechanism.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Option<Self> {
        let computed = header.computed.clone()?;
        let predicts = matches!(
            computed.mechanism,
            Mechanism::NegativeSlope | Mechanism::ModeCoupling | Mechanism::ExchangedFriction
        );
        Some(Self {
            measured: Measured::new(spec, header, &computed),
            computed,
            found: VecDeque::new(),
            every: samples(EVERY, header.sample_rate, 1) as u64,
            seen: 0,
            sent: None,
            predicts,
        })
    }

    /// Takes in what was found up to a time, s.
    fn take_found(&mut self, until: f64) -> Vec<Record> {
        let mut courses = Vec::new();
        while let Some((time, found)) = self.found.pop_front_if(|(time, _)| *time <= until) {
            let tone = self.measured.take(time, found);
            courses.extend(tone.map(|tone| self.course(time, Some(tone))));
        }
        courses
    }

    /// The course at a time, s.
    fn course(&self, time: f64, tone: Option<TiltedTone>) -> Record {
        let growth = self.computed.fastest().filter(|_| self.predicts);
        let level = &self.measured.level;
        Record::Course(Course {
            time,
            level: level.last,
            predicted: growth.and_then(|growth| level.predicted(time, growth)),
            tone,
        })
    }

    /// Sends the measurements, if they differ from what was sent.
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
            Record::Spectrum { time, peaks, .. } => (*time, Found::Lines(peaks.clone())),
            Record::Parting(parting) => (parting.time, Found::Parting(*parting)),
            Record::Exponents(exponents) => {
                (exponents.time, Found::Exponents(Arc::clone(exponents)))
            }
            _ => return,
        };
        self.found.push_back(found);
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
        self.measured.enter(frame);
        for k in 0..frame.len() {
            // Half a sample of slack: times are sums of rounded numbers.
            let time = frame.time(k);
            for course in self.take_found(time + 0.5 * frame.dt) {
                emit(course)?;
            }
            if self.measured.sample(frame, k) {
                emit(self.course(time, None))?;
            }
            self.seen += 1;
            if self.seen.is_multiple_of(self.every) {
                self.measured.conclude();
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
