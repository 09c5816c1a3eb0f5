//! The kind of motion, from the probe's displacement.

use std::sync::Arc;

use super::{Context, Emit, Stage, samples};
use crate::analysis::{RegimeSearch, SlidingWindow, classify};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::RegimeSpec;

/// Emits [`Record::Regime`]. A window of which nothing can be said is passed over.
pub struct RegimeStage {
    sliding: SlidingWindow<1>,
    search: RegimeSearch,
}

impl RegimeStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: &RegimeSpec, rate: f64) -> Self {
        Self {
            sliding: SlidingWindow::new(
                samples(spec.sliding.window, rate, 1),
                spec.sliding.every * rate,
            ),
            search: RegimeSearch {
                sample_rate: rate,
                silence: spec.silence,
            },
        }
    }
}

impl Stage for RegimeStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self { sliding, search } = self;
        sliding.push([&frame.displacement], |view| {
            let [displacement] = view.channels;
            let Ok(verdict) = classify(displacement, search) else {
                return Ok(());
            };
            emit(Record::Regime {
                time: context.newest(view.seen),
                window: displacement.len() as f64 / search.sample_rate,
                verdict: Arc::new(verdict),
            })
        })
    }
}
