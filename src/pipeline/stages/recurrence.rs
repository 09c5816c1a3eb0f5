//! Recurrence plots and delay reconstruction of the probe's displacement.

use std::sync::Arc;

use super::choices::{Embedding, StageEmbedding};
use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Windowed, displacement};
use crate::analysis::{
    delay::DelayVectors,
    recurrence::{RecurrenceCriterion, RecurrenceImage},
    sliding::SlidingWindow,
};
use crate::pipeline::message::Record;
use crate::scene::{DelaySpec, RecurrenceSpec};

/// Dimension of the drawn delay reconstruction.
const TRAIL_DIMENSION: usize = 3;

/// Emits [`Record::Recurrence`] and [`Record::Embedding`] of the same window, as soon as all delayed samples
/// exist. Samples come at `rate` (Hz); `delay` is the delay analysis of the scene.
///
/// The lag is rounded to whole samples (at least one) and reported as rounded. Delay vectors use all samples.
/// A plot shows `size` of them, evenly distributed over the window and including the newest one. The
/// reconstruction shows all of them.
pub fn recurrence(
    spec: &RecurrenceSpec,
    delay: Option<&DelaySpec>,
    rate: f64,
) -> impl Stage + use<> {
    let length = samples(spec.window, rate, 1);
    let unfolding = StageEmbedding::new(&spec.embedding, delay, rate);
    let max = unfolding.max();
    let longest = DelayVectors::samples_for(length, max.lag, max.dimension.max(TRAIL_DIMENSION));
    let sliding = SlidingWindow::new(longest, spec.every * rate).with_min_length(length);
    let size = spec.size.min(length);
    let spacing = length as f64 / size as f64;
    let pick = |i: usize| (i as f64 * spacing).round() as usize - 1;
    // Indices of the plotted vectors within the window.
    let picks: Vec<usize> = (1..=size).map(pick).collect();
    let criterion = RecurrenceCriterion {
        norm: spec.criterion.norm,
        threshold: spec.criterion.threshold,
        theiler: 1,
    };
    Windowed::new(sliding, displacement, move |window, context| {
        let Some(Embedding { lag, dimension }) = unfolding.at(window.seen, &context.choices) else {
            return Ok(Vec::new());
        };
        let [signal] = window.channels;
        let reach = |m: usize| DelayVectors::samples_for(length, lag, m);
        if signal.len() < reach(dimension.max(TRAIL_DIMENSION)) {
            return Ok(Vec::new());
        }
        let newest = |m: usize| DelayVectors::new(&signal[signal.len() - reach(m)..], lag, m);
        let time = window.time;
        let image = RecurrenceImage::new(
            &newest(dimension)?,
            &picks,
            &criterion,
            length as f64 / rate,
            1.0 / rate,
        );
        let image = Arc::new(image?);
        let trail = newest(TRAIL_DIMENSION)?;
        // The record starts with the newest coordinate; in Eq. (25) it is the last one.
        let [oldest, middle, now] = [0, 1, 2].map(|c| trail.coordinate(c));
        let points = now.iter().zip(middle).zip(oldest);
        let points = points.map(|((a, b), c)| [*a as f32, *b as f32, *c as f32]);
        let points = points.collect();
        let trail = Record::Embedding { time, points };
        Ok(vec![Record::Recurrence { time, image }, trail])
    })
}
