//! The recurrence plot and the recurrence periods of a motion.

use super::measure::{DIMENSION, LAG};
use super::settled::PhasePortrait;
use crate::analysis::{
    AnalysisError,
    delay::DelayVectors,
    recurrence::{
        Norm, RecurrenceCriterion, RecurrenceImage, RecurrencePeriods, Recurrences, Threshold,
    },
};

/// Length of the window, s; less if fewer samples were kept.
const WINDOW: f64 = 5e-3;

/// Maximum number of states compared, and maximum side of the picture in pixels.
const STATES: usize = 1000;
const SIZE: usize = 340;

/// Minimum number of states for a plot.
const MIN_STATES: usize = 16;

/// Recurrence rate that sets the threshold of the recurrence plot and periods, as in the scenes of the joint:
/// plots of strong and weak motions are then comparable.
const RATE: f64 = 0.1;

/// States per delay and maximum number of states for the recurrence periods.
const PERIOD_STATES_PER_LAG: usize = 12;
const PERIOD_STATES: usize = 4000;

/// The recurrence periods of the newest states of a signal for a delay (samples), in samples. They need wide stripes: more
/// states per delay and more recurrent pairs than the measures. There are none in too few samples.
///
/// # Errors
/// If the samples are not finite, or all are equal.
pub(in crate::study) fn recurrence_periods(
    samples: &[f64],
    lag: usize,
    dimension: usize,
    norm: Norm,
) -> Result<RecurrencePeriods, AnalysisError> {
    let step = (lag / PERIOD_STATES_PER_LAG).max(1);
    let lag = (lag / step).max(1);
    let taken = thinned(samples, step);
    let needed = DelayVectors::samples_for(PERIOD_STATES, lag, dimension);
    let taken = &taken[taken.len().saturating_sub(needed)..];
    if taken.len() < DelayVectors::samples_for(2 * lag, lag, dimension) {
        return Ok(RecurrencePeriods::default());
    }
    let vectors = DelayVectors::new(taken, lag, dimension)?;
    let rule = RecurrenceCriterion {
        norm,
        threshold: Threshold::Rate(RATE),
        theiler: lag,
    };
    let counts = Recurrences::of(&vectors, &rule)?.counts();
    Ok(counts.periods().in_seconds(step as f64))
}

/// Every `step`-th sample, including the newest.
pub(in crate::study) fn thinned(samples: &[f64], step: usize) -> Vec<f64> {
    let first = samples.len().saturating_sub(1) % step;
    samples[first..].iter().step_by(step).copied().collect()
}

impl PhasePortrait {
    /// The recurrence plot of the newest 5 ms: delay vectors of dimension 5 with a delay of 60 µs, a quarter
    /// period of 4.1 kHz. `None` if too few samples were kept.
    ///
    /// A pixel covers a few successive states. It is recurrent if any pair of its states is. Without this
    /// pooling, states spaced by a large part of a period show spurious broad bands, because the diagonals
    /// of a high tone fall between the pixels (aliasing).
    ///
    /// # Errors
    /// If the samples are not finite.
    pub fn recurrence(&self) -> Result<Option<RecurrenceImage>, AnalysisError> {
        let lag = ((LAG / self.dt).round() as usize).max(1);
        let reach = DelayVectors::samples_for(0, lag, DIMENSION);
        let wanted = (WINDOW / self.dt).round() as usize;
        let vectors = wanted.min(self.displacement.len().saturating_sub(reach));
        if vectors < MIN_STATES {
            return Ok(None);
        }
        let needed = DelayVectors::samples_for(vectors, lag, DIMENSION);
        let newest = &self.displacement[self.displacement.len() - needed..];
        let newest: Vec<f64> = newest.iter().map(|&u| f64::from(u)).collect();
        let step = vectors.div_ceil(STATES);
        let side = (vectors / step).div_ceil(SIZE);
        let size = vectors / step / side;
        // Counted from the newest state.
        let picks = (0..size * side).rev().map(|k| vectors - 1 - k * step);
        let criterion = RecurrenceCriterion {
            norm: Norm::Euclidean,
            threshold: Threshold::Rate(RATE),
            theiler: 1,
        };
        let found = RecurrenceImage::new(
            &DelayVectors::new(&newest, lag, DIMENSION)?,
            &picks.collect::<Vec<_>>(),
            &criterion,
            (size * side * step) as f64 * self.dt,
            self.dt,
        )?;
        Ok(Some(RecurrenceImage {
            size,
            distance: pooled(&found.distance, side, u8::min),
            recurrent: pooled(&found.recurrent, side, u8::max),
            ..found
        }))
    }
}

/// A square picture reduced by pooling `side x side` pixels into one.
fn pooled(picture: &[u8], side: usize, combine: fn(u8, u8) -> u8) -> Vec<u8> {
    let size = picture.len().isqrt();
    let rows = picture.chunks_exact((size * side).max(1));
    let combine = |a: Option<u8>, &b: &u8| Some(a.map_or(b, |a| combine(a, b)));
    rows.flat_map(|rows| {
        (0..size / side).map(move |column| {
            let pieces = rows.chunks_exact(size);
            let pieces = pieces.flat_map(|row| &row[column * side..][..side]);
            pieces.fold(None, combine).unwrap_or_default()
        })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::sines;

    fn portrait(samples: usize) -> PhasePortrait {
        let tone = sines(200e3, samples, &[(4000.0, 1e-6, 0.0)]);
        PhasePortrait {
            dt: 5e-6,
            displacement: tone.iter().map(|&u| u as f32).collect(),
            velocity: vec![0.0; samples],
            bin: 5.0,
            spectrum: Vec::new(),
        }
    }

    #[test]
    fn a_tone_recurs_after_its_period() {
        let plot = portrait(2000).recurrence().unwrap().unwrap();
        assert_eq!((plot.size, plot.dimension), (333, 5));
        assert!((plot.window - 4.995e-3).abs() < 1e-12 && (plot.lag - 60e-6).abs() < 1e-12);
        assert!((plot.rate - 0.1).abs() < 0.02, "{}", plot.rate);
        // 250 us are 50 samples; a pixel pools three.
        assert_eq!((plot.recurrent[50 / 3], plot.recurrent[25 / 3]), (255, 0));
        assert_eq!(plot.distance[0], 0);
    }

    #[test]
    fn a_short_signal_has_a_small_plot_or_none() {
        let plot = portrait(200).recurrence().unwrap().unwrap();
        assert_eq!(plot.size * plot.size, plot.recurrent.len());
        assert!(plot.size < 200);
        assert_eq!(portrait(50).recurrence().unwrap(), None);
        assert_eq!(portrait(0).recurrence().unwrap(), None);
    }

    #[test]
    fn pixels_are_pooled_in_squares() {
        let picture: Vec<u8> = (0..16).collect();
        assert_eq!(pooled(&picture, 2, u8::max), [5, 7, 13, 15]);
        assert_eq!(pooled(&picture, 2, u8::min), [0, 2, 8, 10]);
        assert_eq!(pooled(&picture, 1, u8::min), picture);
    }
}
