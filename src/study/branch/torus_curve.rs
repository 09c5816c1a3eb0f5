//! Curves of Neimark-Sacker points over two parameters.
//!
//! A curve starts at each Neimark-Sacker point of the branch of periodic orbits over the first parameter, at the value of the
//! scene for the second one. From there the second parameter changes in small steps. At each of its values, a short piece of the
//! branch is followed around the point that the last two extrapolate to, and the Neimark-Sacker point in it is located. Where
//! there is none, the step is halved; a curve that turns back in the second parameter ends there.

use serde::{Deserialize, Serialize};

use super::BranchError;
use super::equilibria::{BranchPlan, EquilibriumBranch};
use super::orbits::{OrbitStarts, add_orbits};
use super::result::Branch;
use super::scene_family::SceneFamily;
use crate::dynamics::continuation::{
    Bifurcation, BifurcationKind, BranchStart, ContinuationOptions, PeriodicOrbit, StepLimits,
    continue_orbits,
};
use crate::scene::{Parameter, Scene};

/// Half the length of the piece of the branch around the expected point, relative to the interval of the first parameter.
const REACH: f64 = 0.05;
/// Steps along this piece, relative to its length.
const STEPS: StepLimits = StepLimits {
    initial: 0.2,
    min: 1e-3,
    max: 0.5,
};
/// Steps of the second parameter over its interval.
const INTERVALS: f64 = 40.0;
/// Number of times that such a step is halved.
const HALVINGS: i32 = 4;
/// Largest change of the rotation number in a step.
const SAME: f64 = 0.05;

/// A curve of Neimark-Sacker points: on one side the periodic motion attracts, on the other a torus has taken its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorusCurve {
    /// The points, in ascending order of the second parameter.
    pub points: Vec<TorusCurvePoint>,
    /// Why the curve ends inside the intervals, one sentence each.
    pub ended: Vec<String>,
}

/// A point of a curve at which a torus is born.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorusCurvePoint {
    /// Values of the parameters, in the units of the scene file.
    pub values: [f64; 2],
    /// Frequency of the periodic motion, Hz.
    pub frequency_hz: f64,
    /// Second base frequency of the torus, Hz.
    pub second_hz: f64,
}

/// A scene over two parameters.
pub(super) struct Plane<'a> {
    pub scene: &'a Scene,
    /// The parameters of the branches and of the curves.
    pub parameters: [Parameter; 2],
    /// The ends of the interval of each parameter, ascending, in the units of the scene file.
    pub intervals: [[f64; 2]; 2],
}

/// A located point with its orbit.
#[derive(Clone)]
struct Located {
    at: TorusCurvePoint,
    orbit: PeriodicOrbit,
}

impl Located {
    fn of(found: &Bifurcation, second: f64) -> Self {
        Self {
            at: TorusCurvePoint {
                values: [found.parameter, second],
                frequency_hz: found.frequency_hz,
                second_hz: found.torus_frequency_hz.unwrap_or(f64::NAN),
            },
            orbit: found.orbit.clone(),
        }
    }

    fn rotation_number(&self) -> f64 {
        self.at.second_hz / self.at.frequency_hz
    }
}

/// The curves of Neimark-Sacker points of a map. `should_continue` is asked before each piece; `None` if it stops the study.
///
/// # Errors
/// If a value of a parameter is invalid, or a system cannot be built.
pub(super) fn torus_curves(
    plane: &Plane<'_>,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Option<Vec<TorusCurve>>, BranchError> {
    let [_, second] = plane.parameters;
    let [from, to] = plane.intervals[1];
    let own = plane.scene.value_of(second);
    let own = own.filter(|value| (from..=to).contains(value));
    let start = own.unwrap_or(0.5 * (from + to));
    let first = along(plane, start)?;
    let mut branch = Branch::new(&first, EquilibriumBranch::default());
    add_orbits(&first, OrbitStarts::Scene, &mut branch, &mut |_| {
        should_continue()
    })?;
    let points = branch.orbit_bifurcations();
    let points = points.filter(|found| found.bifurcation.kind == BifurcationKind::NeimarkSacker);
    let mut curves = Vec::new();
    for found in points {
        let found = Located::of(&found.bifurcation, start);
        let mut curve = TorusCurve {
            points: vec![found.at],
            ended: Vec::new(),
        };
        for way in [-1.0, 1.0] {
            let Some(traced) = trace(plane, &found, way, should_continue)? else {
                return Ok(None);
            };
            curve.points.extend(traced.points);
            curve.ended.extend(traced.ended);
        }
        let points = &mut curve.points;
        points.sort_by(|a, b| a.values[1].total_cmp(&b.values[1]));
        curves.push(curve);
    }
    Ok(should_continue().then_some(curves))
}

/// The plan of the branch over the first parameter at a value of the second one.
fn along(plane: &Plane<'_>, second: f64) -> Result<BranchPlan, BranchError> {
    Ok(BranchPlan {
        scene: plane.scene.with_values(&[(plane.parameters[1], second)])?,
        parameter: plane.parameters[0],
        interval: plane.intervals[0],
        points: 2,
    })
}

/// Follows a curve in one direction of the second parameter, without its first point.
fn trace(
    plane: &Plane<'_>,
    start: &Located,
    way: f64,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Option<TorusCurve>, BranchError> {
    let [from, to] = plane.intervals[1];
    let largest = (to - from) / INTERVALS;
    let mut curve = TorusCurve {
        points: Vec::new(),
        ended: Vec::new(),
    };
    let (mut before, mut now) = (None, start.clone());
    let mut step = largest;
    loop {
        let here = now.at.values;
        let next = (here[1] + way * step).clamp(from, to);
        if next == here[1] {
            return Ok(Some(curve));
        }
        if !should_continue() {
            return Ok(None);
        }
        let expected = before.map_or(here[0], |earlier: TorusCurvePoint| {
            let [p, q] = earlier.values;
            here[0] + (here[0] - p) * (next - here[1]) / (here[1] - q)
        });
        if !(plane.intervals[0][0]..=plane.intervals[0][1]).contains(&expected) {
            return Ok(Some(curve));
        }
        match point(plane, &now, expected, next)? {
            Some(found) => {
                curve.points.push(found.at);
                before = Some(now.at);
                now = found;
                step = (2.0 * step).min(largest);
            }
            None if step > largest * 0.5_f64.powi(HALVINGS) => step *= 0.5,
            None => {
                let [p, q] = here;
                curve.ended.push(format!(
                    "a curve ends at {} = {p:.6}, {} = {q:.6}: no Neimark-Sacker point was found beyond",
                    plane.parameters[0].name(),
                    plane.parameters[1].name(),
                ));
                return Ok(Some(curve));
            }
        }
    }
}

/// The Neimark-Sacker point at a value of the second parameter, near the expected value of the first one.
fn point(
    plane: &Plane<'_>,
    near: &Located,
    expected: f64,
    second: f64,
) -> Result<Option<Located>, BranchError> {
    let branch = along(plane, second)?;
    let [low, high] = plane.intervals[0];
    let reach = REACH * (high - low);
    let bounds = [(expected - reach).max(low), (expected + reach).min(high)];
    let options = ContinuationOptions {
        steps: STEPS,
        ..ContinuationOptions::new(bounds, plane.scene.integrator.max_step)
    };
    let family = SceneFamily::new(&branch);
    let start = BranchStart::from(PeriodicOrbit {
        parameter: expected,
        ..near.orbit.clone()
    });
    let Ok(piece) = continue_orbits(&family, &start, &options, &mut |_| true) else {
        return Ok(None);
    };
    let found = piece.bifurcations.iter();
    let tori = found.filter(|found| found.kind == BifurcationKind::NeimarkSacker);
    let tori = tori.map(|found| Located::of(found, second));
    let change = |found: &Located| (found.rotation_number() - near.rotation_number()).abs();
    let nearest = tori.min_by(|a, b| change(a).total_cmp(&change(b)));
    Ok(nearest.filter(|found| change(found) < SAME))
}
