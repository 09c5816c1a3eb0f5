//! Analyses of delay vectors of the probe's displacement: choice of delay and dimension, recurrence plots, recurrence
//! quantification, and signs of chaos.
//!
//! Delays and dimensions are given by the scene or chosen from the signal.

use std::sync::Arc;

use super::stage::{Stage, displacement, samples, sliding, windowed};
use crate::analysis::{
    chaos::{DivergenceSearch, ZeroOneTest, divergence, zero_one},
    delay::{DelayChoice, DelaySearch, DelayVectors, choose_delay},
    recurrence::{RateBase, RecurrenceCriterion, RecurrenceImage, Recurrences},
    sliding::SlidingWindow,
};
use crate::pipeline::message::Record;
use crate::scene::{ChaosSpec, DelaySpec, EmbeddingSpec, QuantificationSpec, RecurrenceSpec};

/// Dimension of the drawn delay reconstruction.
const TRAIL_DIMENSION: usize = 3;
/// Maximum number of reference states per window for the divergence of nearby states. More references make the curve only
/// slightly smoother.
const MAX_REFERENCES: usize = 500;

/// Delay and dimension of delay vectors, Eq. (25).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Embedding {
    /// Delay `tau`, samples.
    pub lag: usize,
    /// Dimension `m`.
    pub dimension: usize,
}

/// The choices with their instants. A stage that evaluates an earlier instant sees the choice of that
/// instant, independent of the frames.
#[derive(Debug, Default)]
pub struct DelayChoices {
    /// Number of samples at the choice, and the choice; only changes are stored.
    made: Vec<(u64, Embedding)>,
}

impl DelayChoices {
    /// Stores a choice made after `seen` samples.
    pub fn note(&mut self, seen: u64, choice: &DelayChoice) {
        let embedding = Embedding {
            lag: choice.lag,
            dimension: choice.dimension,
        };
        if self.made.last().is_none_or(|(_, last)| *last != embedding) {
            self.made.push((seen, embedding));
        }
    }

    /// The last choice made after at most `seen` samples.
    fn at(&self, seen: u64) -> Option<Embedding> {
        let known = self.made.partition_point(|(when, _)| *when <= seen);
        known.checked_sub(1).map(|last| self.made[last].1)
    }
}

/// Delay and dimension of a stage, each given or chosen.
#[derive(Clone, Copy, Debug)]
pub struct StageEmbedding {
    lag: Option<usize>,
    dimension: Option<usize>,
    /// Largest possible delay and dimension.
    max: Embedding,
}

impl StageEmbedding {
    /// For samples at `rate` (Hz); `delay` limits the automatic choice. A delay is rounded to whole samples,
    /// at least one.
    pub fn new(spec: &EmbeddingSpec, delay: Option<&DelaySpec>, rate: f64) -> Self {
        let lag = spec.lag.map(|lag| samples(lag, rate, 1));
        let dimension = spec.dimension;
        let limits = delay.map_or([1; 2], |delay| {
            [samples(delay.largest_lag, rate, 1), delay.largest_dimension]
        });
        Self {
            lag,
            dimension,
            max: Embedding {
                lag: lag.unwrap_or(limits[0]),
                dimension: dimension.unwrap_or(limits[1]),
            },
        }
    }

    /// Delay and dimension after `seen` samples; `None` until both are known.
    pub fn at(&self, seen: u64, choices: &DelayChoices) -> Option<Embedding> {
        let chosen = choices.at(seen);
        Some(Embedding {
            lag: self.lag.or(chosen.map(|chosen| chosen.lag))?,
            dimension: self.dimension.or(chosen.map(|chosen| chosen.dimension))?,
        })
    }
}

/// Emits [`Record::Delay`] of samples at `rate` (Hz) and stores each choice for the later stages.
///
/// A window without a valid choice is skipped.
pub fn delay(spec: &DelaySpec, rate: f64) -> Stage {
    let search = DelaySearch {
        largest_lag: samples(spec.largest_lag, rate, 1),
        bins: spec.bins,
        largest_dimension: spec.largest_dimension,
        false_share: spec.false_share,
    };
    let sliding = sliding(spec.window, spec.every, rate);
    windowed(displacement, sliding, true, move |window, context| {
        if let Ok(choice) = choose_delay(window.signal, &search) {
            context.choices.note(window.seen, &choice);
            context.records.push(Record::Delay {
                time: window.time,
                dt: 1.0 / rate,
                choice: Arc::new(choice),
            });
        }
        Ok(())
    })
}

/// Emits [`Record::Recurrence`] and [`Record::Embedding`] of the same window, as soon as all delayed samples
/// exist. Samples come at `rate` (Hz); `delay` is the delay analysis of the scene.
///
/// The lag is rounded to whole samples (at least one) and reported as rounded. Delay vectors use all samples.
/// A plot shows `size` of them, evenly distributed over the window and including the newest one. The
/// reconstruction shows all of them.
pub fn recurrence(spec: &RecurrenceSpec, delay: Option<&DelaySpec>, rate: f64) -> Stage {
    let length = samples(spec.window, rate, 1);
    let unfolding = StageEmbedding::new(&spec.embedding, delay, rate);
    let max = unfolding.max;
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
    windowed(displacement, sliding, true, move |window, context| {
        let (signal, time) = (window.signal, window.time);
        let Some(Embedding { lag, dimension }) = unfolding.at(window.seen, &context.choices) else {
            return Ok(());
        };
        let reach = |m: usize| DelayVectors::samples_for(length, lag, m);
        if signal.len() < reach(dimension.max(TRAIL_DIMENSION)) {
            return Ok(());
        }
        let newest = |m: usize| DelayVectors::new(&signal[signal.len() - reach(m)..], lag, m);
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
        let records = [Record::Recurrence { time, image }, trail];
        context.records.extend(records);
        Ok(())
    })
}

/// Emits [`Record::Quantification`] of samples at `rate` (Hz); `delay` is the delay analysis of the scene. A
/// window without a result is skipped.
///
/// States are sampled every `step`, counted from the first sample of the run. The step is rounded to whole
/// samples and the delay to whole steps, at least one each. Line lengths are in states.
///
/// Each window is evaluated from scratch: 1.3 ms for 2000 states of `doubled-torus-3deg` or `periodic-2deg` with a
/// fixed threshold.
pub fn quantification(spec: &QuantificationSpec, delay: Option<&DelaySpec>, rate: f64) -> Stage {
    let step = samples(spec.step, rate, 1);
    let states_per_second = rate / step as f64;
    let dt = 1.0 / states_per_second;
    let states = samples(spec.window, states_per_second, 1);
    // A delay in whole steps.
    let steps = move |lag: usize| ((lag + step / 2) / step).max(1);
    let unfolding = StageEmbedding::new(&spec.embedding, delay, rate);
    let max = unfolding.max;
    let longest = DelayVectors::samples_for(states, steps(max.lag), max.dimension);
    let mut sliding =
        SlidingWindow::new(longest, spec.every * states_per_second).with_min_length(states);
    let rule = RecurrenceCriterion {
        norm: spec.criterion.norm,
        threshold: spec.criterion.threshold,
        theiler: samples(spec.theiler, states_per_second, 1),
    };
    let (least_diagonal, least_vertical) = (spec.least_diagonal, spec.least_vertical);
    // Number of samples to skip before the next state.
    let mut skip = 0;
    Box::new(move |frame, context| {
        let samples = &frame.displacement;
        let kept: Vec<f64> = samples.iter().skip(skip).step_by(step).copied().collect();
        skip = skip + kept.len() * step - samples.len();
        context.limit(&mut sliding, frame, step as u64);
        sliding.push([&kept], |view| {
            let seen = (view.seen - 1) * step as u64 + 1;
            let Some(Embedding { lag, dimension }) = unfolding.at(seen, &context.choices) else {
                return Ok(());
            };
            let [signal] = view.channels;
            let need = DelayVectors::samples_for(states, steps(lag), dimension);
            let Some(from) = signal.len().checked_sub(need) else {
                return Ok(());
            };
            let vectors = DelayVectors::new(&signal[from..], steps(lag), dimension)?;
            if let Ok(recurrences) = Recurrences::of(&vectors, &rule) {
                let counts = recurrences.counts();
                context.records.push(Record::Quantification {
                    time: context.clock.time(seen as f64 - 1.0),
                    dt,
                    threshold: recurrences.distance(),
                    measures: counts.measures(least_diagonal, least_vertical, RateBase::Counted),
                    periods: counts.periods().in_seconds(dt),
                });
            }
            Ok(())
        })
    })
}

/// Emits [`Record::Chaos`] of samples at `rate` (Hz); `delay` is the delay analysis of the scene. A window
/// without a result, such as a constant signal, is skipped.
///
/// The 0-1 test uses one sample per delay: oversampled data appear regular.
pub fn chaos(spec: &ChaosSpec, delay: Option<&DelaySpec>, rate: f64) -> Stage {
    let unfolding = StageEmbedding::new(&spec.embedding, delay, rate);
    let theiler = samples(spec.theiler, rate, 1);
    let horizon = samples(spec.horizon, rate, 1);
    let method = spec.method;
    let sliding = sliding(spec.window, spec.every, rate);
    windowed(displacement, sliding, true, move |window, context| {
        let Some(Embedding { lag, dimension }) = unfolding.at(window.seen, &context.choices) else {
            return Ok(());
        };
        let search = DivergenceSearch {
            lag,
            dimension,
            theiler,
            horizon,
            method,
            max_references: MAX_REFERENCES,
        };
        let test = ZeroOneTest::with_stride(lag);
        if let (Ok(divergence), Ok(zero_one)) = (
            divergence(window.signal, &search),
            zero_one(window.signal, &test),
        ) {
            context.records.push(Record::Chaos {
                time: window.time,
                dt: 1.0 / rate,
                divergence: Arc::new(divergence),
                zero_one: Arc::new(zero_one),
            });
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::delay::{FalseNeighbours, LagReason, MutualInformation};

    fn choice(lag: usize, dimension: usize) -> DelayChoice {
        DelayChoice {
            lag,
            reason: LagReason::FirstMinimum,
            dimension,
            unfolded: true,
            theiler: 1,
            mutual: MutualInformation {
                bins: 2,
                bits: Vec::new(),
            },
            neighbours: FalseNeighbours {
                lag,
                share: Vec::new(),
                evaluated: Vec::new(),
            },
        }
    }

    #[test]
    fn a_choice_applies_from_its_instant_to_the_next() {
        let mut choices = DelayChoices::default();
        choices.note(100, &choice(7, 3));
        choices.note(200, &choice(7, 3));
        choices.note(300, &choice(9, 4));
        assert_eq!(choices.made.len(), 2);
        let lag = |seen| choices.at(seen).map(|embedding| embedding.lag);
        assert_eq!(
            [lag(99), lag(100), lag(299), lag(300)],
            [None, Some(7), Some(7), Some(9)]
        );
    }

    #[test]
    fn given_values_are_not_replaced_by_a_choice() {
        let mut choices = DelayChoices::default();
        let spec = |lag, dimension| EmbeddingSpec { lag, dimension };
        let given = spec(Some(60e-6), Some(5));
        let given = StageEmbedding::new(&given, None, 200e3).at(0, &choices);
        assert_eq!(
            given,
            Some(Embedding {
                lag: 12,
                dimension: 5
            })
        );
        let half = spec(None, Some(5));
        let half = StageEmbedding::new(&half, None, 200e3);
        assert_eq!(half.at(10, &choices), None);
        choices.note(10, &choice(7, 3));
        assert_eq!(
            half.at(10, &choices),
            Some(Embedding {
                lag: 7,
                dimension: 5
            })
        );
    }
}
