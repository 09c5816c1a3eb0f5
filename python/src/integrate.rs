//! Integration of systems whose equations are Python functions, and their Lyapunov exponents.

use std::convert::Infallible;
use std::num::NonZero;
use std::sync::{Arc, Mutex};

use numpy::{AllowTypeChange, PyArray1, PyArrayLikeDyn};
use pyo3::prelude::*;
use squeakscope::dynamics::{Accuracy, DynamicsError, Integrator, Method, MethodName};
use squeakscope::study::lyapunov::{Goal, LyapunovPlan, lyapunov};

use crate::array::{SignalArray, array, fields, matrix, result_with, samples};
use crate::call::long_call;
use crate::error::input;
use crate::result::result;
use crate::signal::choice;
use crate::system::{Guards, PySystem};

/// The functions of a system, as the caller gives them.
struct Functions {
    rhs: Py<PyAny>,
    jacobian: Option<Py<PyAny>>,
    events: Option<Py<PyAny>>,
    reset: Option<Py<PyAny>>,
}

/// A system with an integrator that has started.
fn start(
    py: Python<'_>,
    functions: Functions,
    (t, z): (f64, &[f64]),
    (method, tolerance, max_step): (&str, f64, f64),
    autonomous: bool,
) -> PyResult<(PySystem, Integrator)> {
    let Functions {
        rhs,
        jacobian,
        events,
        reset,
    } = functions;
    let guards = match events {
        None => None,
        Some(function) => {
            let found = function.bind(py).call1((t, PyArray1::from_slice(py, z)))?;
            let found: PyArrayLikeDyn<'_, f64, AllowTypeChange> = found.extract()?;
            let count = found.as_array().len();
            Some(Guards {
                function,
                count,
                reset,
            })
        }
    };
    let system = PySystem {
        dim: z.len(),
        rhs,
        jacobian,
        guards,
        autonomous,
        fault: Mutex::new(None),
    };
    let names = MethodName::ALL.iter().map(|name| name.name());
    let names: Vec<&str> = names.filter(|name| !name.starts_with("lawson")).collect();
    let name: MethodName = choice(py, "method", method, &names)?;
    let method: Method = name.with(Accuracy::relative(tolerance), max_step);
    let started = py.detach(|| {
        let mut integrator = Integrator::new(method, &system)?;
        if system.guards.is_some() {
            integrator = integrator.with_events(&system)?;
        }
        integrator.start(&system, t, z)?;
        Ok(integrator)
    });
    let integrator = system.finish(py, started)?;
    Ok((system, integrator))
}

/// Integrate a system of equations ``dz/dt = rhs(t, z)`` with the integrators of the library.
///
/// Parameters
/// ----------
/// rhs : callable
///     ``rhs(t, z) -> dz/dt``, arrays of shape (n,). With events it is ``rhs(t, z, signs)``: the sign of each
///     guard, -1 or 1, is constant during a step, so that each piece of the law is smooth.
/// z0 : array_like
///     State at the first time, shape (n,).
/// t : array_like
///     Ascending times of the samples, the first of which is the start.
/// method : {"dop853", "tsit5", "rodas5p", "rk4", "auto"}
///     Method; "rodas5p" for stiff systems.
/// tolerance : float
///     Relative error tolerance of a step.
/// max_step : float, optional
///     Largest step; the step of "rk4". By default the whole interval.
/// events : callable, optional
///     ``events(t, z) -> guards``. The zeros of the guards are located.
/// reset : callable, optional
///     ``reset(t, z, guard) -> z`` at a guard that falls through zero; it must bring the guard to zero or above.
///     Without it, zeros in both directions are events, and the state is continuous.
/// jacobian : callable, optional
///     ``jacobian(t, z) -> matrix`` of shape (n, n), with the signs as third argument if there are events. By
///     default from differences.
/// autonomous : bool
///     Whether the law is independent of time.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``t``, ``z`` of shape (times, n), ``event_t``, ``event_index``, ``event_z``, and the statistics of the
///     solver.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> import squeakscope as s
/// >>> found = s.integrate(lambda t, z: [z[1], -z[0]], [1.0, 0.0], np.linspace(0, np.pi, 11))
/// >>> round(float(found.z[-1, 0]), 6)
/// -1.0
#[pyfunction]
#[pyo3(signature = (rhs, z0, t, *, method="dop853", tolerance=1e-8, max_step=None, events=None, reset=None,
    jacobian=None, autonomous=true, progress=None))]
pub fn integrate<'py>(
    py: Python<'py>,
    rhs: Py<PyAny>,
    z0: SignalArray<'py>,
    t: SignalArray<'py>,
    method: &str,
    tolerance: f64,
    max_step: Option<f64>,
    events: Option<Py<PyAny>>,
    reset: Option<Py<PyAny>>,
    jacobian: Option<Py<PyAny>>,
    autonomous: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let times = samples(py, &t)?.into_owned();
    let (Some(&from), Some(&to)) = (times.first(), times.last()) else {
        return Err(input(py, "t: give at least two times"));
    };
    if times.len() < 2 || !times.is_sorted_by(|a, b| a < b) {
        return Err(input(py, "t: give at least two times in ascending order"));
    }
    let state = samples(py, &z0)?.into_owned();
    let functions = Functions {
        rhs,
        jacobian,
        events,
        reset,
    };
    let settings = (method, tolerance, max_step.unwrap_or(to - from));
    let (system, mut integrator) = start(py, functions, (from, &state), settings, autonomous)?;
    let dim = state.len();
    let done = long_call(py, progress.as_ref(), |watch| {
        integrator.set_stop_flag(Arc::clone(&watch.stop));
        let (mut states, mut found) = (state, Vec::new());
        states.reserve(dim * times.len());
        let mut row = vec![0.0; dim];
        let mut sample = || {
            for &time in &times[1..] {
                // Earlier times than an event cannot be sampled after it.
                while system.guards.is_some() && integrator.time() < time {
                    let crossed = integrator.next_event(&system, time)?.to_vec();
                    let (at, z) = (integrator.time(), integrator.state());
                    found.extend(crossed.into_iter().map(|guard| (at, guard, z.to_vec())));
                }
                integrator.sample(&system, time, &mut row)?;
                states.extend_from_slice(&row);
                watch.report((time - from) / (to - from));
            }
            Ok::<_, DynamicsError>(integrator.stats())
        };
        let stats = sample();
        Ok::<_, Infallible>(stats.map(|stats| (states, found, stats)))
    })?;
    let (states, events, stats) = system.finish(py, done)?;
    let event_z: Vec<f64> = events
        .iter()
        .flat_map(|(.., z)| z.iter().copied())
        .collect();
    let found = [
        ("t", array(py, times)),
        ("z", matrix(py, states, dim)?),
        (
            "event_t",
            array(py, events.iter().map(|event| event.0).collect::<Vec<f64>>()),
        ),
        (
            "event_index",
            array(
                py,
                events
                    .iter()
                    .map(|event| event.1 as u64)
                    .collect::<Vec<u64>>(),
            ),
        ),
        ("event_z", matrix(py, event_z, dim)?),
        ("stats", result(py, &stats)?),
    ];
    fields(py, found)
}

/// Lyapunov exponents of a system of equations ``dz/dt = rhs(t, z)``, with 95 % intervals.
///
/// Parameters
/// ----------
/// rhs, z0 : callable, array_like
///     As for :func:`integrate`; the start is at time 0.
/// time : float
///     Averaging time.
/// settle : float
///     Time before, in which the transient decays and the tangent vectors align.
/// interval : float
///     Interval of the samples of the state; a fraction of a period.
/// exponents : int, optional
///     Number of largest exponents. By default all.
/// seed : int
///     Seed of the first tangent vectors.
/// method, tolerance, max_step, events, reset, jacobian, autonomous, progress : optional
///     As for :func:`integrate`.
///
/// Returns
/// -------
/// Result
///     ``exponents_per_s`` with their half-widths, ``attractor``, the Kaplan-Yorke dimension.
#[pyfunction]
#[pyo3(signature = (rhs, z0, time, *, settle, interval, exponents=None, seed=1, method="dop853", tolerance=1e-8,
    max_step=None, events=None, reset=None, jacobian=None, autonomous=true, progress=None))]
pub fn exponents<'py>(
    py: Python<'py>,
    rhs: Py<PyAny>,
    z0: SignalArray<'py>,
    time: f64,
    settle: f64,
    interval: f64,
    exponents: Option<NonZero<usize>>,
    seed: u64,
    method: &str,
    tolerance: f64,
    max_step: Option<f64>,
    events: Option<Py<PyAny>>,
    reset: Option<Py<PyAny>>,
    jacobian: Option<Py<PyAny>>,
    autonomous: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    if ![time, settle, interval]
        .iter()
        .all(|x| *x > 0.0 && x.is_finite())
    {
        return Err(input(
            py,
            "time, settle, interval: give finite times above 0",
        ));
    }
    let state = samples(py, &z0)?.into_owned();
    let functions = Functions {
        rhs,
        jacobian,
        events,
        reset,
    };
    let settings = (method, tolerance, max_step.unwrap_or(time));
    let (system, integrator) = start(py, functions, (0.0, &state), settings, autonomous)?;
    let width = exponents.map_or(state.len(), |count| count.get().min(state.len()));
    let plan = LyapunovPlan {
        settle,
        goal: Goal::Time(time),
        min_time: time,
        max_time: time,
        sample_interval: interval,
    };
    let done = long_call(py, progress.as_ref(), |watch| {
        let averaged = integrator
            .with_tangents(&system, width, seed)
            .and_then(|mut integrator| {
                integrator.start(&system, 0.0, &state)?;
                lyapunov(&system, &mut integrator, &plan, &mut |p| {
                    watch.report(p.share)
                })
            });
        Ok::<_, Infallible>(averaged)
    })?;
    let found = system.finish(py, done)?;
    let attractor = found.attractor().to_string();
    result_with(py, &found, [("attractor", attractor)])
}
