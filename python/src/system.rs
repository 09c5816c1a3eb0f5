//! Systems whose equations are functions of the caller, in the integrators of the library.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use squeakscope::dynamics::{Differentiable, DynamicsError, Switching, System, central_difference};

use crate::array::numeric;
use crate::call::{POLL, Watch, poll};
use crate::error::{failure, input, raise};
use crate::filippov::{ON, signs};

/// A law that is called by its address: `void law(double t, const double *z, double *out)`.
type Compiled = extern "C" fn(f64, *const f64, *mut f64);

/// A function of `(t, z)`.
pub enum Law {
    /// Called with arrays, and with the signs of the guards if there are any.
    Python(Py<PyAny>),
    /// Called by its address.
    Compiled {
        law: Compiled,
        /// Keeps the code of the address.
        owner: Py<PyAny>,
    },
}

impl Law {
    /// A Python function, or one compiled by `numba.cfunc`, which has an address.
    pub fn new(name: &str, function: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(address) = function.getattr("address") {
            let compiled = function.getattr("ctypes")?;
            let arguments: Vec<String> = compiled
                .getattr("argtypes")?
                .try_iter()?
                .map(|kind| kind?.getattr("__name__")?.extract())
                .collect::<PyResult<_>>()?;
            let pointers = |kind: &String| kind == "LP_c_double";
            let is_law = arguments.len() == 3
                && arguments[0] == "c_double"
                && arguments[1..].iter().all(pointers);
            if !is_law || !compiled.getattr("restype")?.is_none() {
                return Err(input(format!(
                    "{name}: compile it with cfunc(types.void(types.double, types.CPointer(types.double), \
                     types.CPointer(types.double))), for the time, the state and the result"
                )));
            }
            let address: usize = address.extract()?;
            #[allow(unsafe_code, reason = "a compiled function has only an address")]
            // SAFETY: numba gives the address of a function of the signature that was checked above.
            let law = unsafe { std::mem::transmute::<usize, Compiled>(address) };
            let owner = function.clone().unbind();
            return Ok(Self::Compiled { law, owner });
        }
        if !function.is_callable() {
            return Err(input(format!(
                "{name}: give one function, not {}; of several guards it returns all",
                function.get_type().name()?
            )));
        }
        Ok(Self::Python(function.clone().unbind()))
    }

    fn is_compiled(&self) -> bool {
        matches!(self, Self::Compiled { .. })
    }
}

/// A system with the functions of the caller.
pub struct OwnSystem {
    pub rhs: Law,
    pub jacobian: Option<Law>,
    pub events: Option<Law>,
    pub reset: Option<Law>,
    /// Number of components of the state.
    pub dim: usize,
    /// Number of guards that `events` returns.
    pub guards: usize,
    pub autonomous: bool,
    pub calls: Arc<Calls>,
}

/// The calls of the functions, and what ended them.
#[derive(Default)]
pub struct Calls {
    /// Its flag is set by the first exception. All values are NaN from then on, which ends the integration.
    pub watch: Watch,
    progress: Option<Py<PyAny>>,
    fault: Mutex<Option<PyErr>>,
    count: AtomicU64,
    polled: Mutex<Option<Instant>>,
}

impl Calls {
    /// With a function that is called with the share of the work that is done.
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        Self {
            progress,
            ..Self::default()
        }
    }

    /// Number of calls of functions.
    pub fn count(&self) -> u64 {
        self.count.load(Ordering::Relaxed)
    }

    fn fault(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn fail(&self, error: PyErr) {
        self.watch.stop.store(true, Ordering::Relaxed);
        self.fault().get_or_insert(error);
    }

    /// Takes the first exception.
    pub fn take_fault(&self) -> Option<PyErr> {
        self.fault().take()
    }

    /// Counts a call, and from time to time listens to Ctrl-C and reports the progress.
    fn begin(&self) {
        if !self
            .count
            .fetch_add(1, Ordering::Relaxed)
            .is_multiple_of(64)
        {
            return;
        }
        let mut polled = self.polled.lock().unwrap_or_else(PoisonError::into_inner);
        if polled.is_some_and(|last| last.elapsed() < POLL) {
            return;
        }
        *polled = Some(Instant::now());
        let polled = Python::attach(|py| {
            let progress = self.progress.as_ref().map(|function| function.bind(py));
            poll(py, progress, &self.watch)
        });
        if let Err(error) = polled {
            self.fail(error);
        }
    }
}

impl OwnSystem {
    /// Calls a function and writes its numbers to `out`: NaN after an exception.
    pub fn call(
        &self,
        (name, law): (&str, &Law),
        signs: Option<&[i8]>,
        t: f64,
        z: &[f64],
        out: &mut [f64],
    ) {
        self.calls.begin();
        if self.calls.watch.stop.load(Ordering::Relaxed) {
            return out.fill(f64::NAN);
        }
        let function = match law {
            Law::Compiled { law, .. } => return law(t, z.as_ptr(), out.as_mut_ptr()),
            Law::Python(function) => function,
        };
        let called = Python::attach(|py| {
            let (function, z) = (function.bind(py), PyArray1::from_slice(py, z));
            let found = match signs {
                None => function.call1((t, z))?,
                Some(signs) => function.call1((t, z, PyArray1::from_slice(py, signs)))?,
            };
            write(name, &found, out)
        });
        if let Err(error) = called {
            out.fill(f64::NAN);
            self.calls.fail(error);
        }
    }

    /// The values of all guards.
    pub fn raw_guards(&self, t: f64, z: &[f64], values: &mut [f64]) {
        if let Some(events) = &self.events {
            self.call(("events", events), None, t, z, values);
        }
    }

    /// The state after a reset; `None` if the guard has none.
    pub fn reset(&self, t: f64, z: &[f64], guard: usize) -> Option<Vec<f64>> {
        let Some(Law::Python(reset)) = &self.reset else {
            return None;
        };
        self.calls.begin();
        let mut after = z.to_vec();
        let called = Python::attach(|py| {
            let found = reset
                .bind(py)
                .call1((t, PyArray1::from_slice(py, z), guard))?;
            if found.is_none() {
                return Ok(false);
            }
            write("reset", &found, &mut after).map(|()| true)
        });
        called
            .unwrap_or_else(|error| {
                after.fill(f64::NAN);
                self.calls.fail(error);
                true
            })
            .then_some(after)
    }

    /// Whether a function changes with time alone: compared at states and times that no period divides.
    pub fn depends_on_time(&self, (from, span): (f64, f64), z0: &[f64]) -> bool {
        let mut signs = vec![0; self.status_len()];
        self.status_of(from, z0, &mut signs);
        let values = |t: f64, z: &[f64]| {
            let mut all = vec![0.0; self.dim + self.guards];
            let (law, guards) = all.split_at_mut(self.dim);
            self.force_in(&signs, t, z, law);
            self.raw_guards(t, z, guards);
            all.extend(
                (0..self.guards)
                    .filter_map(|k| self.reset(t, z, k))
                    .flatten(),
            );
            let failed = self.calls.take_fault().is_some();
            self.calls.watch.stop.store(false, Ordering::Relaxed);
            (!failed).then(|| all.iter().map(|x| x.to_bits()).collect::<Vec<u64>>())
        };
        let beside: Vec<f64> = z0.iter().map(|z| 1.001 * z + 1e-3).collect();
        [z0, beside.as_slice()].into_iter().any(|z| {
            let first = values(from, z);
            let golden = |k: u32| (0.618_033_988_75 * f64::from(k)).fract();
            first.is_some() && (1..=16).any(|k| values(from + span * golden(k), z) != first)
        })
    }

    /// Does work that calls the functions on this thread. Only compiled functions leave the interpreter to others.
    pub fn run<T: Send>(&self, py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
        let functions = [&self.jacobian, &self.events, &self.reset];
        let compiled = functions.into_iter().flatten().all(Law::is_compiled);
        if compiled && self.rhs.is_compiled() {
            py.detach(work)
        } else {
            work()
        }
    }

    /// The result of an integration, or the exception that ended it.
    pub fn finish<T>(&self, done: Result<T, DynamicsError>) -> PyResult<T> {
        match (self.calls.take_fault(), done) {
            (Some(error), _) => Err(error),
            (None, Err(DynamicsError::Chatter { time, guard, .. })) => {
                let guard = guard % self.guards;
                Err(failure(format!(
                    "at t = {time} guard {guard} is crossed again and again: let `reset` switch a state to rest, as the \
                     ball in the guide does, or permit more with max_crossings"
                )))
            }
            (None, done) => done.map_err(|error| raise(&error)),
        }
    }
}

/// Writes the numbers that a function returned.
fn write(name: &str, found: &Bound<'_, PyAny>, out: &mut [f64]) -> PyResult<()> {
    let must = out.len();
    let wrong = |count: usize| {
        Err(input(format!(
            "{name} returned {count} numbers; it must return {must}"
        )))
    };
    if let Ok(array) = found.cast::<PyArray1<f64>>()
        && array.is_contiguous()
    {
        if array.len() != out.len() {
            return wrong(array.len());
        }
        out.copy_from_slice(array.readonly().as_slice()?);
        return Ok(());
    }
    // Plain sequences of numbers, without a detour over arrays.
    let is_plain = found.is_instance_of::<PyList>() || found.is_instance_of::<PyTuple>();
    if is_plain
        && let Ok(numbers) = found.extract::<Vec<f64>>()
        && numbers.len() == must
    {
        out.copy_from_slice(&numbers);
        return Ok(());
    }
    let array = numeric(name, found)?.call_method0("ravel")?;
    let array = array.cast_into::<PyArray1<f64>>()?;
    if array.len() != out.len() {
        return wrong(array.len());
    }
    out.copy_from_slice(array.readonly().as_slice()?);
    Ok(())
}

impl System for OwnSystem {
    fn omega(&self) -> &[f64] {
        &[]
    }

    fn first_order(&self) -> usize {
        self.dim
    }

    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        let mut status = vec![0; self.status_len()];
        self.status_of(t, z, &mut status);
        self.force_in(&status, t, z, out);
    }

    fn switching(&self) -> Option<&dyn Switching> {
        self.events.as_ref().map(|_| self as &dyn Switching)
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        self.autonomous
    }
}

impl Differentiable for OwnSystem {
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
        let status = status.unwrap_or(&[]);
        let signs = signs(status);
        let known = self.jacobian.as_ref().filter(|_| !signs.contains(&ON));
        let matrix = known.map(|jacobian| {
            let mut matrix = vec![0.0; dim * dim];
            let signs = self.events.as_ref().map(|_| signs.as_slice());
            self.call(("jacobian", jacobian), signs, t, z, &mut matrix);
            matrix
        });
        let mut derivative = vec![0.0; dim];
        for l in 0..width {
            let vector: Vec<f64> = vectors.iter().skip(l).step_by(width).copied().collect();
            match &matrix {
                Some(matrix) => {
                    for (out, row) in derivative.iter_mut().zip(matrix.chunks(dim)) {
                        *out = row.iter().zip(&vector).map(|(a, v)| a * v).sum();
                    }
                }
                None => central_difference((t, z), (&vector, 0.0), &mut derivative, |t, z, out| {
                    self.force_in(status, t, z, out);
                }),
            }
            for (out, x) in out.iter_mut().skip(l).step_by(width).zip(&derivative) {
                *out = *x;
            }
        }
    }
}
