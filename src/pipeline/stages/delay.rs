//! Choice of delay and embedding dimension from the probe's displacement.

use std::sync::Arc;

use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Windowed, displacement, sliding};
use crate::analysis::delay::{DelaySearch, choose_delay};
use crate::pipeline::message::Record;
use crate::scene::DelaySpec;

/// Emits [`Record::Delay`] of samples at `rate` (Hz) and stores each choice for the later stages.
///
/// A window without a valid choice is skipped.
pub fn delay(spec: &DelaySpec, rate: f64) -> impl Stage + use<> {
    let search = DelaySearch {
        largest_lag: samples(spec.largest_lag, rate, 1),
        bins: spec.bins,
        largest_dimension: spec.largest_dimension,
        false_share: spec.false_share,
    };
    let sliding = sliding(spec.window, spec.every, rate);
    Windowed::new(sliding, displacement, move |window, context| {
        let [signal] = window.channels;
        let Ok(choice) = choose_delay(signal, &search) else {
            return Ok(None);
        };
        context.choices.note(window.seen, &choice);
        Ok(Some(Record::Delay {
            time: window.time,
            dt: 1.0 / rate,
            choice: Arc::new(choice),
        }))
    })
}
