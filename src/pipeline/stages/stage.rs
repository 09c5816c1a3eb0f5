//! Analyses that run one after the other on the same thread, and the state that they share.

use super::choices::DelayChoices;
use super::clock::Clock;
use crate::analysis::{AnalysisError, tones::Bases};
use crate::pipeline::message::{Frame, Record};

/// An analysis of the frames of a run, one by one.
pub trait Stage: Send {
    /// Processes the next frame, and adds records to the context.
    fn push(&mut self, frame: &Frame, context: &mut Context) -> Result<(), AnalysisError>;
}

/// The context of a stage: state shared by the stages of a group.
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
}

/// A group of stages with a common context.
pub struct StageGroup {
    /// State shared by the stages.
    pub context: Context,
    /// The stages, each after those whose choices it uses.
    pub stages: Vec<Box<dyn Stage>>,
}

impl StageGroup {
    /// The records of the next frame.
    pub fn analyse(&mut self, frame: &Frame) -> Result<Vec<Record>, AnalysisError> {
        let Self { context, stages } = self;
        context.clock.advance(frame);
        stages
            .iter_mut()
            .try_for_each(|stage| stage.push(frame, context))?;
        Ok(std::mem::take(&mut context.records))
    }
}
