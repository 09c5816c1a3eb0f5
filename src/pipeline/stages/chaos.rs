//! Chaos from the probe's displacement alone: how neighbours part, and the 0-1 test.

use std::sync::Arc;

use super::choices::Unfolding;
use super::{Context, Emit, Stage, samples, sliding};
use crate::analysis::{
    DivergenceMethod, DivergenceSearch, SlidingWindow, ZeroOneTest, divergence, zero_one,
};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::{ChaosSpec, DelaySpec};

/// States followed in a window, at most; more make the curve smoother, but hardly different.
const MOST_REFERENCES: usize = 500;

/// Emits [`Record::Chaos`]. A window of which nothing can be said, such as a constant one, is
/// passed over.
///
/// The 0-1 test takes one sample a delay: samples that follow more closely hide chaos.
pub struct ChaosStage {
    sliding: SlidingWindow<1>,
    unfolding: Unfolding,
    theiler: usize,
    horizon: usize,
    method: DivergenceMethod,
    rate: f64,
}

impl ChaosStage {
    /// For samples at `rate` (Hz); `delay` is the scene's choice of delays.
    pub fn new(spec: &ChaosSpec, delay: Option<&DelaySpec>, rate: f64) -> Self {
        Self {
            sliding: sliding(&spec.sliding, rate),
            unfolding: Unfolding::new(&spec.embedding, delay, rate),
            theiler: samples(spec.theiler, rate, 1),
            horizon: samples(spec.horizon, rate, 1),
            method: spec.method,
            rate,
        }
    }
}

impl Stage for ChaosStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self {
            sliding,
            unfolding,
            theiler,
            horizon,
            method,
            rate,
        } = self;
        sliding.space_out(frame.apart());
        sliding.push([&frame.displacement], |view| {
            let [displacement] = view.channels;
            let Some(embedding) = unfolding.at(view.seen, &context.choices) else {
                return Ok(());
            };
            let search = DivergenceSearch {
                lag: embedding.lag,
                dimension: embedding.dimension,
                theiler: *theiler,
                horizon: *horizon,
                method: *method,
                most_references: MOST_REFERENCES,
            };
            let test = ZeroOneTest::with_stride(embedding.lag);
            let (Ok(divergence), Ok(zero_one)) = (
                divergence(displacement, &search),
                zero_one(displacement, &test),
            ) else {
                return Ok(());
            };
            emit(Record::Chaos {
                time: context.newest(view.seen),
                window: displacement.len() as f64 / *rate,
                dt: 1.0 / *rate,
                divergence: Arc::new(divergence),
                zero_one: Arc::new(zero_one),
            })
        })
    }
}
