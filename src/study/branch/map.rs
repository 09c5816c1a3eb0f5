//! Stability over two parameters: the number of unstable modes and the largest growth rate on a grid, and the curves on
//! which a mode changes its stability.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::curve::{Curve, PointOf, hopf_curve, of_mode, torus_curves};
use super::family::SubjectFamily;
use super::tracking::most_alike;
use crate::dynamics::equilibrium::Eigenmode;
use crate::joint::NamedMode;
use crate::scene::{Parameter, Scene};
use crate::study::pool::{Emit, run_jobs};
use crate::study::{OnProgress, StudyError};

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

/// Computes the map on `threads` threads. The result does not
/// depend on the number of threads.
///
/// # Errors
/// [`StudyError::Stopped`]; if no thread can be started, or the system cannot be built at any point.
pub fn stability_map(
    plan: &MapPlan,
    threads: usize,
    progress: OnProgress<'_>,
) -> Result<StabilityMap, StudyError> {
    let [xs, ys] = [0, 1].map(|axis| plan.values(axis));
    let mut rows: Vec<(usize, Vec<Solved>)> = Vec::new();
    let job = |row: usize, emit: Emit<'_, _>| {
        let family = plan.family();
        let points = xs.iter().map_while(|&x| {
            emit(None).ok()?;
            Some(solve(&family, [x, ys[row]]))
        });
        let points: Vec<Solved> = points.collect();
        if points.len() == xs.len() {
            // A stop is seen before the next row.
            let _ = emit(Some((row, points)));
        }
    };
    run_jobs(ys.len(), threads, job, |row| {
        rows.extend(row);
        // Tracing the curves takes about as long as the grid.
        let share = 0.5 * rows.len() as f64 / ys.len() as f64;
        Ok::<_, StudyError>(progress(share, TASK)?)
    })?;
    rows.sort_by_key(|(row, _)| *row);
    let mut solved: Vec<Solved> = rows.into_iter().flat_map(|(_, points)| points).collect();
    if solved.iter().all(Result::is_err)
        && let Some(Err(error)) = solved.drain(..).next()
    {
        return Err(error);
    }
    let grid = solved.iter().map(grid_point).collect();
    let family = plan.family();
    let edges = edges([xs.len(), ys.len()]);
    // A linear approximation lies this close to its curve.
    let cell = 1.0 / (plan.size[0].min(plan.size[1]).max(2) - 1) as f64;
    let mut curves: Vec<Curve> = Vec::new();
    for (k, [from, to]) in edges.iter().enumerate() {
        progress(0.5 + 0.5 * k as f64 / edges.len() as f64, TASK)?;
        let (Ok((one, names)), Ok((other, _))) = (&solved[*from], &solved[*to]) else {
            continue;
        };
        let place = |k: usize| [xs[k % xs.len()], ys[k / xs.len()]];
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
    let axis = |k: usize, values: &[f64]| MapAxis {
        parameter: plan.parameters[k].path().to_owned(),
        unit: plan.parameters[k].unit().to_owned(),
        values: values.to_vec(),
    };
    let torus_curves = if plan.orbits {
        torus_curves(plan, &mut || progress(1.0, TASK))?
    } else {
        Vec::new()
    };
    Ok(StabilityMap {
        axes: [axis(0, &xs), axis(1, &ys)],
        grid,
        curves,
        torus_curves,
    })
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
        let to = most_alike(other.to_vec(), from)?;
        // A mode that ceases to oscillate has no partner.
        most_alike(one.to_vec(), &to).filter(|back| back.value == from.value)?;
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
    let mut modes = state.modes()?;
    modes.sort_by(|a, b| a.value.im.total_cmp(&b.value.im));
    let named = modes.iter().map(|mode| state.named(mode)).collect();
    Ok((modes, named))
}
