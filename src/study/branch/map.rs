//! Stability over two parameters: the number of unstable modes and the largest growth rate on a grid, and the curves on
//! which a mode changes its stability.
//!
//! Curves in the plane of two parameters: each step sets the parameter that changes more and solves for the other one, so
//! that turning points are passed. Lengths and angles are those in the unit square of the intervals.
//!
//! A Hopf curve is the zero of the growth rate of a mode that is followed by its shape. With one parameter set, the secant
//! method solves for the other one.
//!
//! A curve of Neimark-Sacker points starts at each such point of the branch of periodic orbits over the first parameter, at the
//! value of the scene for the second one. With one parameter set, a short piece of the branch over the other one is followed
//! around the expected value, and the Neimark-Sacker point in it located.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::equilibria::BranchPlan;
use super::family::SubjectFamily;
use super::orbits::{OrbitStarts, add_orbits};
use super::result::Branch;
use crate::dynamics::continuation::{
    Bifurcation, BifurcationKind, BranchStart, ContinuationOptions, PeriodicOrbit, StepLimits,
    continue_orbits,
};
use crate::dynamics::equilibrium::Eigenmode;
use crate::joint::NamedMode;
use crate::scene::{Parameter, Scene};
use crate::study::pool::{Emit, run_jobs};
use crate::study::{OnProgress, StopCheck, StudyError};

/// Name of the work.
const TASK: &str = "stability map";

/// A plan of a stability map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPlan {
    /// The scene.
    pub scene: Scene,
    /// The parameters: horizontal, vertical.
    pub parameters: [Parameter; 2],
    /// The ends of the interval of each parameter, ascending, in the units of the scene file.
    pub intervals: [[f64; 2]; 2],
    /// Numbers of grid points along each parameter, at least 2.
    pub size: [usize; 2],
    /// Whether to trace the curves of Neimark-Sacker points of periodic orbits, too.
    pub orbits: bool,
}

/// A parameter of a map and its values.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MapAxis {
    /// Path of the key in the scene file.
    pub parameter: String,
    /// Unit of the key; empty for a dimensionless number.
    pub unit: String,
    /// The values of the grid in this unit, ascending.
    pub values: Vec<f64>,
}

/// A point of the grid of a map.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MapPoint {
    /// Number of unstable modes; `None` if the system has no equilibrium there.
    pub unstable_modes: Option<usize>,
    /// Largest growth rate of all modes, 1/s; `None` if the system has no equilibrium there.
    pub largest_growth_per_s: Option<f64>,
}

/// A stability map.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct StabilityMap {
    /// The parameters on the axes: horizontal, vertical.
    pub axes: [MapAxis; 2],
    /// The grid, row by row: the horizontal parameter varies fastest, in ascending order.
    pub grid: Vec<MapPoint>,
    /// The curves on which a pair of complex eigenvalues is imaginary.
    pub curves: Vec<Curve>,
    /// The curves of Neimark-Sacker points of the periodic motion of the scene, at which a torus is born.
    pub torus_curves: Vec<Curve>,
    /// Whether the study was interrupted, so that curves are missing.
    pub interrupted: bool,
}

/// A grid point with its modes.
type Solved = Result<(Vec<Eigenmode>, Vec<NamedMode>), StudyError>;

impl MapPlan {
    /// The values of the grid along a parameter.
    fn values(&self, axis: usize) -> Vec<f64> {
        let ([from, to], count) = (self.intervals[axis], self.size[axis].max(2));
        let values = (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64);
        values.collect()
    }

    fn family(&self) -> SubjectFamily {
        let names = self.parameters.map(|parameter| parameter.path().to_owned());
        SubjectFamily::new(Arc::new(self.scene.clone()), names.to_vec())
    }
}

/// Computes the map on `threads` threads. The result does not depend on the number of threads. If `progress` stops the
/// study after the grid, it has the curves traced so far.
///
/// # Errors
/// [`StudyError::Stopped`] before the grid is complete; if no thread can be started, or the system cannot be built at any
/// point.
pub fn stability_map(
    plan: &MapPlan,
    threads: usize,
    progress: OnProgress<'_>,
) -> Result<StabilityMap, StudyError> {
    let [xs, ys] = [0, 1].map(|axis| plan.values(axis));
    let place = |k: usize| [xs[k % xs.len()], ys[k / xs.len()]];
    let count = xs.len() * ys.len();
    let mut points: Vec<(usize, Solved)> = Vec::new();
    let job = |k: usize, emit: Emit<'_, _>| {
        // A stop is seen before the next point.
        let _ = emit(Some((k, solve(&plan.family(), place(k)))));
    };
    run_jobs(count, threads, job, |point| {
        points.extend(point);
        // Tracing the curves takes about as long as the grid.
        let share = 0.5 * points.len() as f64 / count as f64;
        Ok::<_, StudyError>(progress(share, TASK)?)
    })?;
    points.sort_by_key(|(k, _)| *k);
    let mut solved: Vec<Solved> = points.into_iter().map(|(_, point)| point).collect();
    if solved.iter().all(Result::is_err)
        && let Some(Err(error)) = solved.drain(..).next()
    {
        return Err(error);
    }
    let axis = |k: usize| MapAxis {
        parameter: plan.parameters[k].path().to_owned(),
        unit: plan.parameters[k].unit().to_owned(),
        values: plan.values(k),
    };
    let mut map = StabilityMap {
        axes: [axis(0), axis(1)],
        grid: solved.iter().map(grid_point).collect(),
        curves: Vec::new(),
        torus_curves: Vec::new(),
        interrupted: false,
    };
    match add_curves(plan, &solved, &mut map, progress) {
        Err(StudyError::Stopped(_)) => map.interrupted = true,
        ended => ended?,
    }
    Ok(map)
}

/// Traces the curves of a map from its grid.
fn add_curves(
    plan: &MapPlan,
    solved: &[Solved],
    map: &mut StabilityMap,
    progress: OnProgress<'_>,
) -> Result<(), StudyError> {
    let [xs, ys] = map.axes.each_ref().map(|axis| &axis.values);
    let place = |k: usize| [xs[k % xs.len()], ys[k / xs.len()]];
    let family = plan.family();
    let edges = edges([xs.len(), ys.len()]);
    // A linear approximation lies this close to its curve.
    let cell = 1.0 / (plan.size[0].min(plan.size[1]).max(2) - 1) as f64;
    let curves = &mut map.curves;
    for (k, [from, to]) in edges.iter().enumerate() {
        progress(0.5 + 0.5 * k as f64 / edges.len() as f64, TASK)?;
        let (Ok((one, names)), Ok((other, _))) = (&solved[*from], &solved[*to]) else {
            continue;
        };
        let along = usize::from(to - from > 1);
        for (seed, label) in seeds([place(*from), place(*to)], one, other, names) {
            let is_known = |curve: &Curve| plan.passes(&curve.points, &seed.0, cell);
            if !curves.iter().any(is_known) {
                let curve = hopf_curve(plan, &family, &seed, along);
                let label = label.to_owned();
                curves.extend(curve.map(|curve| Curve { label, ..curve }));
            }
        }
    }
    if plan.orbits {
        add_torus_curves(plan, &mut map.torus_curves, &mut || progress(1.0, TASK))?;
    }
    Ok(())
}

/// Pairs of neighbouring grid points, along both parameters.
fn edges([columns, rows]: [usize; 2]) -> Vec<[usize; 2]> {
    let pairs = (0..columns * rows).flat_map(|here| {
        let right = (here % columns + 1 < columns).then_some([here, here + 1]);
        let above = (here / columns + 1 < rows).then_some([here, here + columns]);
        right.into_iter().chain(above)
    });
    pairs.collect()
}

fn grid_point(solved: &Solved) -> MapPoint {
    let modes = solved.as_ref().ok().map(|(_, named)| named.iter());
    let growths = modes.clone().map(|modes| modes.map(|mode| mode.growth));
    MapPoint {
        unstable_modes: modes.map(|modes| modes.filter(|mode| mode.unstable).count()),
        largest_growth_per_s: growths.and_then(|growths| growths.reduce(f64::max)),
    }
}

/// The modes whose growth rate changes its sign between two neighbouring points.
fn seeds<'a>(
    places: [[f64; 2]; 2],
    one: &[Eigenmode],
    other: &[Eigenmode],
    names: &'a [NamedMode],
) -> Vec<(PointOf<Eigenmode>, &'a str)> {
    let seeds = one.iter().zip(names).filter_map(|(from, name)| {
        let to = from.most_alike(other)?;
        // A mode that ceases to oscillate has no partner.
        to.most_alike(one).filter(|back| back.value == from.value)?;
        let growths = [from.value.re, to.value.re];
        let crosses = growths[0] * growths[1] < 0.0 && from.oscillates();
        let share = growths[0] / (growths[0] - growths[1]);
        let values = [0, 1].map(|k| places[0][k] + share * (places[1][k] - places[0][k]));
        let seed = of_mode(values, from.clone());
        crosses.then_some((seed, &*name.label))
    });
    seeds.collect()
}

/// The modes at a grid point, in ascending order of frequency.
fn solve(family: &SubjectFamily, values: [f64; 2]) -> Solved {
    let state = family.at(&values)?;
    let mut modes = state.linearised.modes()?;
    modes.sort_by(|a, b| a.value.im.total_cmp(&b.value.im));
    let named = modes.iter().map(|mode| state.named(mode)).collect();
    Ok((modes, named))
}

/// Angles (rad) between successive steps below which the next step is doubled, and above which it is halved.
const TURNS: [f64; 2] = [0.05, 0.15];
/// Smallest cosine of the angle between successive steps; a longer turn is tried again with half the step.
const MIN_COSINE: f64 = 0.9;
/// Distance of a point from the chords of a curve that passes it.
const ON_CURVE: f64 = 2e-3;
/// Largest number of points of a curve in one direction.
const MAX_POINTS: usize = 1000;

/// Relative difference of the frequencies of one Hopf curve at neighbouring points.
const SAME_FREQUENCY: f64 = 0.02;
/// Largest change of the rotation number between neighbouring points of a curve of tori.
const SAME_ROTATION: f64 = 0.05;

/// A point of a curve: a Hopf point, or a Neimark-Sacker point, at which a torus is born: on one side the periodic motion
/// attracts, on the other a torus has taken its place.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CurvePoint {
    /// Values of both parameters, in the units of the scene file.
    pub values: [f64; 2],
    /// Frequency of the mode or of the periodic motion, Hz.
    pub frequency_hz: f64,
    /// Second base frequency of the torus, Hz; absent for a Hopf point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_hz: Option<f64>,
}

impl CurvePoint {
    /// Rotation number of the torus.
    fn rotation(&self) -> Option<f64> {
        Some(self.second_hz? / self.frequency_hz)
    }

    /// Whether a point with almost the same values would be on the same curve.
    fn is_alike(&self, other: &Self) -> bool {
        match self.rotation().zip(other.rotation()) {
            Some((a, b)) => (a - b).abs() < SAME_ROTATION,
            None => (self.frequency_hz / other.frequency_hz - 1.0).abs() < SAME_FREQUENCY,
        }
    }
}

/// A point with its mode or periodic motion, from which the next one is found.
type PointOf<M> = (CurvePoint, M);

/// A curve on which a mode or a periodic motion changes its stability.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Curve {
    /// Dominant mode of the body where a Hopf curve was found; empty for another curve.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// The points, in their order along the curve.
    pub points: Vec<CurvePoint>,
    /// Whether the curve is closed: the last point is the first one.
    pub closed: bool,
    /// Why the curve ends inside the intervals, one sentence each.
    pub ended: Vec<String>,
}

/// Finds the point of a curve next to another one: with the expected value of one parameter (the index) and near the
/// expected value of the other one.
type Solve<'a, M> =
    &'a mut dyn FnMut(&PointOf<M>, usize, [f64; 2]) -> Result<Option<PointOf<M>>, StudyError>;

impl MapPlan {
    /// The values of the parameters relative to their intervals, 0 to 1.
    fn relative(&self, values: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let [from, to] = self.intervals[axis];
            (values[axis] - from) / (to - from)
        })
    }

    fn between(&self, from: &CurvePoint, to: &CurvePoint) -> [f64; 2] {
        let [a, b] = [from, to].map(|point| self.relative(point.values));
        [b[0] - a[0], b[1] - a[1]]
    }

    /// Whether a curve passes a point at less than a distance.
    fn passes(&self, curve: &[CurvePoint], point: &CurvePoint, within: f64) -> bool {
        curve.windows(2).any(|pair| {
            let [[x, y], [dx, dy]] = [&pair[1], point].map(|to| self.between(&pair[0], to));
            let along = ((x * dx + y * dy) / (x * x + y * y)).clamp(0.0, 1.0);
            let aside = (dx - along * x).hypot(dy - along * y);
            aside < within && pair[0].is_alike(point)
        })
    }

    /// Follows a curve from a point in both directions. `direction` is a first guess, `steps` are the first, the smallest and
    /// the largest step.
    fn follow<M: Clone>(
        &self,
        start: &PointOf<M>,
        direction: [f64; 2],
        steps: [f64; 3],
        solve: Solve<'_, M>,
    ) -> Result<Curve, StudyError> {
        let mut curve = Curve {
            points: vec![start.0.clone()],
            ..Curve::default()
        };
        for way in [-1.0, 1.0] {
            if !curve.closed {
                // The first direction is the beginning of the curve, in reverse.
                curve.points.reverse();
                let direction = direction.map(|d| way * d);
                self.trace(start.clone(), direction, steps, &mut curve, solve)?;
            }
        }
        Ok(curve)
    }

    /// Continues a curve from its last point.
    fn trace<M>(
        &self,
        mut now: PointOf<M>,
        mut direction: [f64; 2],
        [mut step, least, most]: [f64; 3],
        curve: &mut Curve,
        solve: Solve<'_, M>,
    ) -> Result<(), StudyError> {
        let start = curve.points.len();
        let first = now.0.clone();
        loop {
            let here = self.relative(now.0.values);
            let Some((axis, length)) = step_within(here, direction, step) else {
                return Ok(());
            };
            let expected = [0, 1].map(|k| {
                let [from, to] = self.intervals[k];
                let share = (here[k] + length * direction[k]).clamp(0.0, 1.0);
                from * (1.0 - share) + to * share
            });
            let cosine = if curve.points.len() > start {
                MIN_COSINE
            } else {
                0.0
            };
            let [dx, dy] = direction;
            let next = solve(&now, axis, expected)?;
            let next = next.map(|next| (self.between(&now.0, &next.0), next));
            let next = next.filter(|([x, y], _)| x * dx + y * dy > cosine * x.hypot(*y));
            let Some(([x, y], next)) = next else {
                // Not the next step, which a border may have shortened.
                step = 0.5 * length;
                if step >= least {
                    continue;
                }
                let at = now.0.values;
                let names = self.parameters.map(|parameter| parameter.name());
                curve.ended.push(format!(
                    "the curve ends at {} = {:.6}, {} = {:.6}: no further point was found",
                    names[0], at[0], names[1], at[1],
                ));
                return Ok(());
            };
            let turn = (y * dx - x * dy).atan2(x * dx + y * dy);
            let moved = x.hypot(y);
            direction = [x / moved, y / moved];
            let pair = [now.0, next.0.clone()];
            now = next;
            if curve.points.len() > start + 2 && self.passes(&pair, &first, ON_CURVE) {
                curve.points.push(first);
                curve.closed = true;
                return Ok(());
            }
            curve.points.push(now.0.clone());
            if curve.points.len() - start >= MAX_POINTS {
                let reason = "the maximum number of points was reached".to_owned();
                curve.ended.push(reason);
                return Ok(());
            }
            step *= match turn.abs() {
                turn if turn < TURNS[0] => 2.0,
                turn if turn > TURNS[1] => 0.5,
                _ => 1.0,
            };
            step = step.clamp(least, most);
        }
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

/// First, smallest and largest step along a curve, relative to the intervals.
const HOPF_STEPS: [f64; 3] = [0.01, 1e-4, 0.03];
/// First step of the secant method, relative to the interval.
const DIFFERENCE: f64 = 1e-5;
/// Steps of the secant method.
const SECANT_STEPS: usize = 12;
/// Largest correction, as a fraction of the interval, of a converged point.
const CONVERGED: f64 = 1e-11;

/// A point of a Hopf curve, or a first approximation of one.
fn of_mode(values: [f64; 2], mode: Eigenmode) -> PointOf<Eigenmode> {
    let point = CurvePoint {
        values,
        frequency_hz: mode.frequency_hz(),
        second_hz: None,
    };
    (point, mode)
}

/// The curve through a point near a first approximation, which lies on an edge of the grid along a parameter (`along`).
/// `None` if there is no point.
fn hopf_curve(
    plan: &MapPlan,
    family: &SubjectFamily,
    (seed, mode): &PointOf<Eigenmode>,
    along: usize,
) -> Option<Curve> {
    let start = hopf_point(plan, family, mode, along, seed.values)?;
    // The tangent is normal to the gradient of the growth rate.
    let slope = |axis: usize| {
        let values = moved(plan, start.0.values, axis);
        let [from, to] = plan.intervals[axis];
        let growth = mode_at(family, values, &start.1)?.value.re - start.1.value.re;
        Some(growth * (to - from) / (values[axis] - start.0.values[axis]))
    };
    let (a, b) = (slope(0)?, slope(1)?);
    let tangent = [-b / a.hypot(b), a / a.hypot(b)];
    let mut solve = |(_, mode): &PointOf<_>, axis: usize, expected: [f64; 2]| {
        Ok(hopf_point(plan, family, mode, 1 - axis, expected))
    };
    plan.follow(&start, tangent, HOPF_STEPS, &mut solve).ok()
}

/// The mode next to another one at some values of the parameters.
fn mode_at(family: &SubjectFamily, values: [f64; 2], near: &Eigenmode) -> Option<Eigenmode> {
    let modes = family.at(&values).ok()?.linearised.modes().ok()?;
    near.most_alike(&modes).cloned()
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

/// The point of a curve with a mode next to another one by the secant method over one parameter (`along`), from a guess.
fn hopf_point(
    plan: &MapPlan,
    family: &SubjectFamily,
    near: &Eigenmode,
    along: usize,
    guess: [f64; 2],
) -> Option<PointOf<Eigenmode>> {
    let [from, to] = plan.intervals[along];
    let mut values = moved(plan, guess, along);
    let mut mode = mode_at(family, guess, near)?;
    let mut change = values[along] - guess[along];
    for _ in 0..SECANT_STEPS {
        let before = mode.value.re;
        mode = mode_at(family, values, &mode)?;
        if change.abs() < CONVERGED * (to - from) || mode.value.re == 0.0 {
            return Some(of_mode(values, mode));
        }
        change *= mode.value.re / (before - mode.value.re);
        values[along] += change;
        if !values[along].is_finite() {
            return None;
        }
    }
    None
}

/// Half the length of the piece of the branch around the expected point, relative to the interval of its parameter.
const REACH: f64 = 0.05;
/// Steps along this piece, relative to its length.
const PIECE: StepLimits = StepLimits {
    initial: 0.2,
    min: 1e-3,
    max: 0.5,
};
/// First, smallest and largest step along a curve, relative to the intervals.
const TORUS_STEPS: [f64; 3] = [0.025, 5e-4, 0.1];

fn of_orbit(values: [f64; 2], found: &Bifurcation) -> PointOf<PeriodicOrbit> {
    let point = CurvePoint {
        values,
        frequency_hz: found.frequency_hz,
        second_hz: found.torus_frequency_hz,
    };
    (point, found.orbit.clone())
}

/// Adds the curves of Neimark-Sacker points of a map, each when it is complete. `check` is called before each piece.
///
/// # Errors
/// [`StudyError::Stopped`]; if a value of a parameter is invalid, or a system cannot be built.
pub(super) fn add_torus_curves(
    plan: &MapPlan,
    curves: &mut Vec<Curve>,
    check: StopCheck<'_>,
) -> Result<(), StudyError> {
    let [from, to] = plan.intervals[1];
    let own = plan.scene.value_of(plan.parameters[1]);
    let own = own.filter(|value| (from..=to).contains(value));
    let start = own.unwrap_or(0.5 * (from + to));
    let first = branch_over(plan, 0, start)?;
    let mut branch = Branch::new(&first);
    let (starts, progress) = (OrbitStarts::Scene, &mut |_: f64, _: &str| check());
    add_orbits(&first, starts, &mut branch, progress, &mut |_| ())?;
    let points = branch.orbit_bifurcations();
    let points = points.filter(|found| found.bifurcation.kind == BifurcationKind::NeimarkSacker);
    for found in points {
        let found = of_orbit([found.at.value, start], &found.bifurcation);
        let is_known = |curve: &Curve| plan.passes(&curve.points, &found.0, ON_CURVE);
        if !curves.iter().any(is_known) {
            let mut solve = |near: &PointOf<_>, axis: usize, expected: [f64; 2]| {
                check()?;
                torus_point(plan, near, axis, expected)
            };
            curves.push(plan.follow(&found, [0.0, 1.0], TORUS_STEPS, &mut solve)?);
        }
    }
    check()?;
    Ok(())
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
fn torus_point(
    plan: &MapPlan,
    (near, orbit): &PointOf<PeriodicOrbit>,
    axis: usize,
    expected: [f64; 2],
) -> Result<Option<PointOf<PeriodicOrbit>>, StudyError> {
    let over = 1 - axis;
    let branch = branch_over(plan, over, expected[axis])?;
    let [low, high] = plan.intervals[over];
    let reach = REACH * (high - low);
    let middle = expected[over];
    let bounds = [(middle - reach).max(low), (middle + reach).min(high)];
    let options = ContinuationOptions {
        steps: PIECE,
        ..ContinuationOptions::new(bounds, plan.scene.integrator.max_step)
    };
    let start = BranchStart::from(PeriodicOrbit {
        parameter: middle,
        ..orbit.clone()
    });
    let family = branch.family();
    let Ok(piece) = continue_orbits(&family, &start, &options, &mut |_| Ok(())) else {
        return Ok(None);
    };
    let found = piece.bifurcations.iter();
    let tori = found.filter(|found| found.kind == BifurcationKind::NeimarkSacker);
    let tori = tori.map(|found| {
        let mut values = expected;
        values[over] = found.parameter;
        of_orbit(values, found)
    });
    let change = |(found, _): &PointOf<_>| {
        let change = found.rotation().zip(near.rotation());
        change.map_or(f64::NAN, |(a, b)| (a - b).abs())
    };
    let nearest = tori.min_by(|a, b| change(a).total_cmp(&change(b)));
    Ok(nearest.filter(|(found, _)| found.is_alike(near)))
}
