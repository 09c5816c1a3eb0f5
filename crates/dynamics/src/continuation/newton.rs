//! Newton's method for multiple shooting.

use nalgebra::{DMatrix, DVector};

use super::ContinuationError;
use super::cyclic::{Entry, equations, phase_row, solve};
use super::flow::{Flow, SegmentEnds};
use super::shooting::{Direction, Scale, ShootingPoint, direction};
use crate::System;

/// Maximum number of iterations per orbit.
const MAX_ITERATIONS: u32 = 8;

/// Minimum factor by which a Newton correction is damped.
const MIN_DAMPING: f64 = 1.0 / 16.0;

/// Growth of the residual above which a correction is damped.
const MAX_GROWTH: f64 = 2.0;

/// Iterations after which the derivative with respect to the parameter is computed again.
const RENEWAL: u32 = 3;

/// Largest last correction of a point of a branch, relative to its size. The tangent belongs to the orbit before that
/// correction.
const MAX_LAST_CORRECTION: f64 = 1e-4;

/// Accuracy of a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    /// For a point of a branch.
    Branch,
    /// For the location of a bifurcation: the last correction is below the Newton tolerance, or, if that is not
    /// reached, no larger than the errors of the integration, at which corrections do not decrease any more.
    Location,
}

/// A converged orbit.
#[derive(Clone, Debug)]
pub(super) struct Corrected {
    pub shot: ShootingPoint,
    /// Derivatives of the segment maps before the last correction.
    pub maps: Vec<DMatrix<f64>>,
    /// The tangent of the branch, of norm 1.
    pub tangent: Direction,
    /// Sizes of the Newton corrections.
    pub corrections: Vec<f64>,
}

/// The state of an iteration.
struct Iterate {
    shot: ShootingPoint,
    sys: Box<dyn System>,
    ends: SegmentEnds,
    /// Largest scaled residual of a segment.
    residual: f64,
}

impl Flow<'_> {
    /// Corrects a guess of an orbit: orthogonally to a tangent of the branch, or at a fixed parameter without one.
    ///
    /// # Errors
    /// [`ContinuationError::NotConverged`], and errors of the family and the integration.
    pub fn correct(
        &mut self,
        guess: &ShootingPoint,
        scale: &Scale,
        along: Option<&Direction>,
        precision: Precision,
    ) -> Result<Corrected, ContinuationError> {
        let mut now = self.iterate(guess.clone(), scale)?;
        let phase = phase_row(guess, &now.ends, scale);
        let mut slopes = Vec::new();
        let mut corrections = Vec::new();
        for iteration in 0..MAX_ITERATIONS {
            if iteration % RENEWAL == 0 {
                slopes = self.parameter_slopes(now.sys.as_ref(), &now.shot, &now.ends)?;
            }
            let Some([correction, tangent]) = now.corrections(guess, scale, along, &phase, &slopes)
            else {
                break;
            };
            self.newton_iterations += 1;
            corrections.push(scale.norm(&correction));
            if self.has_converged(&corrections, precision) {
                return Ok(Corrected {
                    shot: self.settled(now.shot.moved(1.0, &correction), &now),
                    tangent: &tangent / scale.norm(&tangent),
                    maps: now.ends.maps,
                    corrections,
                });
            }
            now = self.advance(now, &correction, scale)?;
        }
        let last = corrections.last().copied().unwrap_or(f64::INFINITY);
        Err(now.shot.not_converged(last, corrections.len()))
    }

    /// Integrates the segments of a set of unknowns.
    fn iterate(
        &mut self,
        mut shot: ShootingPoint,
        scale: &Scale,
    ) -> Result<Iterate, ContinuationError> {
        shot.period = self.period(&shot);
        let sys = self.system(shot.parameter)?;
        let ends = self.segments(sys.as_ref(), &shot, true)?;
        let residual = residual(&shot, &ends, scale);
        shot.statuses.clone_from(&ends.statuses);
        shot.statuses.rotate_right(1);
        Ok(Iterate {
            shot,
            sys,
            ends,
            residual,
        })
    }

    /// Applies a correction, damped if the residual would grow or the integration fails.
    fn advance(
        &mut self,
        now: Iterate,
        correction: &Direction,
        scale: &Scale,
    ) -> Result<Iterate, ContinuationError> {
        let mut damping = 1.0;
        loop {
            let shot = self.settled(now.shot.moved(damping, correction), &now);
            let next = if shot.period > 0.0 {
                self.iterate(shot, scale)
            } else {
                Err(shot.not_converged(scale.norm(correction), 0))
            };
            damping *= 0.5;
            match next {
                Ok(next)
                    if next.residual <= MAX_GROWTH * now.residual
                        || next.residual < self.newton_tolerance()
                        || damping < MIN_DAMPING =>
                {
                    return Ok(next);
                }
                Err(error) if damping < MIN_DAMPING => return Err(error),
                _ => {}
            }
        }
    }

    /// Whether the orbit after the last correction is accurate enough.
    fn has_converged(&self, corrections: &[f64], precision: Precision) -> bool {
        let tolerance = self.newton_tolerance();
        // The next correction: the last two show the rate of convergence; after one, it is assumed to be quadratic.
        let (previous, last, next) = match *corrections {
            [.., previous, last] => (previous, last, last * (last / previous).min(1.0)),
            [last] => (f64::INFINITY, last, 10.0 * last * last),
            [] => return false,
        };
        // Corrections that do not decrease any more show the error of the integration.
        let noise = 1e3 * self.tolerance();
        let is_noise = last <= noise && last > 0.3 * previous;
        let is_small = precision == Precision::Branch && last <= MAX_LAST_CORRECTION;
        last <= tolerance || is_noise || is_small && next <= tolerance
    }

    /// Moves the starts of segments onto the constraints of their statuses, such as the velocity of a sticking mass.
    fn settled(&self, mut shot: ShootingPoint, from: &Iterate) -> ShootingPoint {
        shot.period = self.period(&shot);
        let Some(switching) = from.sys.switching() else {
            return shot;
        };
        for (k, state) in shot.states.iter_mut().enumerate() {
            let status = &shot.statuses[k];
            if !status.is_empty() {
                let time = shot.phases[k] * shot.period;
                switching.settle(status, time, state.as_mut_slice(), (&mut [], 0));
            }
        }
        shot
    }
}

/// The distance of the end of each segment from the start of the next one.
fn residuals(shot: &ShootingPoint, ends: &SegmentEnds) -> impl Iterator<Item = DVector<f64>> {
    let next = shot.states.iter().cycle().skip(1);
    ends.ends.iter().zip(next).map(|(end, next)| end - next)
}

/// The largest of these distances, scaled.
pub(super) fn residual(shot: &ShootingPoint, ends: &SegmentEnds, scale: &Scale) -> f64 {
    residuals(shot, ends).fold(0.0, |max, distance| {
        max.max(scale.scaled_state(&distance).norm())
    })
}

impl Iterate {
    /// The Newton correction, and the direction of the branch, not normalised. `guess` is that from which the phase is
    /// measured; `slopes` are the derivatives of the segment ends with respect to the parameter.
    fn corrections(
        &self,
        guess: &ShootingPoint,
        scale: &Scale,
        tangent: Option<&Direction>,
        phase: &Direction,
        slopes: &[DVector<f64>],
    ) -> Option<[Direction; 2]> {
        let shot = &self.shot;
        let units = scale.units(shot.len());
        let [period, parameter] = [2, 1].map(|from_end| units.len() - from_end);
        let column = direction(slopes, 0.0, 0.0).component_mul(&units) / units[parameter];
        let mut entries = equations(shot, &self.ends, scale, phase, false);
        let places = (0..period).map(|row| Entry::new(row, parameter, column[row]));
        entries.extend(places);
        let mut right = DMatrix::zeros(units.len(), 2);
        let residuals: Vec<_> = residuals(shot, &self.ends).collect();
        let distances = scale.scaled(&direction(&residuals, 0.0, 0.0));
        right.set_column(0, &-distances);
        if shot.drive_periods.is_none() {
            right[(period, 0)] = -phase.dot(&scale.scaled(&shot.minus(guess)));
        }
        match tangent {
            None => entries.push(Entry::new(parameter, parameter, 1.0)),
            Some(tangent) => {
                let tangent = scale.scaled(tangent);
                right[(parameter, 0)] = -tangent.dot(&scale.scaled(&shot.minus(guess)));
                let places = (0..=parameter).map(|j| Entry::new(parameter, j, tangent[j]));
                entries.extend(places);
            }
        }
        right[(parameter, 1)] = 1.0;
        let solution = solve(&entries, &right)?;
        Some([0, 1].map(|column| solution.column(column).component_div(&units)))
    }
}
