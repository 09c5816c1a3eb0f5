//! Warning about a reduced contact whose force was too inaccurate.

use super::stage::{Context, Emit, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record};

/// Emits [`Record::Warning`] once, when the run continues with all contact nodes.
#[derive(Default)]
pub struct ReductionStage {
    reported: bool,
}

impl Stage for ReductionStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Some(reduction) = frame.reduction.filter(|_| !self.reported) else {
            return Ok(());
        };
        let Some(time) = reduction.all_nodes_since_s else {
            return Ok(());
        };
        self.reported = true;
        emit(Record::Warning {
            time,
            text: format!(
                "the force of the {} kept contact nodes had a relative error of {:.1e}, above \
                 contact.reduction = {:e}: all {} nodes are evaluated from {:.3} ms on",
                reduction.kept_nodes,
                reduction.errors.max,
                reduction.tolerance,
                reduction.nodes,
                1e3 * time
            ),
        })
    }
}
