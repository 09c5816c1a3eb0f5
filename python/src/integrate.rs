//! Integration of systems whose equations are functions of the caller, and their Lyapunov exponents.

use std::sync::Arc;

use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use squeakscope::dynamics::{Accuracy, DynamicsError, Integrator, MethodName, SolverStats};
use squeakscope::study::lyapunov::{Goal, LyapunovPlan, lyapunov};

use crate::array::{check_names, choice, numeric, optional, options, positive, vector, whole};
use crate::error::input;
use crate::result::Fields;
use crate::schema::{Integration, OwnExponents};
use crate::system::{Calls, Law, OwnSystem};

options! {
    /// Functions of a system beside its right-hand side, and how it is integrated.
    Options {
        method: String = "dop853".to_owned(),
        tolerance: f64 = 1e-8,
        max_step: Option<f64> = None,
        events: Option<Py<PyAny>> = None,
        reset: Option<Py<PyAny>> = None,
        max_crossings: i64 = 1000,
        jacobian: Option<Py<PyAny>> = None,
        autonomous: Option<bool> = None,
    }
}

/// A system of equations ``dz/dt = rhs(t, z)`` for studies over parameters: :func:`sweep`, :func:`basins` and
/// :func:`branch` take a function of the parameters that returns it.
///
/// Parameters
/// ----------
/// rhs, z0 : callable, array_like
///     As for :func:`integrate`; the start is at time 0.
/// period : float
///     Period of the drive, or about the period of the motion of an autonomous system. It sets the time scale of
///     studies: 48 samples a period, and times that settle and measure by default.
/// method, tolerance, max_step, events, reset, max_crossings, jacobian, autonomous : optional
///     As for :func:`integrate`. The largest step is a twentieth of the period by default.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> import squeakscope as s
/// >>> def duffing(drive):
/// ...     return s.System(lambda t, z: [z[1], -0.3 * z[1] + z[0] - z[0]**3 + drive * np.cos(1.2 * t)], [1, 0], 2 * np.pi / 1.2)
/// >>> found = s.branch(duffing, "drive", (0.2, 0.3))
/// >>> [(point.kind, round(point["drive"], 4)) for point in found.bifurcations][0]
/// ('period-doubling', 0.2656)
#[pyclass(frozen, module = "squeakscope")]
pub struct System {
    rhs: Py<PyAny>,
    pub z0: Vec<f64>,
    pub period: f64,
    pub options: Options,
}

#[pymethods]
impl System {
    #[new]
    #[pyo3(signature = (rhs, z0, period, **options), text_signature = "(rhs, z0, period, *, method='dop853', \
        tolerance=1e-8, max_step=None, events=None, reset=None, max_crossings=1000, jacobian=None, autonomous=None)")]
    fn new(
        rhs: Py<PyAny>,
        z0: &Bound<'_, PyAny>,
        period: f64,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        check_names(options, &[Options::NAMES])?;
        Ok(Self {
            rhs,
            z0: vector("z0", z0)?.as_slice()?.to_vec(),
            period: positive("period", period)?,
            options: Options::of(options)?,
        })
    }
}

impl System {
    /// The system, and its integrator at the start of a time span. A step has at most `max_step` if the caller gives no other,
    /// and more crossings than permitted within a `window` are an error.
    pub fn start(
        &self,
        py: Python<'_>,
        calls: Arc<Calls>,
        (t, span): (f64, f64),
        (window, max_step): (f64, Option<f64>),
    ) -> PyResult<(Arc<OwnSystem>, Integrator<'static>)> {
        let (options, z) = (&self.options, &self.z0[..]);
        let law = |name, function: &Option<Py<PyAny>>| {
            let function = function.as_ref();
            function
                .map(|function| Law::new(name, function.bind(py)))
                .transpose()
        };
        let mut system = OwnSystem {
            rhs: Law::new("rhs", self.rhs.bind(py))?,
            jacobian: law("jacobian", &options.jacobian)?,
            events: law("events", &options.events)?,
            reset: law("reset", &options.reset)?,
            dim: z.len(),
            guards: 0,
            autonomous: false,
            calls: Arc::default(),
        };
        match (&system.events, &system.reset, &system.rhs) {
            (None, Some(_), _) => {
                return Err(input("reset: give `events`, too; it acts at their zeros"));
            }
            (Some(Law::Compiled { .. }), ..) | (_, Some(Law::Compiled { .. }), _) => {
                return Err(input(
                    "events, reset: give Python functions; only rhs and jacobian are compiled",
                ));
            }
            (Some(_), _, Law::Compiled { .. }) => {
                return Err(input(
                    "rhs: a compiled function has no signs; give a Python function beside `events`",
                ));
            }
            (Some(Law::Python(events)), ..) => {
                let found = events
                    .bind(py)
                    .call1((t, numpy::PyArray1::from_slice(py, z)))?;
                system.guards = numeric("events", &found)?.len();
            }
            _ => {}
        }
        let depends = options.autonomous != Some(false) && system.depends_on_time((t, span), z);
        if depends && options.autonomous == Some(true) {
            return Err(input(
                "autonomous: a function changes with time; omit the argument, or give False",
            ));
        }
        system.autonomous = options.autonomous.unwrap_or(!depends);
        system.calls = calls;
        let names = MethodName::ALL.iter().map(|name| (name.name(), *name));
        let names: Vec<_> = names
            .filter(|(name, _)| !name.starts_with("lawson"))
            .collect();
        let name = choice("method", &options.method, &names)?;
        let max_step = options.max_step.or(max_step);
        if name.has_fixed_step() && max_step.is_none() {
            return Err(input(format!(
                "max_step: give the step of {}, which is constant",
                options.method
            )));
        }
        let max_step = positive("max_step", max_step.unwrap_or(span))?;
        let method = name.with(Accuracy::relative(options.tolerance), max_step);
        let crossings = whole("max_crossings", options.max_crossings, 1)?;
        let system = Arc::new(system);
        let start = || {
            let mut integrator = Integrator::new(method, Arc::clone(&system))?;
            if system.guards > 0 {
                integrator = integrator
                    .with_events()?
                    .with_crossing_limit(crossings, window);
            }
            integrator.set_stop_flag(Arc::clone(&system.calls.watch.stop));
            integrator.start(t, z)?;
            Ok(integrator)
        };
        let started = system.run(py, start);
        let integrator = system.finish(started)?;
        Ok((system, integrator))
    }
}

/// One value for all guards, or one for each.
#[derive(FromPyObject)]
pub enum PerGuard<T> {
    One(T),
    Each(Vec<T>),
}

impl<T: Copy> PerGuard<T> {
    fn all(self, name: &str, guards: usize) -> PyResult<Vec<T>> {
        match self {
            Self::One(value) => Ok(vec![value; guards]),
            Self::Each(values) if values.len() == guards => Ok(values),
            Self::Each(values) => {
                let count = values.len();
                Err(input(format!(
                    "{name}: give one value, or {guards} for the guards, not {count}"
                )))
            }
        }
    }
}

/// What an integration has computed so far.
#[derive(Default)]
struct Found {
    states: Vec<f64>,
    event_t: Vec<f64>,
    event_index: Vec<u64>,
    event_z: Vec<f64>,
    stats: SolverStats,
}

impl Found {
    fn answer<'py>(
        self,
        py: Python<'py>,
        times: &[f64],
        system: &OwnSystem,
    ) -> PyResult<Bound<'py, PyAny>> {
        let dim = system.dim;
        Fields::new(py)
            .array("t", times[..self.states.len() / dim].to_vec())?
            .matrix("z", self.states, dim)?
            .array("event_t", self.event_t)?
            .array("event_index", self.event_index)?
            .matrix("event_z", self.event_z, dim)?
            .serialised("stats", &self.stats)?
            .with("calls", system.calls.count())?
            .finish::<Integration>()
    }
}

/// Integrate a system of equations ``dz/dt = rhs(t, z)`` with the integrators of the library.
///
/// Where the law jumps at a zero of ``events``, and the laws of both sides lead to it, the motion stays there, with the
/// combination of both that keeps it there (Filippov): dry friction sticks.
///
/// Parameters
/// ----------
/// rhs : callable
///     ``rhs(t, z) -> dz/dt``, arrays of shape (n,). With events it is ``rhs(t, z, signs)``: the sign of each
///     guard, -1 or 1, is constant during a step, so that each piece of the law is smooth. Without events it may be
///     compiled by ``numba.cfunc`` for ``(t, z, out)`` with pointers, which is called without Python.
/// z0 : array_like
///     State at the first time, shape (n,).
/// t : array_like
///     Ascending times of the samples, the first of which is the start.
/// method : {"dop853", "tsit5", "rodas5p", "rk4", "auto"}
///     Method; "rodas5p" for stiff systems.
/// tolerance : float
///     Relative error tolerance of a step.
/// max_step : float, optional
///     Largest step, by default the whole interval. "rk4" needs it: it is its step.
/// events : callable, optional
///     ``events(t, z) -> guards``. The zeros of the guards are located.
/// reset : callable, optional
///     ``reset(t, z, guard) -> z`` at a guard that falls through zero; it must bring the guard to zero or above. None
///     leaves the state and changes the sign of the guard, as without a reset.
/// terminal : bool or sequence of bool, optional
///     Whether the integration ends at an event, for all guards or for each.
/// direction : int or sequence of int, optional
///     Events that are reported, for all guards or for each: 1 for a guard that rises, -1 for one that falls, 0 for both,
///     which is the default.
/// max_crossings : int
///     Crossings within a thousandth of the interval that are permitted; more are an error.
/// jacobian : callable, optional
///     ``jacobian(t, z) -> matrix`` of shape (n, n), with the signs as third argument if there are events; compiled as
///     ``rhs``. By default from differences.
/// autonomous : bool, optional
///     Whether nothing depends on time. By default the functions are compared at several times.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     ``t``, ``z`` of shape (times, n), ``event_t``, ``event_index`` of the guard, ``event_z`` after the reset, the
///     statistics of the solver, and the number of ``calls`` of the functions. After a terminal event the samples until
///     then.
///
/// Raises
/// ------
/// InputError
///     If an argument is not valid.
/// Error
///     If the integration cannot continue; ``error.result`` has what was computed until then.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> import squeakscope as s
/// >>> found = s.integrate(lambda t, z: [z[1], -z[0]], [1.0, 0.0], np.linspace(0, np.pi, 11))
/// >>> round(float(found.z[-1, 0]), 6)
/// -1.0
#[pyfunction]
#[pyo3(signature = (rhs, z0, t, *, terminal=None, direction=None, progress=None, **options), text_signature = "(rhs, z0, t, *, \
    method='dop853', tolerance=1e-8, max_step=None, events=None, reset=None, terminal=None, direction=None, \
    max_crossings=1000, jacobian=None, autonomous=None, progress=None)")]
pub fn integrate<'py>(
    py: Python<'py>,
    rhs: Py<PyAny>,
    z0: Bound<'py, PyAny>,
    t: Bound<'py, PyAny>,
    terminal: Option<PerGuard<bool>>,
    direction: Option<PerGuard<i8>>,
    progress: Option<Py<PyAny>>,
    options: Option<Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let times = vector("t", &t)?;
    let times = times.as_slice()?;
    let (from, to) = match times {
        [from, .., to] if times.is_sorted_by(|a, b| a < b) => (*from, *to),
        _ => return Err(input("t: give at least two times in ascending order")),
    };
    let definition = System::new(rhs, &z0, 1.0, options.as_ref())?;
    let (calls, span) = (Arc::new(Calls::new(progress)), to - from);
    let (system, mut integrator) =
        definition.start(py, calls, (from, span), (1e-3 * span, None))?;
    let terminal = terminal
        .unwrap_or(PerGuard::One(false))
        .all("terminal", system.guards)?;
    let directions = direction
        .unwrap_or(PerGuard::One(0))
        .all("direction", system.guards)?;
    let mut found = Found {
        states: definition.z0.clone(),
        ..Found::default()
    };
    let mut row = vec![0.0; system.dim];
    let mut sample = || {
        for &time in &times[1..] {
            // Earlier times than an event cannot be sampled after it.
            while system.guards > 0 && integrator.time() < time {
                let before = integrator.status().to_vec();
                let crossed = integrator.next_event(time)?.to_vec();
                for guard in crossed {
                    let (guard, direction) = system.event(guard, &before);
                    if [0, direction].contains(&directions[guard]) {
                        found.event_t.push(integrator.time());
                        found.event_index.push(guard as u64);
                        found.event_z.extend_from_slice(integrator.state());
                        if terminal[guard] {
                            return Ok(());
                        }
                    }
                }
            }
            integrator.sample(time, &mut row)?;
            found.states.extend_from_slice(&row);
            system.calls.watch.show((time - from) / (to - from));
        }
        Ok::<_, DynamicsError>(())
    };
    let done = system.run(py, &mut sample);
    found.stats = integrator.stats();
    match system.finish(done) {
        Ok(()) => found.answer(py, times, &system),
        Err(error) => {
            let value = error.value(py);
            if value.hasattr("result")? {
                value.setattr("result", found.answer(py, times, &system)?)?;
            }
            Err(error)
        }
    }
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
/// max_step : float, optional
///     Largest step. By default the interval of the samples: without a motion nothing else limits a step.
/// method, tolerance, events, reset, jacobian, autonomous, progress : optional
///     As for :func:`integrate`.
/// max_crossings : int
///     Crossings within an interval of the samples that are permitted; more are an error.
///
/// Returns
/// -------
/// Result
///     ``exponents`` with the half-widths of their 95 % intervals, per unit of time, their ``signs``, the ``attractor``
///     and its ``description``, their ``sum``, the Kaplan-Yorke dimension ``kaplan_yorke``, None for an equilibrium and
///     where a sign is open, ``warnings``, and the number of ``calls`` of the functions.
///
/// Examples
/// --------
/// >>> import squeakscope as s
/// >>> found = s.exponents(lambda t, z: [-z[0], -2 * z[1]], [1.0, 1.0], 50.0, settle=20.0, interval=0.1)
/// >>> found.exponents.round(3).tolist()
/// [-1.0, -2.0]
#[pyfunction]
#[pyo3(signature = (rhs, z0, time, *, settle, interval, exponents=None, seed=1, progress=None, **options),
    text_signature = "(rhs, z0, time, *, settle, interval, exponents=None, seed=1, method='dop853', tolerance=1e-8, \
    max_step=None, events=None, reset=None, max_crossings=1000, jacobian=None, autonomous=None, progress=None)")]
pub fn exponents<'py>(
    py: Python<'py>,
    rhs: Py<PyAny>,
    z0: Bound<'py, PyAny>,
    time: f64,
    settle: f64,
    interval: f64,
    exponents: Option<i64>,
    seed: i64,
    progress: Option<Py<PyAny>>,
    options: Option<Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let plan = LyapunovPlan {
        settle: positive("settle", settle)?,
        goal: Goal::Time(positive("time", time)?),
        min_time: time,
        max_time: time,
        sample_interval: positive("interval", interval)?,
        constant_since: 0.0,
    };
    let definition = System::new(rhs, &z0, 1.0, options.as_ref())?;
    let (calls, state) = (Arc::new(Calls::new(progress)), &definition.z0[..]);
    let (system, integrator) =
        definition.start(py, calls, (0.0, time), (interval, Some(interval)))?;
    let width =
        optional("exponents", exponents, 1)?.map_or(state.len(), |count| count.min(state.len()));
    let seed = whole("seed", seed, 0)? as u64;
    let done = system.run(py, || {
        let mut integrator = integrator.with_tangents(width, seed)?;
        integrator.start(0.0, state)?;
        lyapunov(&mut integrator, &plan, &mut |share, _| {
            system.calls.watch.report(share)
        })
    });
    let found = system.finish(done)?;
    Fields::of(py, &found)?
        .with("calls", system.calls.count())?
        .timed::<OwnExponents>(None)
}
