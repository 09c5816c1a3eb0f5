//! Recurrence plots and the trail of delay vectors of the probe's displacement.

use super::choices::{Embedding, Unfolding};
use super::{Context, Emit, Stage, samples};
use crate::analysis::{DelayVectors, RecurrencePlot, SlidingWindow, Threshold};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::{DelaySpec, RecurrenceSpec};

/// Coordinates of the trail: what can be drawn.
const TRAIL_DIMENSION: usize = 3;

/// Emits [`Record::Recurrence`] and [`Record::Embedding`] over the same window, from the first
/// instant on at which all delayed samples exist.
///
/// The lag is rounded to whole samples (at least one), and told as rounded. Delay vectors are
/// built of the samples as they are; a plot shows `size` of them, evenly spread over the window,
/// the newest included. The trail shows them all.
pub struct RecurrenceStage {
    sliding: SlidingWindow<1>,
    plot: RecurrencePlot,
    /// Indices of the plotted vectors among those of the window.
    picks: Vec<usize>,
    /// Vectors in the window.
    window: usize,
    unfolding: Unfolding,
    threshold: Threshold,
    rate: f64,
}

impl RecurrenceStage {
    /// For samples at `rate` (Hz); `delay` is the scene's choice of delays.
    pub fn new(spec: &RecurrenceSpec, delay: Option<&DelaySpec>, rate: f64) -> Self {
        let window = samples(spec.sliding.window, rate, 1);
        let unfolding = Unfolding::new(&spec.embedding, delay, rate);
        let most = unfolding.most();
        let size = spec.size.min(window);
        let spacing = window as f64 / size as f64;
        let pick = |i: usize| (i as f64 * spacing).round() as usize - 1;
        let dimension = most.dimension.max(TRAIL_DIMENSION);
        let reach = DelayVectors::samples_for(window, most.lag, dimension);
        Self {
            sliding: SlidingWindow::new(reach, spec.sliding.every * rate).starting_with(window),
            plot: RecurrencePlot::with(spec.nearness.norm, 1),
            picks: (1..=size).map(pick).collect(),
            window,
            unfolding,
            threshold: spec.nearness.threshold,
            rate,
        }
    }
}

impl Stage for RecurrenceStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self {
            sliding,
            plot,
            picks,
            window,
            unfolding,
            threshold,
            rate,
        } = self;
        sliding.space_out(frame.apart());
        sliding.push([&frame.displacement], |view| {
            let Some(Embedding { lag, dimension }) = unfolding.at(view.seen, &context.choices)
            else {
                return Ok(());
            };
            let reach = |m: usize| DelayVectors::samples_for(*window, lag, m);
            let [displacement] = view.channels;
            if displacement.len() < reach(dimension.max(TRAIL_DIMENSION)) {
                return Ok(());
            }
            let newest = |m: usize| {
                DelayVectors::new(&displacement[displacement.len() - reach(m)..], lag, m)
            };
            let time = context.newest(view.seen);
            plot.measure(&newest(dimension)?, picks);
            let recurrences = plot.recurrences(*threshold)?;
            emit(Record::Recurrence {
                time,
                window: *window as f64 / *rate,
                size: plot.size(),
                distance: plot.distance_picture(),
                recurrent: recurrences.pixels,
                threshold: recurrences.distance,
                rate: recurrences.rate,
                lag: lag as f64 / *rate,
                dimension,
            })?;
            let trail = newest(TRAIL_DIMENSION)?;
            // The record has the newest coordinate first; Eq. (25) has it last.
            let [oldest, middle, now] = [0, 1, 2].map(|c| trail.coordinate(c));
            let points = now.iter().zip(middle).zip(oldest);
            emit(Record::Embedding {
                time,
                points: points
                    .map(|((a, b), c)| [*a as f32, *b as f32, *c as f32])
                    .collect(),
            })
        })
    }
}
