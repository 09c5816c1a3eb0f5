//! Warning about events too frequent to stop at each of them.

use super::stage::{Context, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record};

/// Emits [`Record::Warning`] once, when a step has passed over events.
#[derive(Default)]
pub struct ChatterStage {
    reported: bool,
}

impl Stage for ChatterStage {
    fn push(&mut self, frame: &Frame, context: &mut Context) -> Result<(), AnalyseError> {
        if let Some(time) = frame.unlocated_since.filter(|_| !self.reported) {
            self.reported = true;
            let text = format!(
                "from {:.3} ms on, contact nodes separate and close too often to stop at each event: \
                 some steps integrate over their events, as all steps do with time.events = \"through\"; \
                 error control still applies to these steps",
                1e3 * time
            );
            context.records.push(Record::Warning { time, text });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chatter_is_reported_once() {
        let mut stage = ChatterStage::default();
        let mut context = Context::new(1e5);
        for (unlocated_since, t0) in [(None, 0.0), (Some(1e-3), 0.9e-3), (Some(1e-3), 2e-3)] {
            let frame = Frame {
                t0,
                unlocated_since,
                ..Frame::default()
            };
            stage.push(&frame, &mut context).unwrap();
        }
        let [Record::Warning { time, text }] = &context.records[..] else {
            panic!("{:?}", context.records)
        };
        assert_eq!(*time, 1e-3);
        assert!(text.contains("from 1.000 ms on, contact nodes"), "{text}");
        assert!(!text.contains("  "), "{text}");
    }
}
