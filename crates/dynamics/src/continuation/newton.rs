//! Newton's method for multiple shooting.

use nalgebra::{DMatrix, DVector};

use super::ContinuationError;
use super::cyclic::{Segment, Solution, solve};
use super::flow::{Flow, SegmentEnds};
use super::shooting::{Direction, Scale, ShootingPoint};
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

/// The last equation of multiple shooting.
#[derive(Clone, Copy)]
pub(super) enum Constraint<'a> {
    /// The parameter is fixed.
    Parameter,
    /// The difference from `target` is orthogonal to `tangent`.
    Arclength {
        tangent: &'a Direction,
        target: &'a ShootingPoint,
    },
}

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
    /// First and last Newton correction.
    pub corrections: [f64; 2],
    pub iterations: u32,
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
    /// Corrects a guess of an orbit.
    ///
    /// # Errors
    /// [`ContinuationError::NotConverged`], and errors of the family and the integration.
    pub fn correct(
        &mut self,
        guess: &ShootingPoint,
        scale: &Scale,
        constraint: Constraint<'_>,
        precision: Precision,
    ) -> Result<Corrected, ContinuationError> {
        let mut now = self.iterate(guess.clone(), scale)?;
        let phase = phase_rows(&now.ends, scale);
        let mut slopes = Vec::new();
        let mut corrections: [f64; 2] = [f64::INFINITY; 2];
        let mut first = None;
        for iteration in 1..=MAX_ITERATIONS {
            if (iteration - 1) % RENEWAL == 0 {
                slopes = self.parameter_slopes(now.sys.as_ref(), &now.shot, &now.ends)?;
            }
            let equations = Equations {
                scale,
                constraint,
                guess,
                phase: &phase,
                slopes: &slopes,
            };
            let failed = ContinuationError::NotConverged {
                parameter: now.shot.parameter,
                correction: corrections[1],
                iterations: iteration,
            };
            let Some((correction, tangent)) = equations.solve(&now) else {
                return Err(failed);
            };
            self.stats.newton_iterations += 1;
            let size = scale.norm(&correction);
            corrections = [corrections[1], size];
            let first = *first.get_or_insert(size);
            if self.has_converged(corrections, precision) {
                let shot = self.settled(now.shot.moved(1.0, &correction), &now);
                let norm = scale.norm(&tangent);
                return Ok(Corrected {
                    shot,
                    maps: now.ends.maps,
                    tangent: tangent.scaled(1.0 / norm),
                    corrections: [first, size],
                    iterations: iteration,
                });
            }
            now = self.advance(now, &correction, scale)?;
        }
        Err(ContinuationError::NotConverged {
            parameter: now.shot.parameter,
            correction: corrections[1],
            iterations: MAX_ITERATIONS,
        })
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
        let residuals = residuals(&shot, &ends);
        let residual = residuals
            .iter()
            .fold(0.0, |max: f64, r| max.max(scale.norm_state(r)));
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
                Err(ContinuationError::NotConverged {
                    parameter: shot.parameter,
                    correction: scale.norm(correction),
                    iterations: 0,
                })
            };
            damping *= 0.5;
            match next {
                Ok(next)
                    if next.residual <= MAX_GROWTH * now.residual
                        || next.residual < self.options.newton_tolerance
                        || damping < MIN_DAMPING =>
                {
                    return Ok(next);
                }
                Err(error) if damping < MIN_DAMPING => return Err(error),
                _ => {}
            }
        }
    }

    /// Whether the orbit after the last of two successive corrections is accurate enough.
    fn has_converged(&self, [previous, last]: [f64; 2], precision: Precision) -> bool {
        let tolerance = self.options.newton_tolerance;
        // The next correction: the last two show the rate of convergence; after one, it is assumed to be quadratic.
        let next = if previous.is_finite() {
            last * (last / previous).min(1.0)
        } else {
            10.0 * last * last
        };
        // Corrections that do not decrease any more show the error of the integration.
        let noise = 1e3 * self.tolerance();
        let is_noise = last <= noise && last > 0.3 * previous;
        let allowed = match precision {
            Precision::Branch => MAX_LAST_CORRECTION,
            Precision::Location => tolerance,
        };
        last <= tolerance || is_noise || last <= allowed && next <= tolerance
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
pub(super) fn residuals(shot: &ShootingPoint, ends: &SegmentEnds) -> Vec<DVector<f64>> {
    let next = (1..=shot.len()).map(|k| &shot.states[k % shot.len()]);
    ends.ends
        .iter()
        .zip(next)
        .map(|(end, next)| end - next)
        .collect()
}

/// The rows of the integral phase condition in scaled coordinates: the flow at the starts of the segments, together of
/// norm 1. An orbit at rest has no phase; its rows are zero.
fn phase_rows(ends: &SegmentEnds, scale: &Scale) -> Vec<DVector<f64>> {
    let count = ends.slopes.len();
    let mut rows: Vec<_> = (0..count)
        .map(|k| scale.scaled_state(&ends.slopes[(k + count - 1) % count]))
        .collect();
    let norm = rows.iter().map(DVector::norm_squared).sum::<f64>().sqrt();
    if norm > 0.0 {
        rows.iter_mut().for_each(|row| *row /= norm);
    }
    rows
}

/// The equations of one Newton iteration.
struct Equations<'a> {
    scale: &'a Scale,
    constraint: Constraint<'a>,
    /// The guess, from which the phase is measured.
    guess: &'a ShootingPoint,
    phase: &'a [DVector<f64>],
    /// Derivatives of the segment ends with respect to the parameter.
    slopes: &'a [DVector<f64>],
}

impl Equations<'_> {
    /// The Newton correction, and the direction of the branch, not normalised.
    fn solve(&self, now: &Iterate) -> Option<(Direction, Direction)> {
        let scale = self.scale;
        let shot = &now.shot;
        let free = shot.drive_periods.is_none();
        // Scalar unknowns: the period of an autonomous system, and the parameter.
        let b = 1 + usize::from(free);
        let last = b - 1;
        let n = shot.states[0].len();
        let residuals = residuals(shot, &now.ends);
        let mut corner = DMatrix::zeros(b, b);
        let mut right = DMatrix::zeros(b, 2);
        right[(last, 1)] = 1.0;
        let segments: Vec<_> = (0..shot.len())
            .map(|k| {
                let mut columns = DMatrix::zeros(n, b);
                let mut border = DMatrix::zeros(b, n);
                if free {
                    let [from, to] = shot.span(k);
                    let slope = &now.ends.slopes[k] * ((to - from) * scale.period);
                    columns.set_column(0, &scale.scaled_state(&slope));
                    border.set_row(0, &self.phase[k].transpose());
                    let moved = scale.scaled_state(&(&shot.states[k] - &self.guess.states[k]));
                    right[(0, 0)] -= self.phase[k].dot(&moved);
                }
                let slope = &self.slopes[k] * scale.parameter;
                columns.set_column(last, &scale.scaled_state(&slope));
                if let Constraint::Arclength { tangent, .. } = self.constraint {
                    let row = scale.scaled_state(&tangent.states[k]) / shot.len() as f64;
                    border.set_row(last, &row.transpose());
                }
                let mut right = DMatrix::zeros(n, 2);
                right.set_column(0, &-scale.scaled_state(&residuals[k]));
                Segment {
                    map: scale.scaled_map(&now.ends.maps[k]),
                    columns,
                    right,
                    border,
                }
            })
            .collect();
        match self.constraint {
            Constraint::Parameter => corner[(last, last)] = 1.0,
            Constraint::Arclength { tangent, target } => {
                corner[(last, last)] = tangent.parameter / scale.parameter;
                if free {
                    corner[(last, 0)] = tangent.period / scale.period;
                }
                right[(last, 0)] = -scale.dot(tangent, &shot.minus(target));
            }
        }
        let solution = solve(&segments, corner, right)?;
        Some((
            self.direction(&solution, 0, free),
            self.direction(&solution, 1, free),
        ))
    }

    /// One column of the solution without scales.
    fn direction(&self, solution: &Solution, column: usize, free: bool) -> Direction {
        let last = solution.scalars.nrows() - 1;
        let states = solution.states.iter();
        Direction {
            parameter: solution.scalars[(last, column)] * self.scale.parameter,
            period: if free {
                solution.scalars[(0, column)] * self.scale.period
            } else {
                0.0
            },
            states: states
                .map(|state| {
                    self.scale
                        .unscaled_state(&state.column(column).into_owned())
                })
                .collect(),
        }
    }
}
