//! Recurrence plots and the trail of delay vectors of the probe's displacement.

use super::{Clock, Emit, samples};
use crate::analysis::{DelayVectors, RecurrencePlot, SlidingWindow};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::{RecurrenceSpec, RecurrenceThreshold};

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
    lag: usize,
    dimension: usize,
    threshold: RecurrenceThreshold,
    rate: f64,
}

impl RecurrenceStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: &RecurrenceSpec, rate: f64) -> Self {
        let window = samples(spec.window, rate, 1);
        let lag = samples(spec.lag, rate, 1);
        let size = spec.size.min(window);
        let spacing = window as f64 / size as f64;
        let pick = |i: usize| (i as f64 * spacing).round() as usize - 1;
        let reach = DelayVectors::samples_for(window, lag, spec.dimension.max(TRAIL_DIMENSION));
        Self {
            sliding: SlidingWindow::new(reach, spec.every * rate),
            plot: RecurrencePlot::new(),
            picks: (1..=size).map(pick).collect(),
            window,
            lag,
            dimension: spec.dimension,
            threshold: spec.threshold,
            rate,
        }
    }

    /// Takes the next frame.
    pub fn push(
        &mut self,
        frame: &Frame,
        clock: &Clock,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self {
            sliding,
            plot,
            picks,
            window,
            lag,
            dimension,
            threshold,
            rate,
        } = self;
        sliding.push([&frame.displacement], |view| {
            let newest = |dimension: usize| {
                let reach = DelayVectors::samples_for(*window, *lag, dimension);
                let samples = &view.channels[0][view.channels[0].len() - reach..];
                DelayVectors::new(samples, *lag, dimension)
            };
            let time = clock.time(view.seen as f64 - 1.0);
            plot.measure(&newest(*dimension)?, picks);
            let threshold = match *threshold {
                RecurrenceThreshold::Distance(distance) => distance,
                RecurrenceThreshold::Rate(share) => plot.distance_for_rate(share),
            };
            emit(Record::Recurrence {
                time,
                window: *window as f64 / *rate,
                size: plot.size(),
                distance: plot.distance_picture(),
                recurrent: plot.recurrence_picture(threshold),
                threshold,
                rate: plot.rate(threshold),
                lag: *lag as f64 / *rate,
                dimension: *dimension,
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
