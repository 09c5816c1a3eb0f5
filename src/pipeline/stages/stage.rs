//! Trait of the analysis stages, and their shared state.

use super::choices::DelayChoices;
use super::clock::Clock;
use crate::analysis::tones::Bases;
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record, Summary};

/// An analysis stage. It processes the frames of a run one by one.
pub trait Stage: Send {
    /// Processes the next frame, and adds records to the context.
    fn push(&mut self, frame: &Frame, context: &mut Context) -> Result<(), AnalyseError>;

    /// Observes a record of an earlier stage; ignored by default.
    fn observe(&mut self, _record: &Record) {}

    /// Adds the remaining records after the last frame; none by default.
    fn finish(&mut self, _context: &mut Context) {}

    /// Adds the results of the stage to the summary of the run; none by default.
    fn summarise(&self, _summary: &mut Summary) {}
}

/// The context of a stage: state shared by the stages.
pub struct Context {
    /// Times of the samples.
    pub clock: Clock,
    /// Delays and dimensions chosen so far.
    pub choices: DelayChoices,
    /// Base frequencies of the lines of the last spectrum: other stages use the same names.
    pub bases: Bases,
    /// Broadband share of the last spectrum; 1 if its window is not full, or too short for a floor between lines.
    pub floor: f64,
    /// Every so many windows of an analysis that is only displayed are computed.
    pub rate_divisor: u64,
    /// Records of the present frame so far.
    pub records: Vec<Record>,
}

impl Context {
    /// For samples at `rate` (Hz).
    pub fn new(rate: f64) -> Self {
        Self {
            clock: Clock::new(rate),
            choices: DelayChoices::default(),
            bases: Bases::None,
            floor: 1.0,
            rate_divisor: 1,
            records: Vec::new(),
        }
    }

    /// Time of the newest of `seen` samples, s.
    pub fn newest(&self, seen: u64) -> f64 {
        self.clock.time(seen as f64 - 1.0)
    }
}
