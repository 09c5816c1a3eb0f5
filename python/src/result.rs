//! Results of the library as Python objects.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList};
use schemars::JsonSchema;
use serde::Serialize;

/// A result, from the fields that `--json` has.
pub fn result<'py, T: Serialize + JsonSchema>(
    py: Python<'py>,
    value: &T,
) -> PyResult<Bound<'py, PyAny>> {
    wrap::<T>(pythonize::pythonize(py, value)?)
}

/// Builds a result from serialised fields and arrays. Numbers of an array are not copied.
pub struct Fields<'py>(Bound<'py, PyDict>);

impl<'py> Fields<'py> {
    /// No fields yet.
    pub fn new(py: Python<'py>) -> Self {
        Self(PyDict::new(py))
    }

    /// The fields of a value.
    pub fn of(py: Python<'py>, value: &impl Serialize) -> PyResult<Self> {
        Ok(Self(pythonize::pythonize(py, value)?.cast_into()?))
    }

    /// Adds a field.
    pub fn with(self, name: &str, value: impl IntoPyObjectExt<'py>) -> PyResult<Self> {
        self.0
            .set_item(name, value.into_bound_py_any(self.0.py())?)?;
        Ok(self)
    }

    /// Adds a serialised field.
    pub fn serialised(self, name: &str, value: &impl Serialize) -> PyResult<Self> {
        let value = pythonize::pythonize(self.0.py(), value)?;
        self.with(name, value)
    }

    /// Adds an array.
    pub fn array<T: numpy::Element>(self, name: &str, values: Vec<T>) -> PyResult<Self> {
        let array = PyArray1::from_vec(self.0.py(), values);
        self.with(name, array)
    }

    /// Adds a matrix with rows of `columns` numbers.
    pub fn matrix<T: numpy::Element>(
        self,
        name: &str,
        values: Vec<T>,
        columns: usize,
    ) -> PyResult<Self> {
        let rows = values.len().checked_div(columns).unwrap_or(0);
        let array = PyArray1::from_vec(self.0.py(), values);
        self.with(name, array.reshape([rows, columns])?)
    }

    /// Gives the `values` of each of the `points` of a sweep by their names, too.
    pub fn name_values(self, names: &[&str]) -> PyResult<Self> {
        for point in self.0.as_any().get_item("points")?.try_iter()? {
            let point = point?.cast_into::<PyDict>()?;
            let named = PyDict::new(self.0.py());
            for (name, value) in names
                .iter()
                .zip(point.as_any().get_item("values")?.try_iter()?)
            {
                named.set_item(name, value?)?;
            }
            named.update(point.as_mapping())?;
            point.clear();
            point.update(named.as_mapping())?;
        }
        Ok(self)
    }

    /// The result, as [`timed`].
    pub fn timed<S: JsonSchema>(self, rate: Option<f64>) -> PyResult<Bound<'py, PyAny>> {
        if rate.is_none() {
            drop_units(&self.0)?;
        }
        self.finish::<S>()
    }

    /// The result, with the fields of a schema.
    pub fn finish<S: JsonSchema>(self) -> PyResult<Bound<'py, PyAny>> {
        wrap::<S>(self.0.into_any())
    }
}

/// A result of a signal. Without a rate times and frequencies refer to samples, and their names have no unit.
pub fn timed<'py, T: Serialize + JsonSchema>(
    py: Python<'py>,
    value: &T,
    rate: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let value = pythonize::pythonize(py, value)?;
    if rate.is_none() {
        drop_units(&value)?;
    }
    wrap::<T>(value)
}

/// Removes the units of time from the names of all fields.
fn drop_units(value: &Bound<'_, PyAny>) -> PyResult<()> {
    if let Ok(list) = value.cast::<PyList>() {
        return list.iter().try_for_each(|item| drop_units(&item));
    }
    let Ok(fields) = value.cast::<PyDict>() else {
        return Ok(());
    };
    for (name, value) in fields.copy()? {
        drop_units(&value)?;
        let name = name.extract::<String>()?;
        let bare = ["_per_s", "_s", "_hz"]
            .iter()
            .find_map(|unit| name.strip_suffix(unit));
        // The wall time of a computation remains one.
        if let Some(bare) = bare.filter(|bare| *bare != "wall") {
            fields.del_item(&name)?;
            fields.set_item(bare, value)?;
        }
    }
    Ok(())
}

/// Wraps serialised fields: as an object of the class that a schema names, a list of them as `squeakscope.Results`.
fn wrap<S: JsonSchema>(value: Bound<'_, PyAny>) -> PyResult<Bound<'_, PyAny>> {
    static WRAP: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let wrap = WRAP.import(value.py(), "squeakscope._result", "wrap")?;
    wrap.call1((value, S::schema_name()))
}
