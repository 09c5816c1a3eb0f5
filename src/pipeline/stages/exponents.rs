//! Lyapunov exponents of the simulated motion, and what they say in the end.

use std::sync::Arc;

use super::{Context, Emit, Stage, words};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Exponents, Frame, Record, Summary};

/// Emits [`Record::Exponents`], and at the end of the run [`Record::Narration`] of their verdict.
#[derive(Default)]
pub struct ExponentsStage {
    last: Option<Arc<Exponents>>,
}

impl Stage for ExponentsStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        for exponents in &frame.exponents {
            let exponents = Arc::new(exponents.clone());
            self.last = Some(Arc::clone(&exponents));
            emit(Record::Exponents(exponents))?;
        }
        Ok(())
    }

    fn finish(&mut self, context: &mut Context, emit: &mut Emit<'_>) -> Result<(), AnalyseError> {
        // What cannot be told yet is not told.
        let told = |last: &&Arc<Exponents>| last.attractor().is_decided();
        let Some(last) = self.last.as_ref().filter(told) else {
            return Ok(());
        };
        emit(Record::Narration {
            time: context.newest(context.clock.seen),
            text: words::exponents(last),
        })
    }

    fn summarise(&self, summary: &mut Summary) {
        summary.exponents = self.last.as_deref().cloned();
    }
}
