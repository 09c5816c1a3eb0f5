//! Curves in the plane of two parameters on which a pair of complex eigenvalues is imaginary, by pseudo-arclength
//! continuation.
//!
//! The curve is the zero of the growth rate `g(a, b)` of a mode that is followed by its shape. In coordinates scaled by
//! the intervals, the tangent is normal to the gradient of `g`, which follows from the left and right eigenvectors. A
//! step goes along the tangent and returns to the curve by Newton's method along the gradient; its length adapts to the
//! number of iterations and to the angle between successive tangents.

use schemars::JsonSchema;
use serde::Serialize;

use super::BranchError;
use super::steady::{SteadyFamily, SteadyState};
use super::tracking::most_alike;
use crate::chain_of_causes;
use crate::dynamics::equilibrium::{Eigenmode, eigenvalue_derivative};

/// First, smallest and largest step along the curve, as a fraction of the intervals.
const STEPS: [f64; 3] = [0.01, 1e-5, 0.03];
/// Step of the differences that give the gradient.
const DIFFERENCE: f64 = 1e-5;
/// Newton iterations.
const MAX_ITERATIONS: usize = 6;
/// Largest correction, as a fraction of the intervals, of a converged point.
const CONVERGED: f64 = 1e-11;
/// Smallest cosine of the angle between successive tangents.
const MIN_COSINE: f64 = 0.95;
/// Points of a curve.
const MAX_POINTS: usize = 2000;
/// Relative difference of the frequencies of one curve next to a grid point.
const SAME_FREQUENCY: f64 = 0.02;

/// A point of a Hopf curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct HopfCurvePoint {
    /// Values of both parameters, in the units of the scene file.
    pub values: [f64; 2],
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

/// A curve on which a pair of complex eigenvalues is imaginary.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct HopfCurve {
    /// Dominant mode of the body where the curve was found.
    pub label: String,
    /// The points in order along the curve.
    pub points: Vec<HopfCurvePoint>,
    /// Whether the curve is closed: its last point joins the first.
    pub closed: bool,
    /// Reasons why the curve ends inside the intervals, if it does.
    pub ended: Vec<String>,
}

/// A first approximation of a point of a curve.
pub(super) struct Seed {
    pub values: [f64; 2],
    /// The mode at a point nearby.
    pub mode: Eigenmode,
    pub label: String,
}

/// A converged point in scaled coordinates.
#[derive(Clone)]
struct Converged {
    at: [f64; 2],
    mode: Eigenmode,
    gradient: [f64; 2],
    iterations: usize,
}

/// Traces the curves of a family over two parameters.
pub(super) struct CurveTracer {
    family: SteadyFamily,
    intervals: [[f64; 2]; 2],
}

/// How one direction of a curve ends.
enum End {
    Border,
    Closed,
    Inside(String),
}

impl CurveTracer {
    pub fn new(family: SteadyFamily, intervals: [[f64; 2]; 2]) -> Self {
        Self { family, intervals }
    }

    /// Whether a curve passes a seed within `cell` of the scaled coordinates at its frequency.
    pub fn covers(&self, curve: &HopfCurve, seed: &Seed, cell: f64) -> bool {
        let at = self.scaled(seed.values);
        curve.points.iter().any(|point| {
            let apart = (point.frequency_hz / seed.mode.frequency_hz() - 1.0).abs();
            apart < SAME_FREQUENCY && distance(self.scaled(point.values), at) < cell
        })
    }

    /// Traces the curve through a seed in both directions. `None` if Newton's method does not converge from it.
    pub fn trace(&mut self, seed: &Seed) -> Result<Option<HopfCurve>, BranchError> {
        let at = self.scaled(seed.values);
        let Ok(start) = self.corrected(at, &seed.mode, None) else {
            return Ok(None);
        };
        let (mut points, end) = self.direction(&start, 1.0);
        let mut ended = Vec::new();
        let closed = matches!(end, End::Closed);
        ended.extend(reason(end));
        if !closed {
            let (backward, end) = self.direction(&start, -1.0);
            ended.extend(reason(end));
            points.reverse();
            points.pop();
            points = points.into_iter().chain(backward).collect();
        }
        let points = points.iter().map(|point| HopfCurvePoint {
            values: self.values(point.at),
            frequency_hz: point.mode.frequency_hz(),
        });
        Ok(Some(HopfCurve {
            label: seed.label.clone(),
            points: points.collect(),
            closed,
            ended,
        }))
    }

    /// The points from the start on in one direction, the start first.
    fn direction(&mut self, start: &Converged, sign: f64) -> (Vec<Converged>, End) {
        let [mut step, min, max] = STEPS;
        let mut points = vec![start.clone()];
        let mut tangent = tangent(start.gradient).map(|t| sign * t);
        while points.len() < MAX_POINTS {
            let last = points[points.len() - 1].clone();
            let guess = along(last.at, tangent, step);
            let next = match self.corrected(guess, &last.mode, None) {
                Ok(next) if self::turned(&next, tangent).is_some() => next,
                result => {
                    step *= 0.5;
                    if step >= min {
                        continue;
                    }
                    let why = result
                        .err()
                        .unwrap_or_else(|| "it turns too sharply".to_owned());
                    // Beyond the border the parameter may have no valid values.
                    let end = if near_border(last.at) {
                        End::Border
                    } else {
                        End::Inside(why)
                    };
                    return (points, end);
                }
            };
            if !is_inside(next.at) {
                points.extend(self.on_border(&last, &next));
                return (points, End::Border);
            }
            if points.len() > 3 && distance(next.at, start.at) < 0.7 * step {
                points.push(start.clone());
                return (points, End::Closed);
            }
            tangent = turned(&next, tangent).unwrap_or(tangent);
            if next.iterations <= 3 {
                step = (1.5 * step).min(max);
            }
            points.push(next);
        }
        (points, End::Inside(format!("{MAX_POINTS} points")))
    }

    /// The point at which the curve leaves the intervals between two of its points.
    fn on_border(&mut self, inside: &Converged, outside: &Converged) -> Option<Converged> {
        // The first border on the way.
        let share = |k: usize| {
            let (from, to) = (inside.at[k], outside.at[k]);
            let border = to.clamp(0.0, 1.0);
            if border == to {
                1.0
            } else {
                (border - from) / (to - from)
            }
        };
        let axis = usize::from(share(1) < share(0));
        let mut at = along(
            inside.at,
            [0, 1].map(|k| outside.at[k] - inside.at[k]),
            share(axis),
        );
        at[axis] = outside.at[axis].clamp(0.0, 1.0);
        self.corrected(at, &inside.mode, Some(axis)).ok()
    }

    /// Newton's method along the gradient, or along the other axis than `fixed`, with the error as text.
    fn corrected(
        &mut self,
        guess: [f64; 2],
        mode: &Eigenmode,
        fixed: Option<usize>,
    ) -> Result<Converged, String> {
        let mut at = guess;
        for iterations in 1..=MAX_ITERATIONS {
            let (state, mode) = self.solve(at, mode)?;
            let mut gradient = self.gradient(at, &state, &mode)?;
            let full = gradient;
            if let Some(axis) = fixed {
                gradient[axis] = 0.0;
            }
            let square = gradient[0].powi(2) + gradient[1].powi(2);
            let change = gradient.map(|g| -mode.value.re * g / square);
            if change.iter().any(|c| !c.is_finite()) {
                return Err("the growth rate does not change with the parameters".to_owned());
            }
            at = [at[0] + change[0], at[1] + change[1]];
            if distance(change, [0.0; 2]) < CONVERGED {
                return Ok(Converged {
                    at,
                    mode,
                    gradient: full,
                    iterations,
                });
            }
        }
        Err("Newton's method did not converge".to_owned())
    }

    /// The state at a point, and the mode that is followed.
    fn solve(
        &mut self,
        at: [f64; 2],
        mode: &Eigenmode,
    ) -> Result<(SteadyState, Eigenmode), String> {
        let solved = self.family.at(&self.values(at));
        let state = solved.map_err(|error| chain_of_causes(&error))?;
        let modes = state.modes().map_err(|error| error.to_string())?;
        let mode = most_alike(modes, mode);
        let mode = mode.ok_or("the mode no longer oscillates")?;
        Ok((state, mode))
    }

    /// Gradient of the growth rate in scaled coordinates.
    fn gradient(
        &mut self,
        at: [f64; 2],
        state: &SteadyState,
        mode: &Eigenmode,
    ) -> Result<[f64; 2], String> {
        let left = state.linearised.left(mode);
        let mut gradient = [0.0; 2];
        for (axis, gradient) in gradient.iter_mut().enumerate() {
            let mut matrix = |step: f64| {
                let mut moved = at;
                moved[axis] += step;
                let solved = self.family.at(&self.values(moved));
                solved.map(|state| state.linearised.matrix)
            };
            // A value beyond the range of the parameter has no matrix.
            let (up, down, width) = match (matrix(DIFFERENCE), matrix(-DIFFERENCE)) {
                (Ok(up), Ok(down)) => (up, down, 2.0 * DIFFERENCE),
                (Ok(up), Err(_)) => (up, state.linearised.matrix.clone(), DIFFERENCE),
                (Err(_), Ok(down)) => (state.linearised.matrix.clone(), down, DIFFERENCE),
                (Err(error), Err(_)) => return Err(chain_of_causes(&error)),
            };
            let slope = faer::Mat::from_fn(up.nrows(), up.ncols(), |i, j| {
                (up[(i, j)] - down[(i, j)]) / width
            });
            *gradient = eigenvalue_derivative(&left, &slope, &mode.vector).re;
        }
        Ok(gradient)
    }

    fn scaled(&self, values: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| {
            let [from, to] = self.intervals[k];
            (values[k] - from) / (to - from)
        })
    }

    fn values(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| {
            let [from, to] = self.intervals[k];
            from + at[k] * (to - from)
        })
    }
}

/// The tangent at a point in the direction of the last one; `None` if it turned by more than the largest angle.
fn turned(point: &Converged, last: [f64; 2]) -> Option<[f64; 2]> {
    let new = tangent(point.gradient);
    let cosine = new[0] * last[0] + new[1] * last[1];
    (cosine.abs() >= MIN_COSINE).then(|| new.map(|t| cosine.signum() * t))
}

/// Unit vector normal to a gradient.
fn tangent([x, y]: [f64; 2]) -> [f64; 2] {
    let size = x.hypot(y);
    [-y / size, x / size]
}

fn along(from: [f64; 2], direction: [f64; 2], by: f64) -> [f64; 2] {
    [from[0] + by * direction[0], from[1] + by * direction[1]]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Whether a point is so close to the border that no step to it is long enough.
fn near_border(at: [f64; 2]) -> bool {
    let margin = 10.0 * STEPS[1];
    at.iter().any(|x| *x < margin || *x > 1.0 - margin)
}

fn is_inside(at: [f64; 2]) -> bool {
    at.iter().all(|x| (0.0..=1.0).contains(x))
}

/// Reason for an end inside the intervals.
fn reason(end: End) -> Option<String> {
    match end {
        End::Inside(why) => Some(why),
        End::Border | End::Closed => None,
    }
}
