//! Recurrence quantification of the probe's displacement.

use std::borrow::Cow;

use super::choices::StageEmbedding;
use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Windowed, input};
use crate::analysis::{
    delay::DelayVectors,
    recurrence::{RateBase, RecurrenceCriterion, Recurrences},
    sliding::SlidingWindow,
};
use crate::pipeline::message::Record;
use crate::scene::{DelaySpec, QuantificationSpec};

/// Emits [`Record::Quantification`] of samples at `rate` (Hz); `delay` is the delay analysis of the scene. A
/// window without a result is skipped.
///
/// States are sampled every `step`, counted from the first sample of the run. The step is rounded to whole
/// samples and the delay to whole steps, at least one each. Line lengths are in states.
///
/// Each window is evaluated from scratch: 1.3 ms for 2000 states of `doubled-torus-3deg` or `periodic-2deg` with a
/// fixed threshold.
pub fn quantification(
    spec: &QuantificationSpec,
    delay: Option<&DelaySpec>,
    rate: f64,
) -> impl Stage + use<> {
    let step = samples(spec.step, rate, 1);
    let states_per_second = rate / step as f64;
    let dt = 1.0 / states_per_second;
    let states = samples(spec.window, states_per_second, 1);
    let unfolding = StageEmbedding::new(&spec.embedding, delay, rate);
    let max = unfolding.max();
    let longest = DelayVectors::samples_for(states, steps(max.lag, step), max.dimension);
    let sliding =
        SlidingWindow::new(longest, spec.every * states_per_second).with_min_length(states);
    let rule = RecurrenceCriterion {
        norm: spec.criterion.norm,
        threshold: spec.criterion.threshold,
        theiler: samples(spec.theiler, states_per_second, 1),
    };
    let (least_diagonal, least_vertical) = (spec.least_diagonal, spec.least_vertical);
    // Number of samples to skip before the next state.
    let mut skip = 0;
    let input = input(move |frame| {
        let samples = &frame.displacement;
        let kept: Vec<f64> = samples.iter().skip(skip).step_by(step).copied().collect();
        skip = skip + kept.len() * step - samples.len();
        [Cow::Owned(kept)]
    });
    let measures = Windowed::new(sliding, input, move |window, context| {
        let Some(embedding) = unfolding.at(window.seen, &context.choices) else {
            return Ok(None);
        };
        let [signal] = window.channels;
        let lag = steps(embedding.lag, step);
        let need = DelayVectors::samples_for(states, lag, embedding.dimension);
        let Some(from) = signal.len().checked_sub(need) else {
            return Ok(None);
        };
        let vectors = DelayVectors::new(&signal[from..], lag, embedding.dimension)?;
        let Ok(recurrences) = Recurrences::of(&vectors, &rule) else {
            return Ok(None);
        };
        let counts = recurrences.counts();
        Ok(Some(Record::Quantification {
            time: window.time,
            dt,
            threshold: recurrences.distance(),
            measures: counts.measures(least_diagonal, least_vertical, RateBase::Counted),
            periods: counts.periods().in_seconds(dt),
        }))
    });
    measures.with_step(step)
}

/// A delay (samples) in whole steps, at least one.
fn steps(lag: usize, step: usize) -> usize {
    ((lag + step / 2) / step).max(1)
}
