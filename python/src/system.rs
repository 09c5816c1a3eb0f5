//! Systems whose equations are Python functions, in the integrators of the library.

use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{AllowTypeChange, PyArray1, PyArrayLikeDyn};
use pyo3::prelude::*;
use squeakscope::dynamics::{Differentiable, DynamicsError, Switching, System};

use crate::error::{input, raise};

/// Step of a central difference relative to the size of the state: the cube root of the rounding error.
const STEP: f64 = 6e-6;

/// A system with Python functions.
pub struct PySystem {
    /// Functions of the caller, with the events only in `guards`.
    pub rhs: Py<PyAny>,
    pub jacobian: Option<Py<PyAny>>,
    pub guards: Option<Guards>,
    /// Number of components of the state.
    pub dim: usize,
    pub autonomous: bool,
    /// The first exception of a function; all values are NaN from then on, which ends the integration.
    pub fault: Mutex<Option<PyErr>>,
}

/// The guards of a piecewise smooth system.
pub struct Guards {
    pub function: Py<PyAny>,
    pub count: usize,
    pub reset: Option<Py<PyAny>>,
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

    /// The result of an integration, or the exception that ended it.
    pub fn finish<T>(&self, py: Python<'_>, done: Result<T, DynamicsError>) -> PyResult<T> {
        match self.fault().take() {
            Some(error) => Err(error),
            None => done.map_err(|error| raise(py, &error)),
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
