//! Curves in the plane of two parameters on which a pair of complex eigenvalues is imaginary.
//!
//! A curve is the zero of the growth rate `g(a, b)` of a mode that is followed by its shape ([`super::curve`]). With one
//! parameter set, the secant method solves for the other one.

use std::convert::Infallible;

use schemars::JsonSchema;
use serde::Serialize;

use super::curve::{Curve, CurvePoint};
use super::map::MapPlan;
use super::steady::SteadyFamily;
use super::tracking::most_alike;
use crate::dynamics::equilibrium::Eigenmode;

/// First, smallest and largest step along a curve, relative to the intervals.
const STEPS: [f64; 3] = [0.01, 1e-4, 0.03];
/// First step of the secant method, relative to the interval.
const DIFFERENCE: f64 = 1e-5;
/// Steps of the secant method.
const MAX_ITERATIONS: usize = 12;
/// Largest correction, as a fraction of the interval, of a converged point.
const CONVERGED: f64 = 1e-11;
/// Relative difference of the frequencies of one curve at neighbouring points.
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

impl HopfCurve {
    /// The result of a curve of a mode.
    pub(super) fn new((label, curve): (&str, Curve<HopfPoint>)) -> Self {
        let points = curve.points.iter().map(|point| HopfCurvePoint {
            values: point.values,
            frequency_hz: point.mode.frequency_hz(),
        });
        Self {
            label: label.to_owned(),
            points: points.collect(),
            closed: curve.closed,
            ended: curve.ended,
        }
    }
}

/// A point of a curve, or a first approximation of one, with the mode there.
#[derive(Clone)]
pub(super) struct HopfPoint {
    pub values: [f64; 2],
    pub mode: Eigenmode,
}

impl CurvePoint for HopfPoint {
    fn values(&self) -> [f64; 2] {
        self.values
    }

    fn is_alike(&self, other: &Self) -> bool {
        (self.mode.frequency_hz() / other.mode.frequency_hz() - 1.0).abs() < SAME_FREQUENCY
    }
}

/// The curve through a point near a first approximation, which lies on an edge of the grid along a parameter (`along`).
/// `None` if there is no point.
pub(super) fn hopf_curve(
    plan: &MapPlan,
    family: &mut SteadyFamily,
    seed: &HopfPoint,
    along: usize,
) -> Option<Curve<HopfPoint>> {
    let start = solved(plan, family, seed, along, seed.values)?;
    // The tangent is normal to the gradient of the growth rate.
    let mut slope = |axis: usize| {
        let values = moved(plan, start.values, axis);
        let [from, to] = plan.intervals[axis];
        let growth = mode_at(family, values, &start.mode)?.value.re - start.mode.value.re;
        Some(growth * (to - from) / (values[axis] - start.values[axis]))
    };
    let (a, b) = (slope(0)?, slope(1)?);
    let tangent = [-b / a.hypot(b), a / a.hypot(b)];
    let mut solve = |near: &HopfPoint, axis: usize, expected: [f64; 2]| {
        Ok::<_, Infallible>(solved(plan, family, near, 1 - axis, expected))
    };
    plan.follow(&start, tangent, STEPS, &mut solve).ok()
}

/// The mode next to another one at some values of the parameters.
fn mode_at(family: &mut SteadyFamily, values: [f64; 2], near: &Eigenmode) -> Option<Eigenmode> {
    most_alike(family.at(&values).ok()?.modes().ok()?, near)
}

/// Values that differ by [`DIFFERENCE`] in one parameter, towards the middle of its interval.
fn moved(plan: &MapPlan, mut values: [f64; 2], axis: usize) -> [f64; 2] {
    let [from, to] = plan.intervals[axis];
    values[axis] += DIFFERENCE
        * if 2.0 * values[axis] < from + to {
            to - from
        } else {
            from - to
        };
    values
}

/// The point of a curve next to another one by the secant method over one parameter (`along`), from a guess.
fn solved(
    plan: &MapPlan,
    family: &mut SteadyFamily,
    near: &HopfPoint,
    along: usize,
    guess: [f64; 2],
) -> Option<HopfPoint> {
    let [from, to] = plan.intervals[along];
    let mut values = moved(plan, guess, along);
    let mut mode = mode_at(family, guess, &near.mode)?;
    let mut change = values[along] - guess[along];
    for _ in 0..MAX_ITERATIONS {
        let before = mode.value.re;
        mode = mode_at(family, values, &mode)?;
        if change.abs() < CONVERGED * (to - from) || mode.value.re == 0.0 {
            return Some(HopfPoint { values, mode });
        }
        change *= mode.value.re / (before - mode.value.re);
        values[along] += change;
        if !values[along].is_finite() {
            return None;
        }
    }
    None
}
