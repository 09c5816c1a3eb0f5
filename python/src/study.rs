//! Studies of scenes: many simulations, or the linearised system.

use std::num::NonZero;

use pyo3::prelude::*;
use squeakscope::dynamics::equilibrium::EquilibriumError;
use squeakscope::joint::BallJoint;
use squeakscope::scene::{Parameter, SceneError};
use squeakscope::study::basins::Basins;
use squeakscope::study::branch::{
    self as branches, Branch, BranchError, BranchPlan, EquilibriumBranch, OrbitProgress,
    add_orbits, equilibria,
};
use squeakscope::study::cost::{self as cost_study, CostPlan};
use squeakscope::study::lyapunov::{ExponentCount, Goal, LyapunovRequest, scene_lyapunov};
use squeakscope::study::response::ResponsePlan;
use squeakscope::study::sweep::{
    self as sweep_study, Axis, Shard, Start, SweepObserver, SweepPlan, SweepPoint, SweepProgress,
    SweepResult,
};
use squeakscope::study::{ThreadSpawnError, stability as linear_modes, threads};

use crate::call::{Watch, long_call};
use crate::error::{input, raise};
use crate::result::result;
use crate::scene::SceneOrName;
use crate::signal::choice;

/// Linear modes of steady sliding, from complex eigenvalues.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// tilts_deg : sequence of float, optional
///     Tilts of the load, degrees. By default that at the start of the scene.
///
/// Returns
/// -------
/// Results
///     The modes at each tilt, with frequency and growth rate; ``unstable`` modes can squeak.
#[pyfunction]
#[pyo3(signature = (scene, tilts_deg=None))]
pub fn stability<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    tilts_deg: Option<Vec<f64>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.load(py, None)?;
    let raised = |error: SceneError| raise(py, &error);
    let tilts = match tilts_deg {
        None => vec![scene.joint().map_err(raised)?.tilt.at(0.0)],
        Some(tilts) => {
            let at = |tilt| {
                let tilted = scene.clone().with_tilt(tilt)?;
                Ok(tilted.joint()?.tilt.at(0.0))
            };
            let tilts = tilts.into_iter().map(at).collect::<Result<_, SceneError>>();
            tilts.map_err(raised)?
        }
    };
    let spec = &scene.joint().map_err(raised)?.spec;
    let found = long_call(py, None, |_| {
        let ball = BallJoint::new(spec).map_err(squeakscope::study::StudyError::from)?;
        linear_modes(&ball, &tilts)
    })?;
    result(py, &found)
}

/// Sensitivities of the modes of steady sliding to all numbers of a scene.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Results
///     The oscillating modes, each with its ``parameters``, the most influential first.
#[pyfunction]
#[pyo3(signature = (scene, *, progress=None))]
pub fn sensitivities<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.load(py, None)?;
    let found = long_call(py, progress.as_ref(), |watch| {
        branches::sensitivities(&scene, &mut |share| watch.report(share))
    })?;
    result(py, &found)
}

/// Follow equilibria and periodic motions of a scene over a parameter.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// parameter : str
///     Key of the parameter.
/// interval : tuple of float
///     First and last value of the parameter, in the unit of the scene file. By default (0, 8).
/// points : int
///     Number of equally spaced equilibria, at least 2.
/// orbits : bool
///     Whether to follow periodic motions, too.
/// start : float, optional
///     Value at which the first periodic motion is simulated.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``equilibria``, ``points`` (periodic orbits) and ``bifurcations``.
#[pyfunction]
#[pyo3(signature = (scene, parameter="load.tilt_deg", interval=(0.0, 8.0), *, points=41, orbits=true, start=None,
    progress=None))]
pub fn branch<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    parameter: &str,
    interval: (f64, f64),
    points: usize,
    orbits: bool,
    start: Option<f64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (from, to) = interval;
    if !(from < to) {
        return Err(input(
            py,
            "interval: the first value must be less than the last",
        ));
    }
    let plan = BranchPlan {
        scene: scene.load(py, None)?,
        parameter: named(py, parameter)?,
        interval: [from, to],
        points,
    };
    let found = long_call(py, progress.as_ref(), |watch| {
        for value in [from, to].into_iter().chain(start) {
            plan.scene.with_values(&[(plan.parameter, value)])?;
        }
        let steady = match equilibria(&plan, &mut |share| watch.report(0.1 * share)) {
            // A system driven in time has no equilibria, but periodic orbits.
            Err(BranchError::Equilibrium(EquilibriumError::Driven)) if orbits => {
                EquilibriumBranch::default()
            }
            steady => steady?,
        };
        let mut found = Branch::new(&plan, steady);
        if orbits {
            let mut report = |update| {
                let share = match update {
                    OrbitProgress::Settling(_) => 0.1,
                    OrbitProgress::Orbit { value, .. } => 0.2 + 0.8 * (value - from) / (to - from),
                };
                watch.report(share)
            };
            add_orbits(&plan, start, &mut found, &mut report)?;
        }
        Ok::<_, BranchError>(found)
    })?;
    result(py, &found)
}

fn named(py: Python<'_>, parameter: &str) -> PyResult<Parameter> {
    Parameter::named(parameter).map_err(|error| raise(py, &error))
}

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
    number_of_threads: Option<NonZero<usize>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<SweepPoint>> {
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
    py: Python<'_>,
    [min_transient, max_transient, measure]: [f64; 3],
    exponents: usize,
) -> PyResult<ResponsePlan> {
    let positive = |time: f64| time > 0.0 && time.is_finite();
    if ![min_transient, max_transient, measure]
        .into_iter()
        .all(positive)
    {
        let message = "min_transient, max_transient, measure: give finite times above 0 s";
        return Err(input(py, message));
    }
    Ok(ResponsePlan {
        min_transient,
        max_transient,
        measurement_time: measure,
        exponents,
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
///     Time of the measurement, s.
/// exponents : int
///     Number of largest Lyapunov exponents; 0 for none.
/// shard : tuple of int
///     Part to compute, and number of parts, such as (3, 8). By default (1, 1), the whole.
/// threads : int, optional
///     Number of threads. By default the number of cores.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``points``, a row each; ``regime_intervals``, ``transitions``, ``hysteresis``.
#[pyfunction]
#[pyo3(signature = (scene, values, *, starts=None, min_transient=0.05, max_transient=1.0, measure=0.6, exponents=3,
    shard=(1, 1), threads=None, progress=None))]
pub fn sweep<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    values: &Bound<'py, pyo3::types::PyDict>,
    starts: Option<Vec<String>>,
    min_transient: f64,
    max_transient: f64,
    measure: f64,
    exponents: usize,
    shard: (usize, usize),
    threads: Option<NonZero<usize>>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let axes = values.iter().map(|(key, values)| {
        let parameter = named(py, &key.extract::<String>()?)?;
        Ok(Axis::new(parameter, values.extract::<Vec<f64>>()?))
    });
    let axes = axes.collect::<PyResult<Vec<_>>>()?;
    if !(1..=2).contains(&axes.len()) {
        return Err(input(py, "values: give one or two keys"));
    }
    let mut chosen: Vec<Start> = Vec::new();
    for word in starts.unwrap_or_else(|| vec!["upward".to_owned(), "downward".to_owned()]) {
        let start = Start::ALL
            .into_iter()
            .find(|start| start.to_string() == word);
        let start = start.ok_or_else(|| {
            let message = format!("starts: `{word}` is not a choice; give fresh, upward, downward");
            input(py, &message)
        })?;
        if !chosen.contains(&start) {
            chosen.push(start);
        }
    }
    let plan = SweepPlan {
        scene: scene.load(py, None)?,
        axes,
        starts: chosen,
        response: response(py, [min_transient, max_transient, measure], exponents)?,
    };
    if plan.is_empty() {
        return Err(input(py, "values, starts: there is no point to compute"));
    }
    let (number, of) = shard;
    if !(1..=of).contains(&number) {
        return Err(input(
            py,
            "shard: give the number of the part from 1, and the number of parts",
        ));
    }
    let shard = Shard { number, of };
    let found = points(py, &plan, shard, threads, progress.as_ref())?;
    result(py, &SweepResult::new(&plan, &found, shard, false))
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
    kicks: u32,
    seed: u32,
    min_transient: f64,
    max_transient: f64,
    measure: f64,
    exponents: usize,
    threads: Option<NonZero<usize>>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let seeds = (0..kicks).map(|k| f64::from(seed) + f64::from(k));
    let plan = SweepPlan {
        scene: scene.load(py, None)?,
        axes: vec![Axis::new(named(py, "start.seed")?, seeds)],
        starts: vec![Start::Fresh],
        response: response(py, [min_transient, max_transient, measure], exponents)?,
    };
    let found = points(py, &plan, Shard::WHOLE, threads, progress.as_ref())?;
    result(py, &Basins::new(&plan, &found, false))
}

/// Compute Lyapunov exponents with 95 % intervals, and classify the attractor.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path. It runs to its end first.
/// exponents : int, optional
///     Number of largest exponents. By default all.
/// average_time : float, optional
///     Averaging time, s. By default until the attractor is classified.
/// half_width : float, optional
///     Average until the interval of every exponent has at most this half-width, 1/s.
/// settle : float, optional
///     Time for the tangent vectors to align, s. By default 100 periods of the slowest mode.
/// tolerance : float, optional
///     Relative tolerance of a step.
/// duration : float, optional
///     Time of the run before, s. By default that of the scene.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``exponents_per_s``, the Kaplan-Yorke dimension, the running averages.
#[pyfunction]
#[pyo3(signature = (scene, exponents=None, *, average_time=None, half_width=None, settle=None, tolerance=None,
    duration=None, progress=None))]
pub fn lyapunov<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    exponents: Option<NonZero<usize>>,
    average_time: Option<f64>,
    half_width: Option<f64>,
    settle: Option<f64>,
    tolerance: Option<f64>,
    duration: Option<f64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let request = LyapunovRequest {
        count: exponents.map_or(ExponentCount::All, |count| {
            ExponentCount::Largest(count.get())
        }),
        settle,
        goal: match (average_time, half_width) {
            (Some(_), Some(_)) => {
                return Err(input(py, "give one of average_time and half_width"));
            }
            (Some(time), None) => Goal::Time(time),
            (None, Some(half_width)) => Goal::HalfWidth(half_width),
            (None, None) => Goal::Classification,
        },
        tolerance,
    };
    let scene = scene.load(py, duration)?;
    let found = long_call(py, progress.as_ref(), |watch| {
        scene_lyapunov(&scene, &request, &mut |progress| {
            watch.report(progress.share)
        })
    })?;
    let attractor = found.study.attractor().to_string();
    crate::array::result_with(py, &found, [("attractor", attractor)])
}

/// Measure accuracy against CPU time, and find the cheapest settings.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// settings : sequence of str, optional
///     Settings to vary, such as "integrator" or "budget". By default all.
/// repeats : int
///     Number of repeats of each timed run.
/// targets : sequence of float, optional
///     Total relative errors for which the error budget chooses settings.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``sets`` of points of error and time, ``advice``, ``budget``.
#[pyfunction]
#[pyo3(signature = (scene, *, settings=None, repeats=5, targets=None, progress=None))]
pub fn cost<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    settings: Option<Vec<String>>,
    repeats: usize,
    targets: Option<Vec<f64>>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut plan = CostPlan::new(scene.load(py, None)?);
    if let Some(words) = settings {
        let all: Vec<&str> = plan.settings.iter().map(|setting| setting.name()).collect();
        let chosen = words.iter().map(|word| choice(py, "settings", word, &all));
        let chosen = chosen.collect::<PyResult<Vec<_>>>()?;
        plan.settings.retain(|setting| chosen.contains(setting));
    }
    plan.repeats = repeats.max(1);
    plan.targets = targets.unwrap_or(plan.targets);
    let found = long_call(py, progress.as_ref(), |watch| {
        cost_study::cost(&plan, &mut |(_, share)| watch.report(share))
    })?;
    result(py, &found)
}
