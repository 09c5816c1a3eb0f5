//! A warning where events follow one another too fast to stop at each.

use super::stage::{Context, Emit, Stage};
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Record};

/// Emits [`Record::Warning`] once, when a step has run over its events.
#[derive(Default)]
pub struct ChatterStage {
    reported: bool,
}

impl Stage for ChatterStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        if self.reported || frame.tally.overrun == 0 {
            return Ok(());
        }
        self.reported = true;
        emit(Record::Warning {
            time: frame.t0,
            text: format!(
                "contact nodes open and close too often to stop at each, from {:.3} ms on: some \
                 steps run over their events, as all do with time.events = \"through\"; the control \
                 of the error still holds for them",
                1e3 * frame.t0
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chatter_is_told_once() {
        let mut stage = ChatterStage::default();
        let mut reported = Vec::new();
        for (overrun, t0) in [(0, 0.0), (2, 1e-3), (7, 2e-3)] {
            let mut frame = Frame {
                t0,
                ..Frame::default()
            };
            frame.tally.overrun = overrun;
            let mut emit = |record| {
                reported.push(record);
                Ok(())
            };
            stage
                .push(&frame, &mut Context::new(1e5), &mut emit)
                .unwrap();
        }
        let [Record::Warning { time, text }] = &reported[..] else {
            panic!("{reported:?}")
        };
        assert_eq!(*time, 1e-3);
        assert!(text.contains("from 1.000 ms on: some steps run"), "{text}");
        assert!(!text.contains("  "), "{text}");
    }
}
