//! Lyapunov exponents of the simulated motion, and the attractor that they indicate.

use std::sync::Arc;

use super::stage::{Context, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Exponents, Frame, Observation, Record, Summary};

/// Emits [`Record::Exponents`], and [`Record::Narration`] of the attractor at the end of the run.
#[derive(Default)]
pub struct ExponentsStage {
    last: Option<Arc<Exponents>>,
}

impl Stage for ExponentsStage {
    fn push(&mut self, frame: &Frame, context: &mut Context) -> Result<(), AnalyseError> {
        for exponents in &frame.exponents {
            let exponents = Arc::new(exponents.clone());
            self.last = Some(Arc::clone(&exponents));
            context.records.push(Record::Exponents(exponents));
        }
        Ok(())
    }

    fn finish(&mut self, context: &mut Context) {
        // An undecided attractor is not reported.
        let last = self.last.as_ref();
        if let Some(last) = last.filter(|last| last.attractor().is_decided()) {
            context.records.push(Record::Narration {
                time: context.newest(context.clock.seen()),
                observation: Observation::Exponents(Arc::clone(last)),
            });
        }
    }

    fn summarise(&self, summary: &mut Summary) {
        summary.exponents = self.last.as_deref().cloned();
    }
}
