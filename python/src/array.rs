//! NumPy arrays as slices of the library.

use std::borrow::Cow;

use numpy::{AllowTypeChange, PyArray1, PyArrayLike1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::error::input;
use crate::result::wrap;

/// A signal: an array of numbers, or a sequence that NumPy converts to one.
pub type SignalArray<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

/// The samples of a signal, which must be finite; copied only if they are not contiguous.
pub fn samples<'a>(py: Python<'_>, signal: &'a SignalArray<'_>) -> PyResult<Cow<'a, [f64]>> {
    let samples = match signal.as_slice() {
        Ok(slice) => Cow::Borrowed(slice),
        Err(_) => Cow::Owned(signal.as_array().to_vec()),
    };
    match samples.iter().position(|x| !x.is_finite()) {
        None => Ok(samples),
        Some(at) => Err(input(
            py,
            &format!("sample {at} is {}; replace it by a number", samples[at]),
        )),
    }
}

/// An array of numbers; they are not copied.
pub fn array<'py, T: numpy::Element>(py: Python<'py>, values: Vec<T>) -> Bound<'py, PyAny> {
    PyArray1::from_vec(py, values).into_any()
}

/// A matrix with rows of `columns` numbers; they are not copied.
pub fn matrix<T: numpy::Element>(
    py: Python<'_>,
    values: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'_, PyAny>> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    Ok(PyArray1::from_vec(py, values)
        .reshape([rows, columns])?
        .into_any())
}

/// A result with its serialised fields and further ones.
pub fn result_with<'py, T: IntoPyObjectExt<'py>>(
    py: Python<'py>,
    value: &impl Serialize,
    more: impl IntoIterator<Item = (&'static str, T)>,
) -> PyResult<Bound<'py, PyAny>> {
    let fields = pythonize::pythonize(py, value)?.cast_into::<PyDict>()?;
    for (name, value) in more {
        fields.set_item(name, value.into_bound_py_any(py)?)?;
    }
    wrap(fields.into_any())
}

/// A result with these fields.
pub fn fields<'py>(
    py: Python<'py>,
    all: impl IntoIterator<Item = (&'static str, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyAny>> {
    let fields = PyDict::new(py);
    for (name, value) in all {
        fields.set_item(name, value)?;
    }
    wrap(fields.into_any())
}
