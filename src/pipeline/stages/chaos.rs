//! Chaos from the probe's displacement alone: divergence of nearby states, and the 0-1 test.

use std::sync::Arc;

use super::choices::Unfolding;
use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Windowed, displacement, sliding};
use crate::analysis::{DivergenceSearch, ZeroOneTest, divergence, zero_one};
use crate::pipeline::message::Record;
use crate::scene::{ChaosSpec, DelaySpec};

/// States followed in a window, at most; more make the curve smoother, but hardly different.
const MOST_REFERENCES: usize = 500;

/// Emits [`Record::Chaos`] of samples at `rate` (Hz); `delay` is the scene's choice of delays. A window
/// without a result, such as a constant one, is skipped.
///
/// The 0-1 test takes one sample a delay: samples that follow more closely hide chaos.
pub fn chaos(spec: &ChaosSpec, delay: Option<&DelaySpec>, rate: f64) -> impl Stage + use<> {
    let unfolding = Unfolding::new(&spec.embedding, delay, rate);
    let theiler = samples(spec.theiler, rate, 1);
    let horizon = samples(spec.horizon, rate, 1);
    let method = spec.method;
    let sliding = sliding(&spec.sliding, rate);
    Windowed::new(sliding, displacement, move |window, context, emit| {
        let Some(embedding) = unfolding.at(window.seen, &context.choices) else {
            return Ok(());
        };
        let search = DivergenceSearch {
            lag: embedding.lag,
            dimension: embedding.dimension,
            theiler,
            horizon,
            method,
            most_references: MOST_REFERENCES,
        };
        let test = ZeroOneTest::with_stride(embedding.lag);
        let [signal] = window.channels;
        let (Ok(divergence), Ok(zero_one)) = (divergence(signal, &search), zero_one(signal, &test))
        else {
            return Ok(());
        };
        emit(Record::Chaos {
            time: window.time,
            window: signal.len() as f64 / rate,
            dt: 1.0 / rate,
            divergence: Arc::new(divergence),
            zero_one: Arc::new(zero_one),
        })
    })
}
