//! Stages that run one after the other on the same thread.

use super::stage::{Context, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record};

/// A group of stages with a common context. Each observes the records of those before it.
pub struct StageGroup {
    /// State shared by the stages.
    pub context: Context,
    /// The stages.
    pub stages: Vec<Box<dyn Stage>>,
}

impl StageGroup {
    /// Groups stages for samples at `rate` (Hz).
    pub fn new(stages: Vec<Box<dyn Stage>>, rate: f64) -> Self {
        Self {
            context: Context::new(rate),
            stages,
        }
    }

    /// The records of the next frame, for which other groups have the records `others`.
    pub fn analyse(
        &mut self,
        frame: &Frame,
        others: &[Record],
    ) -> Result<Vec<Record>, AnalyseError> {
        let Self { context, stages } = self;
        let mut rest = &mut stages[..];
        for record in others {
            rest.iter_mut().for_each(|stage| stage.observe(record));
        }
        while let Some((stage, later)) = rest.split_first_mut() {
            let known = context.records.len();
            stage.push(frame, context)?;
            for record in &context.records[known..] {
                later.iter_mut().for_each(|stage| stage.observe(record));
            }
            rest = later;
        }
        Ok(std::mem::take(&mut context.records))
    }

    /// The remaining records after the last frame.
    pub fn finish(&mut self) -> Vec<Record> {
        for stage in &mut self.stages {
            stage.finish(&mut self.context);
        }
        std::mem::take(&mut self.context.records)
    }
}
