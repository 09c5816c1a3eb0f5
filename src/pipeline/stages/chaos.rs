//! Chaos from the probe's displacement alone: divergence of nearby states, and the 0-1 test.

use std::sync::Arc;

use super::choices::StageEmbedding;
use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Windowed, displacement, sliding};
use crate::analysis::chaos::{DivergenceSearch, ZeroOneTest, divergence, zero_one};
use crate::pipeline::message::Record;
use crate::scene::{ChaosSpec, DelaySpec};

/// Maximum number of reference states per window. More references make the curve only slightly smoother.
const MAX_REFERENCES: usize = 500;

/// Emits [`Record::Chaos`] of samples at `rate` (Hz); `delay` is the delay analysis of the scene. A window
/// without a result, such as a constant signal, is skipped.
///
/// The 0-1 test uses one sample per delay: oversampled data appear regular.
pub fn chaos(spec: &ChaosSpec, delay: Option<&DelaySpec>, rate: f64) -> impl Stage + use<> {
    let unfolding = StageEmbedding::new(&spec.embedding, delay, rate);
    let theiler = samples(spec.theiler, rate, 1);
    let horizon = samples(spec.horizon, rate, 1);
    let method = spec.method;
    let sliding = sliding(spec.window, spec.every, rate);
    Windowed::new(sliding, displacement, move |window, context| {
        let Some(embedding) = unfolding.at(window.seen, &context.choices) else {
            return Ok(None);
        };
        let search = DivergenceSearch {
            lag: embedding.lag,
            dimension: embedding.dimension,
            theiler,
            horizon,
            method,
            max_references: MAX_REFERENCES,
        };
        let test = ZeroOneTest::with_stride(embedding.lag);
        let [signal] = window.channels;
        let (Ok(divergence), Ok(zero_one)) = (divergence(signal, &search), zero_one(signal, &test))
        else {
            return Ok(None);
        };
        Ok(Some(Record::Chaos {
            time: window.time,
            dt: 1.0 / rate,
            divergence: Arc::new(divergence),
            zero_one: Arc::new(zero_one),
        }))
    })
}
