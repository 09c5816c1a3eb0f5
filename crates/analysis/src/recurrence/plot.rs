//! Recurrence plots, Eq. (26).

use super::recurrences::distances;
use super::{RateBase, RecurrenceCriterion, Recurrences, Threshold};
use crate::{AnalysisError, delay::DelayVectors, norm::Norm, stats::deviation};

/// Image of a recurrence plot, Eq. (26), of the delay vectors, Eq. (25), of a window of a signal.
///
/// Pixel `(i, j)` shows the distance between the states at two instants. A periodic motion gives unbroken diagonals one
/// period apart, a torus diagonals with a second, longer spacing, and chaos short, interrupted diagonals (Marwan et al.,
/// Phys. Rep. 438, 237, 2007).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecurrenceImage {
    /// Length of the window, s.
    pub window: f64,
    /// Points per side.
    pub size: usize,
    /// Distance between the two states, 0 (equal) to 255 (maximum of the window):
    /// `distance[i * size + j]`, oldest first.
    pub distance: Vec<u8>,
    /// 255 where recurrent, else 0; in the same order.
    pub recurrent: Vec<u8>,
    /// Threshold distance, in the signal's unit; `None` for a separate threshold per state.
    pub threshold: Option<f64>,
    /// Recurrence rate of the counted pairs, 0 to 1.
    pub rate: f64,
    /// Lag, s.
    pub lag: f64,
    /// Embedding dimension.
    pub dimension: usize,
}

impl RecurrenceImage {
    /// Image of the vectors with the given indices, oldest first. The window of the signal has this length and its
    /// samples this spacing, s. All pairs are drawn; the Theiler window is in states of the image.
    ///
    /// # Errors
    /// As [`Recurrences::of`], and [`AnalysisError::InvalidDelay`] without indices.
    ///
    /// # Panics
    /// If an index is not below [`DelayVectors::len`].
    pub fn new(
        vectors: &DelayVectors<'_>,
        indices: &[usize],
        criterion: &RecurrenceCriterion,
        window: f64,
        dt: f64,
    ) -> Result<Self, AnalysisError> {
        let size = indices.len();
        let coordinates = (0..vectors.dimension()).map(|c| vectors.coordinate(c));
        // Vectors whose lag is their number.
        let states: Vec<f64> = coordinates
            .flat_map(|coordinate| indices.iter().map(|&k| coordinate[k]))
            .collect();
        let states = DelayVectors::new(&states, size, vectors.dimension())?;
        let threshold = match criterion.threshold {
            Threshold::Spread(times) => Threshold::Distance(times * deviation(vectors.samples())),
            threshold => threshold,
        };
        let criterion = RecurrenceCriterion {
            threshold,
            ..*criterion
        };
        let recurrences = Recurrences::of(&states, &criterion)?;
        let measures = recurrences.counts().measures(2, 2, RateBase::Counted);
        let row = |i| distances(criterion.norm, &states, 0..size, states.vector(i));
        let mut unrooted: Vec<f64> = Vec::with_capacity(size * size);
        unrooted.extend((0..size).flat_map(row));
        let rows = unrooted.chunks(size);
        let pairs = rows.flat_map(|row| row.iter().zip(&recurrences.limits));
        let pixel = |(distance, limit)| if distance <= limit { 255 } else { 0 };
        Ok(Self {
            window,
            size,
            recurrent: pairs.map(pixel).collect(),
            distance: shades(&unrooted, criterion.norm),
            threshold: recurrences.distance(),
            rate: measures.recurrence_rate,
            lag: vectors.lag() as f64 * dt,
            dimension: vectors.dimension(),
        })
    }
}

/// Shades of unrooted distances: 0 for equal states, 255 for the largest distance. All 0 if all states are equal.
fn shades(unrooted: &[f64], norm: Norm) -> Vec<u8> {
    let largest = unrooted.iter().copied().fold(0.0, f64::max);
    let scale = if largest > 0.0 { 1.0 / largest } else { 0.0 };
    let shade = |unrooted: &f64| {
        // Single precision exceeds the resolution of a pixel.
        let share = (unrooted * scale) as f32;
        let distance = if norm == Norm::Euclidean {
            share.sqrt()
        } else {
            share
        };
        (distance * 255.0 + 0.5) as u8
    };
    unrooted.iter().map(shade).collect()
}

#[cfg(test)]
#[path = "plot_tests.rs"]
mod tests;
