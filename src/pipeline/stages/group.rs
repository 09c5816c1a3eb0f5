//! Stages that run one after the other on the same thread.

use super::stage::{Context, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record, Summary};

/// Groups of all stages of a run.
pub struct StageGroups {
    /// Groups that do not depend on each other, in the order of their records.
    pub independent: Vec<StageGroup>,
    /// The stages that observe the records of all other groups.
    pub last: StageGroup,
}

impl StageGroups {
    /// Groups of the given stages, for samples at `rate` (Hz).
    pub fn new(
        independent: Vec<Vec<Box<dyn Stage>>>,
        last: Vec<Box<dyn Stage>>,
        rate: f64,
    ) -> Self {
        let group = |stages| StageGroup {
            context: Context::new(rate),
            stages,
        };
        let with_stages = independent.into_iter().filter(|stages| !stages.is_empty());
        Self {
            independent: with_stages.map(group).collect(),
            last: group(last),
        }
    }
}

/// A group of stages with a common context. Each observes the records of those before it.
pub struct StageGroup {
    /// State shared by the stages.
    pub context: Context,
    stages: Vec<Box<dyn Stage>>,
}

impl StageGroup {
    /// The records of the next frame.
    pub fn analyse(&mut self, frame: &Frame) -> Result<Vec<Record>, AnalyseError> {
        self.context.clock.check(frame)?;
        let mut records = Vec::new();
        self.observe(frame, &mut records)?;
        Ok(records)
    }

    /// Observes the records of other groups for the next frame, and appends those of this group.
    pub fn observe(
        &mut self,
        frame: &Frame,
        records: &mut Vec<Record>,
    ) -> Result<(), AnalyseError> {
        let mut rest = &mut self.stages[..];
        for record in &*records {
            rest.iter_mut().for_each(|stage| stage.observe(record));
        }
        while let Some((stage, later)) = rest.split_first_mut() {
            let mut emit = |record| {
                later.iter_mut().for_each(|stage| stage.observe(&record));
                records.push(record);
                Ok(())
            };
            stage.push(frame, &mut self.context, &mut emit)?;
            rest = later;
        }
        self.context.clock.advance(frame);
        Ok(())
    }

    /// The remaining records after the last frame.
    pub fn finish(&mut self) -> Result<Vec<Record>, AnalyseError> {
        let mut records = Vec::new();
        let mut emit = |record| {
            records.push(record);
            Ok(())
        };
        for stage in &mut self.stages {
            stage.finish(&mut self.context, &mut emit)?;
        }
        Ok(records)
    }

    /// Adds the results of the stages to the summary of the run.
    pub fn summarise(&self, summary: &mut Summary) {
        self.stages
            .iter()
            .for_each(|stage| stage.summarise(summary));
    }
}
