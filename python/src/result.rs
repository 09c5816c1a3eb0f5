//! Results of the library as Python objects.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use serde::Serialize;

/// A result as an object with its serialised fields, of the class `squeakscope.Result`; a list of results as
/// `squeakscope.Results`.
pub fn result<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    wrap(pythonize::pythonize(py, value)?)
}

/// Serialised values as an object.
pub fn wrap(value: Bound<'_, PyAny>) -> PyResult<Bound<'_, PyAny>> {
    static WRAP: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let wrap = WRAP.import(value.py(), "squeakscope._result", "wrap")?;
    wrap.call1((value,))
}
