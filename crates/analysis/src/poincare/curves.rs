//! Number of closed curves in the section of a torus.
//!
//! On a torus the return map is a rotation: the points of the section, in the order of time, are values
//! of a closed curve at the phases `k rho`. The rotation number `rho` follows from the strongest line in
//! the spectrum of the sequence. Sorted by phase, neighbouring points are then neighbours on the curve.
//!
//! A doubling of the torus divides the points in one of three ways. If the second return map is the
//! rotation, the section consists of two closed curves, which the motion visits in turn. Otherwise there
//! is one curve that goes round twice before it closes, with the rotation number `rho/2` or
//! `(rho + 1)/2`. Each possibility is compared by the distance of the points from the straight lines
//! between their neighbours in phase, which falls to the curvature of the curve once the points are
//! divided correctly. It does not matter how close the two parts are to each other.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::shape::distance;
use crate::stats::order_statistic;
use crate::tones::{LineCriterion, Spectrum, SpectrumAnalyser, Window};

/// Minimum number of points on each curve, per time that it goes round.
const MIN_POINTS: usize = 32;

/// Largest number of curves.
const MAX_CURVES: usize = 8;

/// Numbers of times that a curve can go round, for up to two doublings.
const WINDINGS: [usize; 3] = [1, 2, 4];

/// Largest square distance of points from the lines between their neighbours on closed curves, as a share
/// of the variance on each curve. A cloud has about 1.
const MAX_RESIDUAL: f64 = 0.01;

/// Largest gap between the phases of points on a closed curve, in turns of the strongest oscillation. Bands of chaos and points have
/// rational rotation numbers and larger gaps.
const MAX_GAP: f64 = 1.0 / 16.0;

/// A division of the points is accepted if it reduces the square distance by this factor. A
/// division that does not exist increases the distances or, with noise, leaves them the same.
const MIN_REDUCTION: f64 = 3.0;

/// First step of the search for the rotation number, divided by the square of the number of points, and
/// the number of steps to each side; each further step is a third of the one before.
const FIRST_STEP: f64 = 0.3;
const REACHES: [i32; 4] = [6, 2, 2, 2];

/// Window of the spectra of the sequence.
const WINDOW: Window = Window::BlackmanHarris;

/// Closed curves of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub struct ClosedCurves {
    /// Number of curves: 1 for a torus, 2 or more if the motion visits several in turn.
    pub count: usize,
    /// Number of times that the strongest oscillation along each curve repeats before it closes: 1, or 2
    /// or 4 for a torus that has doubled in length.
    pub windings: usize,
}

/// Closed curves on which the points of a section lie, in the order of time; all points are slices of
/// equal length. `None` if they do not lie on closed curves, or are fewer than 32 per curve.
///
/// Meant for sections that are not a few points, see [`section_shape`](super::section_shape).
pub fn closed_curves(points: &[&[f64]]) -> Option<ClosedCurves> {
    let mut best: Option<(ClosedCurves, f64)> = None;
    // From few parts to many.
    let most = MAX_CURVES.min(points.len() / MIN_POINTS);
    for count in 1..=most {
        let parts = Parts::new(points, count);
        let Some(rotation) = parts.rotation() else {
            continue;
        };
        for windings in WINDINGS.into_iter().filter(|w| w * count <= most) {
            let divided = (0..windings).map(|j| (rotation + j as f64) / windings as f64);
            let residual = divided
                .map(|rotation| parts.least_residual(rotation, MAX_GAP / windings as f64))
                .fold(f64::INFINITY, f64::min);
            let is_curve = residual <= MAX_RESIDUAL * parts.variance;
            if is_curve && best.is_none_or(|(_, least)| residual < least / MIN_REDUCTION) {
                best = Some((ClosedCurves { count, windings }, residual));
            }
        }
    }
    best.map(|(found, _)| found)
}

/// The points of a section, divided into those that the motion visits in turn.
struct Parts {
    /// The points of each part, relative to their mean.
    parts: Vec<Vec<Vec<f64>>>,
    /// Mean square distance from the mean.
    variance: f64,
}

impl Parts {
    fn new(points: &[&[f64]], count: usize) -> Self {
        // Equal lengths, as the spectra are added.
        let length = points.len() / count;
        let part = |first: usize| -> Vec<Vec<f64>> {
            let part = || points[first..].iter().step_by(count).take(length);
            let mean: Vec<f64> = (0..points[0].len())
                .map(|c| part().map(|point| point[c]).sum::<f64>() / length as f64)
                .collect();
            let centred = part().map(|point| point.iter().zip(&mean).map(|(x, mean)| x - mean));
            centred.map(Iterator::collect).collect()
        };
        let parts: Vec<Vec<Vec<f64>>> = (0..count).map(part).collect();
        let squares = parts.iter().flatten().flatten().map(|x| x * x);
        let variance = squares.sum::<f64>() / (count * length) as f64;
        Self { parts, variance }
    }

    /// The coordinates of each part as series.
    fn series(&self) -> impl Iterator<Item = Vec<f64>> {
        self.parts.iter().flat_map(|part| {
            let coordinate = |c: usize| part.iter().map(|point| point[c]).collect();
            (0..part[0].len()).map(coordinate)
        })
    }

    /// Rotation number of the return to the same part, from 0 to 1/2; the direction is not determined.
    /// `None` without a spectral line.
    fn rotation(&self) -> Option<f64> {
        let mut analyser = SpectrumAnalyser::new(WINDOW, 1.0);
        let mut sum: Option<Spectrum> = None;
        for series in self.series() {
            let mut spectrum = analyser.analyse(&series).ok()?;
            if let Some(sum) = sum {
                let both = spectrum.amplitude.iter_mut().zip(sum.amplitude);
                both.for_each(|(a, b)| *a = a.hypot(b));
            }
            sum = Some(spectrum);
        }
        let criterion = LineCriterion {
            max_lines: 1,
            ..LineCriterion::default()
        };
        Some(sum?.lines(&criterion).first()?.frequency)
    }

    /// Smallest residual near a rotation number: the ordering by phase needs an error far
    /// below `1 / n^2` for `n` points.
    fn least_residual(&self, rotation: f64, max_gap: f64) -> f64 {
        let mut best = (self.residual(rotation, max_gap), rotation);
        let n = self.parts[0].len() as f64;
        let mut step = FIRST_STEP / (n * n);
        for reach in REACHES {
            let middle = best.1;
            for k in (1..=reach).flat_map(|k| [-k, k]) {
                let near = middle + f64::from(k) * step;
                let residual = self.residual(near, max_gap);
                if residual < best.0 {
                    best = (residual, near);
                }
            }
            step /= 3.0;
        }
        best.0
    }

    /// Square distance, exceeded by a tenth, of the points from the straight lines between their neighbours in phase,
    /// for a rotation number; infinite if a gap between the phases exceeds `max_gap`.
    fn residual(&self, rotation: f64, max_gap: f64) -> f64 {
        let mut squares = Vec::new();
        for part in &self.parts {
            let phase = |k: usize| (rotation * k as f64).rem_euclid(1.0);
            let mut order: Vec<(f64, usize)> = (0..part.len()).map(|k| (phase(k), k)).collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (i, &(phase, k)) in order.iter().enumerate() {
                let (before, left) = order[(i + order.len() - 1) % order.len()];
                let (after, right) = order[(i + 1) % order.len()];
                let [to_left, gap] = [phase - before, after - before].map(|d| d.rem_euclid(1.0));
                if to_left > max_gap {
                    return f64::INFINITY;
                }
                let share = if gap > 0.0 { to_left / gap } else { 0.5 };
                let between = part[left].iter().zip(&part[right]);
                let between: Vec<f64> = between.map(|(a, b)| a + share * (b - a)).collect();
                let spread = 1.0 + share * share + (1.0 - share) * (1.0 - share);
                squares.push(distance(&part[k], &between).powi(2) / spread);
            }
        }
        let middle = 9 * squares.len() / 10;
        order_statistic(squares, middle + 1)
    }
}
