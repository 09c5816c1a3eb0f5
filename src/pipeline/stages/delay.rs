//! The choice of delay and dimension from the probe's displacement.

use std::sync::Arc;

use super::{Context, Emit, Stage, samples, sliding};
use crate::analysis::{DelaySearch, SlidingWindow, choose_delay};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::DelaySpec;

/// Emits [`Record::Delay`], and notes each choice for the stages that follow it.
///
/// A window in which nothing can be chosen is passed over.
pub struct DelayStage {
    sliding: SlidingWindow<1>,
    search: DelaySearch,
    rate: f64,
}

impl DelayStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: &DelaySpec, rate: f64) -> Self {
        Self {
            sliding: sliding(&spec.sliding, rate),
            search: DelaySearch {
                largest_lag: samples(spec.largest_lag, rate, 1),
                bins: spec.bins,
                largest_dimension: spec.largest_dimension,
                false_share: spec.false_share,
                theiler: None,
            },
            rate,
        }
    }
}

impl Stage for DelayStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self {
            sliding,
            search,
            rate,
        } = self;
        sliding.space_out(frame.apart());
        sliding.push([&frame.displacement], |view| {
            let [displacement] = view.channels;
            let Ok(choice) = choose_delay(displacement, search) else {
                return Ok(());
            };
            context.choices.note(view.seen, &choice);
            emit(Record::Delay {
                time: context.newest(view.seen),
                window: displacement.len() as f64 / *rate,
                dt: 1.0 / *rate,
                choice: Arc::new(choice),
            })
        })
    }
}
