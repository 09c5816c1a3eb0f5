//! Studies of scenes: many simulations, or the linearised system.

use std::sync::Arc;

use pyo3::prelude::*;
use squeakscope::plot::{branch_figures, cost_figure, lyapunov_figure};
use squeakscope::study::branch::{self as branches, Branch, BranchPlan, OrbitStarts};
use squeakscope::study::cost as cost_study;
use squeakscope::study::lyapunov::{Goal, LyapunovRequest, scene_lyapunov};
use squeakscope::study::{StabilityResult, Subject};

use crate::array::{optional, vector, whole};
use crate::call::long_call;
use crate::error::{input, raise};
use crate::own::{OwnSystems, Studied};
use crate::result::{Fields, result};
use crate::scene::SceneOrName;
use crate::schema::SceneExponents;

/// Linear modes of steady sliding, from complex eigenvalues.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// tilts_deg : array_like, optional
///     Tilts of the load, degrees. By default those of the knots of the scene.
///
/// Returns
/// -------
/// Result
///     ``tilts``, each with its ``modes``, which have frequency and growth rate; ``unstable`` modes can squeak.
#[pyfunction]
#[pyo3(signature = (scene, tilts_deg=None))]
pub fn stability<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    tilts_deg: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.load(None)?;
    let tilts = match tilts_deg {
        Some(tilts) => vector("tilts_deg", &tilts)?.as_slice()?.to_vec(),
        None => scene.joint().map_err(|error| raise(&error))?.tilt.degrees(),
    };
    let found = long_call(py, None, |watch| {
        let progress = &mut |share: f64, _: &str| watch.report(share);
        StabilityResult::new(&scene, &tilts, [false; 2], progress)
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
    let scene = scene.load(None)?;
    let found = long_call(py, progress.as_ref(), |watch| {
        branches::sensitivities(&scene, &mut |share, _| watch.report(share))
    })?;
    result(py, &found)
}

/// Follow equilibria and periodic motions over a parameter.
///
/// Parameters
/// ----------
/// scene : Scene, str, os.PathLike or callable
///     The scene, or its name or path; or a function of the parameter that returns a :class:`System`.
/// parameter : str
///     Key of the parameter, or name of the argument.
/// interval : tuple of float, optional
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
///     ``equilibria``, ``points`` (periodic orbits) and ``bifurcations``. Those of own systems have no units in their names,
///     and amplitudes of the first component of the state.
#[pyfunction]
#[pyo3(signature = (scene, parameter="load.tilt_deg", interval=None, *, points=41, orbits=true, start=None,
    progress=None))]
pub fn branch<'py>(
    py: Python<'py>,
    scene: Studied,
    parameter: &str,
    interval: Option<(f64, f64)>,
    points: i64,
    orbits: bool,
    start: Option<f64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let own = matches!(scene, Studied::Systems(_));
    if own && (interval.is_none() || parameter.contains('.')) {
        return Err(input(
            "parameter, interval: give the name of an argument of the function, and its first and last value",
        ));
    }
    let (from, to) = interval.unwrap_or((0.0, 8.0));
    if from.partial_cmp(&to) != Some(std::cmp::Ordering::Less) {
        return Err(input(
            "interval: the first value must be less than the last",
        ));
    }
    let (interval, points) = ([from, to], whole("points", points, 2)?);
    let starts = orbits.then(|| start.map_or(OrbitStarts::Scene, OrbitStarts::At));
    let scene = match scene {
        Studied::Scene(scene) => scene.load(None)?,
        Studied::Systems(function) => {
            let systems = Arc::new(OwnSystems::new(py, function)?);
            let plan = BranchPlan {
                subject: Arc::clone(&systems) as Arc<dyn Subject>,
                parameter: parameter.to_owned(),
                unit: String::new(),
                own: None,
                interval,
                points,
            };
            let found = systems.call(py, progress.as_ref(), |watch| {
                plan.follow(starts, &mut |share, _| watch.report(share), &mut |_| ())
            })?;
            return Fields::of(py, &found)?
                .unitless(&[plan.parameter])?
                .finish::<Branch>();
        }
    };
    let parameter = scene.parameter(parameter).map_err(|error| raise(&error))?;
    let plan = BranchPlan::new(scene.clone(), parameter, interval, points);
    let found = long_call(py, progress.as_ref(), |watch| {
        for value in interval {
            scene.with_values(&[(parameter, value)])?;
        }
        plan.follow(starts, &mut |share, _| watch.report(share), &mut |_| ())
    })?;
    let fields = Fields::of(py, &found)?;
    let name = scene.name.clone();
    let figures = move || branch_figures(&name, &found);
    fields.drawn(figures)?.finish::<Branch>()
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
///     ``exponents_per_s`` with the half-widths of their intervals, their ``signs``, the ``attractor`` and its
///     ``description``, the Kaplan-Yorke dimension ``kaplan_yorke``, and the ``running`` averages.
#[pyfunction]
#[pyo3(signature = (scene, exponents=None, *, average_time=None, half_width=None, settle=None, tolerance=None,
    duration=None, progress=None))]
pub fn lyapunov<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    exponents: Option<i64>,
    average_time: Option<f64>,
    half_width: Option<f64>,
    settle: Option<f64>,
    tolerance: Option<f64>,
    duration: Option<f64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let request = LyapunovRequest {
        count: optional("exponents", exponents, 1)?,
        settle,
        goal: match (average_time, half_width) {
            (Some(_), Some(_)) => {
                return Err(input("give one of average_time and half_width"));
            }
            (Some(time), None) => Goal::Time(time),
            (None, Some(half_width)) => Goal::HalfWidth(half_width),
            (None, None) => Goal::Classification,
        },
        tolerance,
    };
    let scene = scene.load(duration)?;
    let found = long_call(py, progress.as_ref(), |watch| {
        scene_lyapunov(&scene, &request, &mut |share, _| watch.report(share))
    })?;
    Fields::of(py, &found)?
        .drawn(move || vec![lyapunov_figure(&scene.name, &found)])?
        .finish::<SceneExponents>()
}

/// Measure what accuracy and effects cost, and find the cheapest settings.
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
/// Result
///     ``settings`` with points of error and time, ``choices`` for total errors, ``effects`` with their prices.
#[pyfunction]
#[pyo3(signature = (scene, *, progress=None))]
pub fn cost<'py>(
    py: Python<'py>,
    scene: SceneOrName,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.load(None)?;
    let found = long_call(py, progress.as_ref(), |watch| {
        cost_study::cost(&scene, None, &mut |share, _| watch.report(share))
    })?;
    Fields::of(py, &found)?
        .drawn(move || vec![cost_figure(&scene.name, &found)])?
        .finish::<cost_study::Cost>()
}
