//! Warning about a reduced contact whose force was too inaccurate.

use super::stage::{Context, Emit, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record};

/// Stage that follows the reduction of the contact: emits [`Record::Warning`] when the run continues with
/// other nodes, and when it continues with all nodes.
#[derive(Default)]
pub struct ReductionStage {
    /// Time of the last change that was reported, s.
    reported: Option<f64>,
}

impl Stage for ReductionStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Some(reduction) = frame.reduction else {
            return Ok(());
        };
        let changed = reduction.all_nodes_since_s.or(reduction.nodes_changed_at_s);
        let Some(time) = changed.filter(|_| changed != self.reported) else {
            return Ok(());
        };
        self.reported = changed;
        let now = match reduction.all_nodes_since_s {
            Some(_) => format!("all {} nodes are evaluated", reduction.nodes),
            None => format!("{} other nodes are evaluated", reduction.kept_nodes),
        };
        let tolerance = reduction.tolerance;
        let text = match time {
            0.0 => format!("no few nodes reach contact.reduction = {tolerance:e}: {now}"),
            _ => format!(
                "the error of the reduced contact exceeded contact.reduction = {tolerance:e}: {now} from \
                 {:.3} ms on",
                1e3 * time
            ),
        };
        emit(Record::Warning { time, text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::ContactReduction;

    #[test]
    fn each_change_of_the_nodes_is_reported_once() {
        let mut stage = ReductionStage::default();
        let mut reported = Vec::new();
        let before = ContactReduction::new(100, 16, 1e-5);
        let changed = ContactReduction {
            nodes_changed_at_s: Some(2e-3),
            ..before
        };
        let all = ContactReduction {
            all_nodes_since_s: Some(3e-3),
            ..changed
        };
        for reduction in [before, changed, changed, all, all] {
            let frame = Frame {
                reduction: Some(reduction),
                ..Frame::default()
            };
            let mut emit = |record| {
                reported.push(record);
                Ok(())
            };
            stage
                .push(&frame, &mut Context::new(1e5), &mut emit)
                .unwrap();
        }
        let [
            Record::Warning { text: first, .. },
            Record::Warning { time, text },
        ] = &reported[..]
        else {
            panic!("{reported:?}")
        };
        assert!(
            first.contains("16 other nodes are evaluated from 2.000 ms on"),
            "{first}"
        );
        assert!(text.contains("1e-5: all 100 nodes"), "{text}");
        assert_eq!(*time, 3e-3);
    }
}
