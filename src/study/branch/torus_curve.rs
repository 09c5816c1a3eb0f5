//! Curves of Neimark-Sacker points over two parameters.
//!
//! A curve starts at each Neimark-Sacker point of the branch of periodic orbits over the first parameter, at the value of the
//! scene for the second one, and is followed in both directions ([`super::curve`]). With one
//! parameter set, a short piece of the branch over the other one is followed around the expected value, and the Neimark-Sacker
//! point in it located.

use schemars::JsonSchema;
use serde::Serialize;

use super::curve::{Curve, CurvePoint, ON_CURVE};
use super::equilibria::BranchPlan;
use super::map::MapPlan;
use super::orbits::{OrbitStarts, add_orbits};
use super::result::Branch;
use super::scene_family::SubjectFamily;
use crate::dynamics::continuation::{
    Bifurcation, BifurcationKind, BranchStart, ContinuationOptions, PeriodicOrbit, StepLimits,
    continue_orbits,
};
use crate::study::{Stopped, StudyError};

/// Half the length of the piece of the branch around the expected point, relative to the interval of its parameter.
const REACH: f64 = 0.05;
/// Steps along this piece, relative to its length.
const STEPS: StepLimits = StepLimits {
    initial: 0.2,
    min: 1e-3,
    max: 0.5,
};
/// First, smallest and largest step along a curve, relative to the intervals.
const CURVE_STEPS: [f64; 3] = [0.025, 5e-4, 0.1];
/// Largest change of the rotation number in a step.
const SAME: f64 = 0.05;

/// A curve of Neimark-Sacker points: on one side the periodic motion attracts, on the other a torus has taken its place.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TorusCurve {
    /// The points, in their order along the curve.
    pub points: Vec<TorusCurvePoint>,
    /// Whether the curve is closed: the last point is the first one.
    pub closed: bool,
    /// Why the curve ends inside the intervals, one sentence each.
    pub ended: Vec<String>,
}

/// A point of a curve at which a torus is born.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TorusCurvePoint {
    /// Values of the parameters, in the units of the scene file.
    pub values: [f64; 2],
    /// Frequency of the periodic motion, Hz.
    pub frequency_hz: f64,
    /// Second base frequency of the torus, Hz.
    pub second_hz: f64,
}

/// A located point with its orbit.
#[derive(Clone)]
struct Located {
    at: TorusCurvePoint,
    orbit: PeriodicOrbit,
}

impl Located {
    fn new(found: &Bifurcation, values: [f64; 2]) -> Self {
        Self {
            at: TorusCurvePoint {
                values,
                frequency_hz: found.frequency_hz,
                second_hz: found.torus_frequency_hz.unwrap_or(f64::NAN),
            },
            orbit: found.orbit.clone(),
        }
    }

    /// The difference of the rotation numbers.
    fn change(&self, other: &Self) -> f64 {
        let [a, b] = [self, other].map(|point| point.at.second_hz / point.at.frequency_hz);
        (a - b).abs()
    }
}

impl CurvePoint for Located {
    fn values(&self) -> [f64; 2] {
        self.at.values
    }

    fn is_alike(&self, other: &Self) -> bool {
        self.change(other) < SAME
    }
}

/// The curves of Neimark-Sacker points of a map. `check` is called before each piece.
///
/// # Errors
/// [`StudyError::Stopped`]; if a value of a parameter is invalid, or a system cannot be built.
pub(super) fn torus_curves(
    plan: &MapPlan,
    check: &mut dyn FnMut() -> Result<(), Stopped>,
) -> Result<Vec<TorusCurve>, StudyError> {
    let [from, to] = plan.intervals[1];
    let own = plan.scene.value_of(plan.parameters[1]);
    let own = own.filter(|value| (from..=to).contains(value));
    let start = own.unwrap_or(0.5 * (from + to));
    let first = branch_over(plan, 0, start)?;
    let mut branch = Branch::new(&first);
    add_orbits(&first, OrbitStarts::Scene, &mut branch, &mut |_, _, _| {
        check()
    })?;
    let points = branch.orbit_bifurcations();
    let points = points.filter(|found| found.bifurcation.kind == BifurcationKind::NeimarkSacker);
    let mut curves: Vec<Curve<Located>> = Vec::new();
    for found in points {
        let found = Located::new(&found.bifurcation, [found.at.value, start]);
        let is_known = |curve: &Curve<_>| plan.passes(&curve.points, &found, ON_CURVE);
        if !curves.iter().any(is_known) {
            let mut solve = |near: &Located, axis: usize, expected: [f64; 2]| {
                check()?;
                point(plan, near, axis, expected)
            };
            curves.push(plan.follow(&found, [0.0, 1.0], CURVE_STEPS, &mut solve)?);
        }
    }
    check()?;
    let curves = curves.into_iter().map(|curve| TorusCurve {
        points: curve.points.iter().map(|point| point.at).collect(),
        closed: curve.closed,
        ended: curve.ended,
    });
    Ok(curves.collect())
}

/// The plan of the branch over one of the parameters at a value of the other one.
fn branch_over(plan: &MapPlan, axis: usize, other: f64) -> Result<BranchPlan, StudyError> {
    let (parameter, interval) = (plan.parameters[axis], plan.intervals[axis]);
    let scene = plan
        .scene
        .with_values(&[(plan.parameters[1 - axis], other)])?;
    Ok(BranchPlan::new(scene, parameter, interval, 2))
}

/// The Neimark-Sacker point next to another one, with the expected value of one parameter (`axis`) and near that of
/// the other one.
fn point(
    plan: &MapPlan,
    near: &Located,
    axis: usize,
    expected: [f64; 2],
) -> Result<Option<Located>, StudyError> {
    let over = 1 - axis;
    let branch = branch_over(plan, over, expected[axis])?;
    let [low, high] = plan.intervals[over];
    let reach = REACH * (high - low);
    let middle = expected[over];
    let bounds = [(middle - reach).max(low), (middle + reach).min(high)];
    let options = ContinuationOptions {
        steps: STEPS,
        ..ContinuationOptions::new(bounds, plan.scene.integrator.max_step)
    };
    let start = BranchStart::from(PeriodicOrbit {
        parameter: middle,
        ..near.orbit.clone()
    });
    let family = SubjectFamily::new(&branch);
    let Ok(piece) = continue_orbits(&family, &start, &options, &mut |_| Ok(())) else {
        return Ok(None);
    };
    let found = piece.bifurcations.iter();
    let tori = found.filter(|found| found.kind == BifurcationKind::NeimarkSacker);
    let tori = tori.map(|found| {
        let mut values = expected;
        values[over] = found.parameter;
        Located::new(found, values)
    });
    let nearest = tori.min_by(|a, b| a.change(near).total_cmp(&b.change(near)));
    Ok(nearest.filter(|found| found.is_alike(near)))
}
