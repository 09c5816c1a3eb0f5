//! The division of an orbit into segments.

use nalgebra::{DMatrix, DVector};

use super::ContinuationError;
use super::flow::Flow;
use super::newton::Precision;
use super::point::Point;
use super::shooting::{Scale, ShootingPoint, parameter_of};
use crate::System;

/// Points of an orbit at which its first division is considered.
const CANDIDATES: usize = 64;

/// Longest segment of the first division, as a share of the period.
const LONGEST: f64 = 0.5;

/// Maximum natural logarithm of the ratio between the largest and the smallest growth of the flow over a segment, which sets
/// the number of segments. The relative error of the smallest multipliers is the tolerance of the integration times this
/// ratio.
const MAX_LOG_RATIO: f64 = 8.0;

/// Share of the maximum growth ratio at which a segment ends.
const SHARE: f64 = 0.6;

impl Flow<'_> {
    /// Divides a motion from `state`, which returns after about `period` (s), into segments.
    pub fn divide(
        &mut self,
        sys: &dyn System,
        guess: &ShootingPoint,
        scale: &Scale,
    ) -> Result<ShootingPoint, ContinuationError> {
        let mut state = guess.states[0].clone();
        let mut shot = guess.with_segments(vec![0.0], vec![state.clone()]);
        let mut start = 0.0;
        let mut map = DMatrix::identity(state.len(), state.len());
        for k in 1..CANDIDATES {
            let phase = k as f64 / CANDIDATES as f64;
            let [from, to] = [(k - 1) as f64 / CANDIDATES as f64, phase];
            let step = self.piece(sys, guess, state, [from, to])?;
            map = &step.1 * map;
            state = step.0;
            let ratio = log_ratio(&scale.scaled_map(&map));
            let is_long = phase - start >= LONGEST * (1.0 - 1e-9);
            if ratio >= SHARE * MAX_LOG_RATIO || is_long {
                shot.phases.push(phase);
                shot.states.push(state.clone());
                start = phase;
                map.fill_with_identity();
            }
        }
        Ok(shot)
    }

    /// The end and the derivative of the flow between two phases of an orbit, from a state.
    fn piece(
        &mut self,
        sys: &dyn System,
        orbit: &ShootingPoint,
        state: DVector<f64>,
        span: [f64; 2],
    ) -> Result<(DVector<f64>, DMatrix<f64>), ContinuationError> {
        // One segment between the two phases.
        let whole = orbit.with_segments(span.to_vec(), vec![state]);
        let mut ends = self.segments(sys, &whole, true)?;
        Ok((ends.ends.remove(0), ends.maps.remove(0)))
    }

    /// An orbit with the segments of another one.
    pub fn with_phases(
        &mut self,
        point: &Point,
        phases: &[f64],
    ) -> Result<Point, ContinuationError> {
        let old = &point.shot;
        let sys = self.system(old.parameter)?;
        let mut shot = old.with_segments(phases.to_vec(), Vec::new());
        for &phase in phases {
            // The segment of the old division that contains the phase.
            let k = old.phases.partition_point(|&start| start <= phase) - 1;
            let mut state = old.states[k].clone();
            if phase > old.phases[k] {
                let span = [old.phases[k], phase];
                state = self.piece(sys.as_ref(), old, state, span)?.0;
            }
            shot.states.push(state);
        }
        let mut other = self.point(&shot, &point.scale, None, Precision::Branch)?;
        if (parameter_of(&other.tangent) < 0.0) != (parameter_of(&point.tangent) < 0.0) {
            other.tangent.neg_mut();
        }
        Ok(other)
    }

    /// Divides the segments whose growth ratio is too large; `None` if there are none.
    pub fn refine(
        &mut self,
        shot: &ShootingPoint,
        maps: &[DMatrix<f64>],
        scale: &Scale,
    ) -> Result<Option<ShootingPoint>, ContinuationError> {
        let ratios: Vec<f64> = maps
            .iter()
            .map(|map| log_ratio(&scale.scaled_map(map)))
            .collect();
        if ratios.iter().all(|&ratio| ratio <= MAX_LOG_RATIO) {
            return Ok(None);
        }
        let sys = self.system(shot.parameter)?;
        let mut refined = shot.with_segments(Vec::new(), Vec::new());
        for (k, ratio) in ratios.iter().enumerate() {
            let [from, to] = shot.span(k);
            refined.phases.push(from);
            refined.states.push(shot.states[k].clone());
            if *ratio <= MAX_LOG_RATIO {
                continue;
            }
            let pieces = (ratio / (SHARE * MAX_LOG_RATIO)).ceil().max(2.0) as usize;
            let phase = |piece: usize| from + (to - from) * piece as f64 / pieces as f64;
            let mut state = shot.states[k].clone();
            for piece in 1..pieces {
                let span = [phase(piece - 1), phase(piece)];
                state = self.piece(sys.as_ref(), shot, state, span)?.0;
                refined.phases.push(phase(piece));
                refined.states.push(state.clone());
            }
        }
        Ok(Some(refined))
    }
}

/// Natural logarithm of the ratio between the largest and the smallest singular value that is not a rounding error.
fn log_ratio(map: &DMatrix<f64>) -> f64 {
    let values = map.singular_values();
    let largest = values.max();
    let rounding = 4.0 * map.nrows() as f64 * f64::EPSILON * largest;
    let least = values
        .iter()
        .filter(|&&value| value > rounding)
        .fold(largest, |least, &value| least.min(value));
    if least > 0.0 {
        (largest / least).ln()
    } else {
        0.0
    }
}
