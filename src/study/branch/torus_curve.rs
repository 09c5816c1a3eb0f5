//! Curves of Neimark-Sacker points over two parameters.
//!
//! A curve starts at each Neimark-Sacker point of the branch of periodic orbits over the first parameter, at the value of the
//! scene for the second one, and is followed in both directions. Each step extrapolates the last two points. The parameter
//! that changes more is set to its value there; over the other one, a short piece of the branch around the extrapolated value
//! is followed and the Neimark-Sacker point in it located. A curve thus passes points at which it turns back in a parameter,
//! and its last step ends on a border. Where there is no point, the step is halved.

use schemars::JsonSchema;
use serde::Serialize;

use super::BranchError;
use super::equilibria::{BranchPlan, EquilibriumBranch};
use super::orbits::{OrbitStarts, add_orbits};
use super::result::Branch;
use super::scene_family::SubjectFamily;
use crate::dynamics::continuation::{
    Bifurcation, BifurcationKind, BranchStart, ContinuationOptions, PeriodicOrbit, StepLimits,
    continue_orbits,
};
use crate::scene::{Parameter, Scene};
use crate::study::Stopped;

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
/// Changes of the direction of a curve, rad: below the first the next step is doubled, above the second halved.
const TURNS: [f64; 2] = [0.05, 0.15];
/// Largest change of the rotation number in a step.
const SAME: f64 = 0.05;
/// Distance of a point from the chord of a curve that passes it, relative to the intervals.
const ON_CURVE: f64 = 2e-3;
/// Largest number of points of a curve in one direction.
const MAX_POINTS: usize = 400;

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

impl TorusCurvePoint {
    fn rotation_number(&self) -> f64 {
        self.second_hz / self.frequency_hz
    }
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

/// How a curve was left in one direction.
enum End {
    Border,
    Closed,
    /// With the reason.
    Lost(String),
}

/// The curves of Neimark-Sacker points of a map. `check` is called before each piece.
///
/// # Errors
/// [`BranchError::Stopped`]; if a value of a parameter is invalid, or a system cannot be built.
pub(super) fn torus_curves(
    plane: &Plane<'_>,
    check: &mut dyn FnMut() -> Result<(), Stopped>,
) -> Result<Vec<TorusCurve>, BranchError> {
    let [_, second] = plane.parameters;
    let [from, to] = plane.intervals[1];
    let own = plane.scene.value_of(second);
    let own = own.filter(|value| (from..=to).contains(value));
    let start = own.unwrap_or(0.5 * (from + to));
    let first = plane.branch_over(0, start)?;
    let mut branch = Branch::new(&first, EquilibriumBranch::default());
    add_orbits(&first, OrbitStarts::Scene, &mut branch, &mut |_| check())?;
    let points = branch.orbit_bifurcations();
    let points = points.filter(|found| found.bifurcation.kind == BifurcationKind::NeimarkSacker);
    let mut curves: Vec<TorusCurve> = Vec::new();
    for found in points {
        let found = located(&found.bifurcation, [found.at.value, start]);
        if curves
            .iter()
            .any(|curve| plane.passes(&curve.points, &found.at))
        {
            continue;
        }
        let mut curve = TorusCurve {
            points: vec![found.at],
            closed: false,
            ended: Vec::new(),
        };
        for way in [-1.0, 1.0] {
            if curve.closed {
                break;
            }
            let (traced, end) = plane.trace(&found, way, check)?;
            // The first direction is the beginning of the curve, in reverse.
            curve.points.reverse();
            curve.points.extend(traced);
            match end {
                End::Border => {}
                End::Closed => curve.closed = true,
                End::Lost(reason) => curve.ended.push(reason),
            }
        }
        curves.push(curve);
    }
    check()?;
    Ok(curves)
}

fn located(found: &Bifurcation, values: [f64; 2]) -> Located {
    Located {
        at: TorusCurvePoint {
            values,
            frequency_hz: found.frequency_hz,
            second_hz: found.torus_frequency_hz.unwrap_or(f64::NAN),
        },
        orbit: found.orbit.clone(),
    }
}

impl Plane<'_> {
    /// The plan of the branch over one of the parameters at a value of the other one.
    fn branch_over(&self, axis: usize, other: f64) -> Result<BranchPlan, BranchError> {
        let scene = self
            .scene
            .with_values(&[(self.parameters[1 - axis], other)])?;
        Ok(BranchPlan {
            scene,
            parameter: self.parameters[axis],
            interval: self.intervals[axis],
            points: 2,
        })
    }

    /// The values of the parameters relative to their intervals, 0 to 1.
    fn relative(&self, values: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let [from, to] = self.intervals[axis];
            (values[axis] - from) / (to - from)
        })
    }

    /// The vector from one point to another, relative to the intervals.
    fn between(&self, from: &TorusCurvePoint, to: &TorusCurvePoint) -> [f64; 2] {
        let [a, b] = [from, to].map(|point| self.relative(point.values));
        [b[0] - a[0], b[1] - a[1]]
    }

    /// Whether a curve passes a point: it lies next to the chord between two of its points.
    fn passes(&self, curve: &[TorusCurvePoint], point: &TorusCurvePoint) -> bool {
        curve.windows(2).any(|pair| {
            let [chord, offset] = [&pair[1], point].map(|to| self.between(&pair[0], to));
            let length = chord[0].hypot(chord[1]);
            let along = (chord[0] * offset[0] + chord[1] * offset[1]) / length;
            let aside = (chord[0] * offset[1] - chord[1] * offset[0]) / length;
            let change = pair[0].rotation_number() - point.rotation_number();
            (0.0..=length).contains(&along) && aside.abs() < ON_CURVE && change.abs() < SAME
        })
    }

    /// Follows a curve from a point, which is not part of the result, in one direction of the second parameter.
    fn trace(
        &self,
        start: &Located,
        way: f64,
        check: &mut dyn FnMut() -> Result<(), Stopped>,
    ) -> Result<(Vec<TorusCurvePoint>, End), BranchError> {
        let mut points: Vec<TorusCurvePoint> = Vec::new();
        let mut now = start.clone();
        let mut direction = [0.0, way];
        let [mut step, least, most] = CURVE_STEPS;
        loop {
            let here = self.relative(now.at.values);
            let Some((axis, length)) = step_within(here, direction, step) else {
                return Ok((points, End::Border));
            };
            check()?;
            let expected = [0, 1].map(|k| {
                let [from, to] = self.intervals[k];
                let share = (here[k] + length * direction[k]).clamp(0.0, 1.0);
                from * (1.0 - share) + to * share
            });
            let next = self.point(&now, axis, expected)?;
            let next = next.filter(|next| {
                let [x, y] = self.between(&now.at, &next.at);
                x * direction[0] + y * direction[1] > 0.0
            });
            let Some(next) = next else {
                // Not the next step, which a border may have shortened.
                step = 0.5 * length;
                if step >= least {
                    continue;
                }
                return Ok((points, End::Lost(self.lost(&now.at))));
            };
            let [x, y] = self.between(&now.at, &next.at);
            let moved = x.hypot(y);
            let turn =
                (y * direction[0] - x * direction[1]).atan2(x * direction[0] + y * direction[1]);
            direction = [x / moved, y / moved];
            if points.len() > 2 && self.passes(&[now.at, next.at], &start.at) {
                points.push(start.at);
                return Ok((points, End::Closed));
            }
            points.push(next.at);
            now = next;
            if points.len() >= MAX_POINTS {
                let reason = "the maximum number of points was reached".to_owned();
                return Ok((points, End::Lost(reason)));
            }
            step *= match turn.abs() {
                turn if turn < TURNS[0] => 2.0,
                turn if turn > TURNS[1] => 0.5,
                _ => 1.0,
            };
            step = step.clamp(least, most);
        }
    }

    /// Why a curve ends at a point.
    fn lost(&self, at: &TorusCurvePoint) -> String {
        let names = self.parameters.map(|parameter| parameter.name().to_owned());
        format!(
            "a curve ends at {} = {:.6}, {} = {:.6}: no Neimark-Sacker point was found beyond",
            names[0], at.values[0], names[1], at.values[1],
        )
    }

    /// The Neimark-Sacker point next to another one, with the expected value of one parameter (`axis`) and near that of
    /// the other one.
    fn point(
        &self,
        near: &Located,
        axis: usize,
        expected: [f64; 2],
    ) -> Result<Option<Located>, BranchError> {
        let over = 1 - axis;
        let branch = self.branch_over(over, expected[axis])?;
        let [low, high] = self.intervals[over];
        let reach = REACH * (high - low);
        let middle = expected[over];
        let bounds = [(middle - reach).max(low), (middle + reach).min(high)];
        let options = ContinuationOptions {
            steps: STEPS,
            ..ContinuationOptions::new(bounds, self.scene.integrator.max_step)
        };
        let family = SubjectFamily::new(&branch);
        let start = BranchStart::from(PeriodicOrbit {
            parameter: middle,
            ..near.orbit.clone()
        });
        let Ok(piece) = continue_orbits(&family, &start, &options, &mut |_| true) else {
            return Ok(None);
        };
        let found = piece.bifurcations.iter();
        let tori = found.filter(|found| found.kind == BifurcationKind::NeimarkSacker);
        let tori = tori.map(|found| {
            let mut values = expected;
            values[over] = found.parameter;
            located(found, values)
        });
        let change =
            |found: &Located| (found.at.rotation_number() - near.at.rotation_number()).abs();
        let nearest = tori.min_by(|a, b| change(a).total_cmp(&change(b)));
        Ok(nearest.filter(|found| change(found) < SAME))
    }
}

/// The length of a step in the unit square, shortened to end on its border, and the parameter that is set: the one whose
/// border is reached, else the one that changes more. `None` for a step out of the square.
fn step_within(here: [f64; 2], direction: [f64; 2], step: f64) -> Option<(usize, f64)> {
    let inside = usize::from(direction[1].abs() > direction[0].abs());
    let to_border = [0, 1].map(|axis| {
        let room = if direction[axis] > 0.0 {
            1.0 - here[axis]
        } else {
            here[axis]
        };
        room / direction[axis].abs()
    });
    let nearest = usize::from(to_border[1] < to_border[0]);
    match to_border[nearest] {
        room if room <= 1e-9 => None,
        room if room <= step => Some((nearest, room)),
        _ => Some((inside, step)),
    }
}
