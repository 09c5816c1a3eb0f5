//! Sweeps and basins: settled responses over parameters and kicks.

use std::num::NonZero;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use squeakscope::study::basins::Basins;
use squeakscope::study::response::ResponsePlan;
use squeakscope::study::sweep::{
    self as sweep_study, Axis, Shard, Start, SweepObserver, SweepPlan, SweepPoint, SweepProgress,
    SweepResult,
};
use squeakscope::study::{ThreadSpawnError, threads};

use crate::array::{choice, optional, positive, vector, whole};
use crate::call::{Watch, long_call};
use crate::error::{input, raise};
use crate::result::{Fields, result};
use crate::scene::SceneOrName;

/// Collects the points of a sweep.
struct Points<'a> {
    points: Vec<SweepPoint>,
    watch: &'a Watch,
}

impl SweepObserver for Points<'_> {
    type Error = ThreadSpawnError;

    fn on_point(&mut self, point: SweepPoint) -> Result<(), ThreadSpawnError> {
        self.points.push(point);
        Ok(())
    }

    fn on_progress(&mut self, progress: SweepProgress) -> bool {
        self.watch.report(progress.share)
    }
}

/// Computes a shard of a sweep; returns its points in ascending order of index.
fn points(
    py: Python<'_>,
    plan: &SweepPlan,
    shard: Shard,
    number_of_threads: Option<i64>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<SweepPoint>> {
    let number_of_threads = optional("threads", number_of_threads, 1)?.and_then(NonZero::new);
    long_call(py, progress, |watch| {
        let mut found = Points {
            points: Vec::new(),
            watch,
        };
        sweep_study::sweep(plan, shard, &[], threads(number_of_threads), &mut found)?;
        found.points.sort_by_key(|point| point.place.index);
        Ok::<_, ThreadSpawnError>(found.points)
    })
}

/// A plan of responses without what only pictures need.
fn response(
    [min_transient, max_transient, measure]: [f64; 3],
    exponents: i64,
) -> PyResult<ResponsePlan> {
    Ok(ResponsePlan {
        min_transient: positive("min_transient", min_transient)?,
        max_transient: positive("max_transient", max_transient)?,
        measurement_time: positive("measure", measure)?,
        exponents: whole("exponents", exponents, 0)?,
        orbits: true,
        portrait: false,
        max_rhs_evals: None,
    })
}

/// Compute the settled response over one or two parameters.
///
/// The results do not depend on the number of threads or of shards.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// values : dict
///     One or two keys of the scene, each with its values, in the unit of the scene file.
/// starts : sequence of {"fresh", "upward", "downward"}
///     Initial states: the kick of the scene, or the state at the next lower or higher value of the first key.
/// min_transient, max_transient : float
///     Shortest and longest time for the motion to settle, s.
/// measure : float
///     Time of the measurement, s; a quarter of it for a motion that follows a stable periodic orbit.
/// exponents : int
///     Number of largest Lyapunov exponents; 0 for none.
/// shard : tuple of int, optional
///     Part to compute, and number of parts, such as (3, 8). By default (1, 1), the whole.
/// threads : int, optional
///     Number of threads. By default the number of cores.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``points``, a row each, which has the values of the parameters by their keys, as ``row["load.tilt_deg"]``;
///     ``regime_intervals``, ``transitions``, ``hysteresis``.
#[pyfunction]
#[pyo3(signature = (scene, values, *, starts=None, min_transient=0.05, max_transient=1.0, measure=0.6, exponents=3,
    shard=None, threads=None, progress=None))]
pub fn sweep<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    values: &Bound<'py, PyDict>,
    starts: Option<Vec<String>>,
    min_transient: f64,
    max_transient: f64,
    measure: f64,
    exponents: i64,
    shard: Option<(usize, usize)>,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.load(None)?;
    let axes = values.iter().map(|(key, values)| {
        let parameter = scene.parameter(&key.extract::<String>()?);
        let parameter = parameter.map_err(|error| raise(&error))?;
        let name = format!("values of {}", parameter.path());
        Ok(Axis::new(
            parameter,
            vector(&name, &values)?.as_slice()?.to_vec(),
        ))
    });
    let axes = axes.collect::<PyResult<Vec<_>>>()?;
    if !(1..=2).contains(&axes.len()) {
        return Err(input("values: give one or two keys"));
    }
    let known = Start::ALL.map(|start| (start.to_string(), start));
    let known: Vec<_> = known
        .iter()
        .map(|(name, start)| (name.as_str(), *start))
        .collect();
    let mut chosen: Vec<Start> = Vec::new();
    for word in starts.unwrap_or_else(|| vec!["upward".to_owned(), "downward".to_owned()]) {
        let start = choice("starts", &word, &known)?;
        if !chosen.contains(&start) {
            chosen.push(start);
        }
    }
    let plan = SweepPlan {
        scene,
        axes,
        starts: chosen,
        response: response([min_transient, max_transient, measure], exponents)?,
    };
    if plan.is_empty() {
        return Err(input("values, starts: there is no point to compute"));
    }
    let (number, of) = shard.unwrap_or((1, 1));
    if !(1..=of).contains(&number) {
        return Err(input(
            "shard: give the number of the part from 1, and the number of parts",
        ));
    }
    let shard = Shard { number, of };
    let found = points(py, &plan, shard, threads, progress.as_ref())?;
    let answer = Fields::of(py, &SweepResult::new(&plan, found, shard, false))?;
    answer
        .name_values(
            &plan
                .axes
                .iter()
                .map(|axis| axis.parameter().path())
                .collect::<Vec<_>>(),
        )?
        .finish::<SweepResult>()
}

/// Find coexisting attractors, and the share of random kicks that reach each.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// kicks : int
///     Number of random kicks.
/// seed : int
///     Seed of the first kick; each further kick takes the next seed.
/// min_transient, max_transient, measure, exponents, threads, progress : optional
///     As for :func:`sweep`.
///
/// Returns
/// -------
/// Result
///     ``attractors`` in descending order of their share.
#[pyfunction]
#[pyo3(signature = (scene, kicks=20, *, seed=1, min_transient=0.05, max_transient=1.0, measure=0.6, exponents=3,
    threads=None, progress=None))]
pub fn basins<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    kicks: i64,
    seed: i64,
    min_transient: f64,
    max_transient: f64,
    measure: f64,
    exponents: i64,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (kicks, first) = (whole("kicks", kicks, 1)?, whole("seed", seed, 0)?);
    let seeds = (first..first + kicks).map(|seed| seed as f64);
    let scene = scene.load(None)?;
    let seed = scene.parameter("start.seed");
    let plan = SweepPlan {
        axes: vec![Axis::new(seed.map_err(|error| raise(&error))?, seeds)],
        scene,
        starts: vec![Start::Fresh],
        response: response([min_transient, max_transient, measure], exponents)?,
    };
    let found = points(py, &plan, Shard::WHOLE, threads, progress.as_ref())?;
    result(py, &Basins::new(&plan, &found, false))
}
