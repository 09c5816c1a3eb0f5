//! Systems whose equations are Python functions, in the integrators of the library.

use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{AllowTypeChange, PyArray1, PyArrayLikeDyn};
use pyo3::prelude::*;
use squeakscope::dynamics::{
    Accuracy, Differentiable, DynamicsError, Integrator, Method, MethodName, Switching, System,
};
use squeakscope::study::lyapunov::{Goal, LyapunovPlan, lyapunov};

use crate::array::{array, fields, matrix, result_with};
use crate::call::long_call;
use crate::error::input;
use crate::result::result;
use crate::signal::choice;

/// Step of a central difference relative to the size of the state: the cube root of the rounding error.
const STEP: f64 = 6e-6;

/// A system with Python functions.
struct PySystem {
    dim: usize,
    rhs: Py<PyAny>,
    jacobian: Option<Py<PyAny>>,
    guards: Option<Guards>,
    autonomous: bool,
    /// The first exception of a function; all values are NaN from then on, which ends the integration.
    fault: Mutex<Option<PyErr>>,
}

/// The guards of a piecewise smooth system.
struct Guards {
    function: Py<PyAny>,
    count: usize,
    reset: Option<Py<PyAny>>,
}

impl PySystem {
    fn fault(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls a function with `(t, z)` and, in a system with guards, with their signs; writes its numbers to `out`.
    fn call(
        &self,
        function: &Py<PyAny>,
        status: Option<&[u8]>,
        t: f64,
        z: &[f64],
        out: &mut [f64],
    ) {
        if self.fault().is_some() {
            out.fill(f64::NAN);
            return;
        }
        let called = Python::attach(|py| {
            let z = PyArray1::from_slice(py, z);
            let found = match status {
                None => function.bind(py).call1((t, z))?,
                Some(status) => {
                    let signs = status.iter().map(|sign| *sign as i8);
                    let signs = PyArray1::from_vec(py, signs.collect());
                    function.bind(py).call1((t, z, signs))?
                }
            };
            write(&found, out)
        });
        if let Err(error) = called {
            out.fill(f64::NAN);
            *self.fault() = Some(error);
        }
    }

    /// Central differences of `function` along `vector` at `z`, added to nothing: written to `out`.
    fn difference(
        &self,
        z: &[f64],
        vector: &[f64],
        out: &mut [f64],
        mut at: impl FnMut(&[f64], &mut [f64]),
    ) {
        let norm = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let length = norm(vector);
        if length == 0.0 {
            return out.fill(0.0);
        }
        let step = STEP * norm(z).max(1e-3) / length;
        let moved =
            |by: f64| -> Vec<f64> { z.iter().zip(vector).map(|(z, v)| z + by * v).collect() };
        let mut below = vec![0.0; out.len()];
        at(&moved(step), out);
        at(&moved(-step), &mut below);
        for (out, below) in out.iter_mut().zip(below) {
            *out = (*out - below) / (2.0 * step);
        }
    }

    /// The result of an integration, or the exception of a function that ended it.
    fn finish<T>(&self, done: Result<T, DynamicsError>) -> Result<T, Failure> {
        match self.fault().take() {
            Some(error) => Err(Failure::Python(error)),
            None => done.map_err(Failure::Library),
        }
    }
}

/// Writes the numbers of an array.
fn write(found: &Bound<'_, PyAny>, out: &mut [f64]) -> PyResult<()> {
    let found: PyArrayLikeDyn<'_, f64, AllowTypeChange> = found.extract()?;
    let found = found.as_array();
    if found.len() != out.len() {
        let message = format!(
            "a function returned {} numbers; it must return {}",
            found.len(),
            out.len()
        );
        return Python::attach(|py| Err(input(py, &message)));
    }
    out.iter_mut()
        .zip(found.iter())
        .for_each(|(out, x)| *out = *x);
    Ok(())
}

/// Why an integration failed.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error("a function raised an exception")]
    Python(#[source] PyErr),
    #[error(transparent)]
    Library(#[from] DynamicsError),
}

impl System for PySystem {
    fn omega(&self) -> &[f64] {
        &[]
    }

    fn first_order(&self) -> usize {
        self.dim
    }

    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        let status = self.guards.as_ref().map(|_| {
            let mut status = vec![0; self.status_len()];
            self.status_of(t, z, &mut status);
            status
        });
        self.call(&self.rhs, status.as_deref(), t, z, out);
    }

    fn switching(&self) -> Option<&dyn Switching> {
        self.guards.as_ref().map(|_| self as &dyn Switching)
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        self.autonomous
    }
}

impl Differentiable for PySystem {
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let (t, z) = (record[0], &record[1..]);
        let dim = self.dim;
        let column = |l: usize| -> Vec<f64> { (0..dim).map(|c| vectors[c * width + l]).collect() };
        if let Some(jacobian) = &self.jacobian {
            let mut matrix = vec![0.0; dim * dim];
            self.call(jacobian, status, t, z, &mut matrix);
            for l in 0..width {
                let vector = column(l);
                for (c, row) in matrix.chunks(dim).enumerate() {
                    out[c * width + l] = row.iter().zip(&vector).map(|(a, v)| a * v).sum();
                }
            }
            return;
        }
        let mut derivative = vec![0.0; dim];
        for l in 0..width {
            self.difference(z, &column(l), &mut derivative, |z, out| {
                self.call(&self.rhs, status, t, z, out);
            });
            for (c, x) in derivative.iter().enumerate() {
                out[c * width + l] = *x;
            }
        }
    }

    fn time_derivative(&self, status: Option<&[u8]>, t: f64, z: &[f64], out: &mut [f64]) {
        if self.autonomous {
            return out.fill(0.0);
        }
        self.difference(&[t], &[1.0], out, |t, out| {
            self.call(&self.rhs, status, t[0], z, out)
        });
    }
}

/// A status is the sign of each guard, -1 or 1, as a byte.
impl Switching for PySystem {
    fn status_len(&self) -> usize {
        self.guards()
    }

    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        let mut values = vec![0.0; status.len()];
        self.raw_guards(t, z, &mut values);
        for (sign, value) in status.iter_mut().zip(values) {
            *sign = if value < 0.0 { -1_i8 } else { 1 } as u8;
        }
    }

    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        self.call(&self.rhs, Some(status), t, z, out);
    }

    fn guards(&self) -> usize {
        self.guards.as_ref().map_or(0, |guards| guards.count)
    }

    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]) {
        self.raw_guards(t, z, values);
        for (value, sign) in values.iter_mut().zip(status) {
            *value *= f64::from(*sign as i8);
        }
    }

    fn cross(&self, guard: usize, t: f64, z: &mut [f64], status: &mut [u8]) {
        match self.reset(t, z, guard) {
            Some(after) => z.copy_from_slice(&after),
            None => status[guard] = (status[guard] as i8).wrapping_neg() as u8,
        }
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        guard: usize,
        t: f64,
        z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let mut slope = vec![0.0; self.guards()];
        for (c, gradient) in gradient.iter_mut().enumerate() {
            let mut unit = vec![0.0; z.len()];
            unit[c] = 1.0;
            self.difference(z, &unit, &mut slope, |z, out| {
                self.guard_values(status, t, z, out)
            });
            *gradient = slope[guard];
        }
        self.difference(&[t], &[1.0], &mut slope, |t, out| {
            self.guard_values(status, t[0], z, out)
        });
        slope[guard]
    }

    fn reset_tangents(
        &self,
        _: &[u8],
        guard: usize,
        t: f64,
        z: &[f64],
        (vectors, width): (&mut [f64], usize),
    ) {
        if self
            .guards
            .as_ref()
            .is_none_or(|guards| guards.reset.is_none())
        {
            return;
        }
        let mut moved = vec![0.0; self.dim];
        for l in 0..width {
            let vector: Vec<f64> = (0..self.dim).map(|c| vectors[c * width + l]).collect();
            self.difference(z, &vector, &mut moved, |z, out| {
                if let Some(after) = self.reset(t, z, guard) {
                    out.copy_from_slice(&after);
                }
            });
            for (c, x) in moved.iter().enumerate() {
                vectors[c * width + l] = *x;
            }
        }
    }
}

impl PySystem {
    fn raw_guards(&self, t: f64, z: &[f64], values: &mut [f64]) {
        if let Some(guards) = &self.guards {
            self.call(&guards.function, None, t, z, values);
        }
    }

    /// The state after a reset; `None` without a reset.
    fn reset(&self, t: f64, z: &[f64], guard: usize) -> Option<Vec<f64>> {
        let reset = self.guards.as_ref()?.reset.as_ref()?;
        let mut after = z.to_vec();
        let called = Python::attach(|py| {
            let z = PyArray1::from_slice(py, z);
            write(&reset.bind(py).call1((t, z, guard))?, &mut after)
        });
        if let Err(error) = called {
            after.fill(f64::NAN);
            self.fault().get_or_insert(error);
        }
        Some(after)
    }
}

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
    let integrator = raised(py, system.finish(started))?;
    Ok((system, integrator))
}

/// The exception of a failure.
fn raised<T>(py: Python<'_>, done: Result<T, Failure>) -> PyResult<T> {
    done.map_err(|failure| match failure {
        Failure::Python(error) => error,
        Failure::Library(error) => crate::error::raise(py, &error),
    })
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
    z0: crate::array::SignalArray<'py>,
    t: crate::array::SignalArray<'py>,
    method: &str,
    tolerance: f64,
    max_step: Option<f64>,
    events: Option<Py<PyAny>>,
    reset: Option<Py<PyAny>>,
    jacobian: Option<Py<PyAny>>,
    autonomous: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let times = crate::array::samples(&t).into_owned();
    let (Some(&from), Some(&to)) = (times.first(), times.last()) else {
        return Err(input(py, "t: give at least two times"));
    };
    if times.len() < 2 || !times.is_sorted_by(|a, b| a < b) {
        return Err(input(py, "t: give at least two times in ascending order"));
    }
    let state = crate::array::samples(&z0).into_owned();
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
        integrator.set_stop_flag(std::sync::Arc::clone(&watch.stop));
        let (mut states, mut found) = (state, Vec::new());
        states.reserve(dim * times.len());
        let mut row = vec![0.0; dim];
        let sampled = (|| {
            for &time in &times[1..] {
                // Samples up to an event are taken before it, because its state may jump.
                while system.guards.is_some() && integrator.time() < time {
                    let crossed = integrator.next_event(&system, time)?.to_vec();
                    let (at, z) = (integrator.time(), integrator.state());
                    found.extend(crossed.into_iter().map(|guard| (at, guard, z.to_vec())));
                }
                integrator.sample(&system, time, &mut row)?;
                states.extend_from_slice(&row);
                watch.report((time - from) / (to - from));
            }
            Ok(integrator.stats())
        })();
        let finished = system.finish(sampled);
        Ok::<_, std::convert::Infallible>(finished.map(|stats| (states, found, stats)))
    })?;
    let (states, events, stats) = raised(py, done)?;
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
    z0: crate::array::SignalArray<'py>,
    time: f64,
    settle: f64,
    interval: f64,
    exponents: Option<std::num::NonZero<usize>>,
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
    let state = crate::array::samples(&z0).into_owned();
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
        Ok::<_, std::convert::Infallible>(system.finish(averaged))
    })?;
    let found = raised(py, done)?;
    let attractor = found.attractor().to_string();
    result_with(py, &found, [("attractor", attractor)])
}
