//! What every stage of the analysis is, and what the stages share.

use super::choices::Choices;
use super::clock::Clock;
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record, Summary};

/// Where a stage puts its records.
pub type Emit<'a> = dyn FnMut(Record) -> Result<(), AnalyseError> + 'a;

/// A stage: takes the frames of a run one by one.
pub trait Stage: Send {
    /// Takes the next frame.
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError>;

    /// Takes a record that a stage before this one has emitted; by default ignored.
    fn observe(&mut self, _record: &Record) {}

    /// Emits what remains after the last frame; by default nothing.
    fn finish(&mut self, _context: &mut Context, _emit: &mut Emit<'_>) -> Result<(), AnalyseError> {
        Ok(())
    }

    /// Adds its results to the summary of the run; by default nothing.
    fn summarise(&self, _summary: &mut Summary) {}
}

/// What the stages share.
pub struct Context {
    /// The time of every sample.
    pub clock: Clock,
    /// Delays and dimensions chosen so far.
    pub choices: Choices,
}

impl Context {
    /// For samples at `rate` (Hz).
    pub fn new(rate: f64) -> Self {
        Self {
            clock: Clock::new(rate),
            choices: Choices::default(),
        }
    }

    /// Time of the newest of `seen` samples, s.
    pub fn newest(&self, seen: u64) -> f64 {
        self.clock.time(seen as f64 - 1.0)
    }
}
