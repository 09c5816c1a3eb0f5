//! The lesson of a scene that shows a mechanism: what it is, what to look at, and numbers measured
//! in this run beside those computed before it.
//!
//! It hears what the other stages say, so that its numbers are those on the screen, and measures
//! the rest itself. What was computed comes from [`Computed`](crate::pipeline::message::Computed)
//! and stands in a table of its own.

mod measured;
mod page;
mod tilts;
mod words;

use std::collections::VecDeque;
use std::sync::Arc;

use measured::Measured;

use super::{Context, Emit, Stage, samples};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Computed, Course, Frame, Header, Record, TiltedTone};
use crate::scene::{AnalysisSpec, Mechanism};

/// Time from one look to the next, s: a lesson that changes more often cannot be read.
const EVERY: f64 = 25e-3;

/// Emits [`Record::Lesson`] when its words or rounded numbers change, at most every 25 ms, and
/// [`Record::Course`] twice a natural period.
pub struct LessonStage {
    computed: Arc<Computed>,
    measured: Measured,
    /// What the other stages have said and is not yet taken in, by its time, s.
    heard: VecDeque<(f64, Record)>,
    /// Samples from one look to the next.
    every: u64,
    seen: u64,
    told: Option<String>,
    /// Whether growth is compared with the computed one.
    foretells: bool,
}

impl LessonStage {
    /// For the run announced by `header`; `None` if its scene shows no mechanism.
    pub fn new(spec: &AnalysisSpec, header: &Header) -> Option<Self> {
        let computed = header.computed.clone()?;
        let foretells = matches!(
            computed.mechanism,
            Mechanism::NegativeSlope | Mechanism::ModeCoupling | Mechanism::ExchangedFriction
        );
        Some(Self {
            measured: Measured::new(spec, header, &computed),
            computed,
            heard: VecDeque::new(),
            every: samples(EVERY, header.sample_rate, 1) as u64,
            seen: 0,
            told: None,
            foretells,
        })
    }

    /// Hears what another stage says.
    pub fn hear(&mut self, record: &Record) {
        let time = match record {
            Record::Spectrum { time, .. } => *time,
            Record::Parting(parting) => parting.time,
            Record::Exponents(exponents) => exponents.time,
            _ => return,
        };
        self.heard.push_back((time, record.clone()));
    }

    /// Takes in what was said up to a time, s.
    fn listen(&mut self, until: f64) -> Vec<Record> {
        let mut courses = Vec::new();
        while self.heard.front().is_some_and(|(time, _)| *time <= until) {
            let Some((time, record)) = self.heard.pop_front() else {
                break;
            };
            let tone = self.measured.hear(record);
            courses.extend(tone.map(|tone| self.course(time, Some(tone))));
        }
        courses
    }

    /// The course at a time, s.
    fn course(&self, time: f64, tone: Option<TiltedTone>) -> Record {
        let growth = self.computed.fastest().filter(|_| self.foretells);
        Record::Course(Course {
            time,
            level: self.measured.envelope.level(),
            foretold: growth.and_then(|growth| self.measured.envelope.foretold(time, growth)),
            tone,
        })
    }

    /// Tells what there is to tell, if it differs from what was told.
    fn tell(&mut self, time: f64, emit: &mut Emit<'_>) -> Result<(), AnalyseError> {
        let text = words::page(&self.computed, &self.measured).markdown();
        if self.told.as_ref() == Some(&text) {
            return Ok(());
        }
        self.told = Some(text.clone());
        emit(Record::Lesson { time, text })
    }
}

impl Stage for LessonStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        if self.told.is_none() {
            self.tell(frame.t0, emit)?;
        }
        self.measured.enter(frame);
        for k in 0..frame.len() {
            // Half a sample of slack: times are sums of rounded numbers.
            let time = frame.time(k);
            for course in self.listen(time + 0.5 * frame.dt) {
                emit(course)?;
            }
            if self.measured.sample(frame, k) {
                emit(self.course(time, None))?;
            }
            self.seen += 1;
            if self.seen.is_multiple_of(self.every) {
                self.measured.conclude();
                self.tell(time, emit)?;
            }
        }
        Ok(())
    }

    fn finish(&mut self, context: &mut Context, emit: &mut Emit<'_>) -> Result<(), AnalyseError> {
        let end = context.time(self.seen as f64 - 1.0);
        for course in self.listen(f64::INFINITY) {
            emit(course)?;
        }
        if self.seen == 0 {
            return Ok(());
        }
        self.tell(end, emit)
    }
}
