//! Results of the library as Python objects.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyCFunction, PyDict, PyList, PyTuple};
use schemars::JsonSchema;
use serde::Serialize;
use squeakscope::plot::{Figure, FigureOptions};

/// A result, from the fields that `--json` has.
pub fn result<'py, T: Serialize + JsonSchema>(
    py: Python<'py>,
    value: &T,
) -> PyResult<Bound<'py, PyAny>> {
    wrap::<T>(pythonize::pythonize(py, value)?, None)
}

/// Builds a result from serialised fields and arrays. Numbers of an array are not copied.
pub struct Fields<'py> {
    fields: Bound<'py, PyDict>,
    panel: Option<Bound<'py, PyCFunction>>,
}

impl<'py> Fields<'py> {
    /// No fields yet.
    pub fn new(py: Python<'py>) -> Self {
        Self {
            fields: PyDict::new(py),
            panel: None,
        }
    }

    /// The fields of a value.
    pub fn of(py: Python<'py>, value: &impl Serialize) -> PyResult<Self> {
        Ok(Self {
            fields: pythonize::pythonize(py, value)?.cast_into()?,
            panel: None,
        })
    }

    /// With figures that a notebook shows.
    pub fn drawn(
        mut self,
        figures: impl Fn() -> Vec<Figure> + Send + Sync + 'static,
    ) -> PyResult<Self> {
        let svg = move |_: &Bound<'_, PyTuple>, _: Option<&Bound<'_, PyDict>>| -> String {
            let options = FigureOptions::default();
            figures()
                .iter()
                .map(|figure| figure.svg(&options))
                .collect()
        };
        self.panel = Some(PyCFunction::new_closure(self.fields.py(), None, None, svg)?);
        Ok(self)
    }

    /// Adds a field.
    pub fn with(self, name: &str, value: impl IntoPyObjectExt<'py>) -> PyResult<Self> {
        self.fields
            .set_item(name, value.into_bound_py_any(self.fields.py())?)?;
        Ok(self)
    }

    /// Adds a serialised field.
    pub fn serialised(self, name: &str, value: &impl Serialize) -> PyResult<Self> {
        let value = pythonize::pythonize(self.fields.py(), value)?;
        self.with(name, value)
    }

    /// Adds an array.
    pub fn array<T: numpy::Element>(self, name: &str, values: Vec<T>) -> PyResult<Self> {
        let array = PyArray1::from_vec(self.fields.py(), values);
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
        let array = PyArray1::from_vec(self.fields.py(), values);
        self.with(name, array.reshape([rows, columns])?)
    }

    /// The result, as [`timed`].
    pub fn timed<S: JsonSchema>(self, rate: Option<f64>) -> PyResult<Bound<'py, PyAny>> {
        if rate.is_none() {
            return self.unitless(&[])?.finish::<S>();
        }
        self.finish::<S>()
    }

    /// Without units in the names of the fields, except for those of parameters.
    pub fn unitless(self, parameters: &[String]) -> PyResult<Self> {
        drop_units(&self.fields, parameters)?;
        Ok(self)
    }

    /// The result, with the fields of a schema.
    pub fn finish<S: JsonSchema>(self) -> PyResult<Bound<'py, PyAny>> {
        wrap::<S>(self.fields.into_any(), self.panel)
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
        drop_units(&value, &[])?;
    }
    wrap::<T>(value, None)
}

/// Removes units from the names of all fields except for some.
fn drop_units(value: &Bound<'_, PyAny>, kept: &[String]) -> PyResult<()> {
    if let Ok(list) = value.cast::<PyList>() {
        return list.iter().try_for_each(|item| drop_units(&item, kept));
    }
    let Ok(fields) = value.cast::<PyDict>() else {
        return Ok(());
    };
    for (name, value) in fields.copy()? {
        drop_units(&value, kept)?;
        let name = name.extract::<String>()?;
        let bare = ["_m_per_s", "_per_s", "_s", "_hz", "_m"]
            .iter()
            .find_map(|unit| name.strip_suffix(unit));
        // The wall time of a computation remains one.
        if let Some(bare) = bare.filter(|bare| *bare != "wall" && !kept.contains(&name)) {
            fields.del_item(&name)?;
            fields.set_item(bare, value)?;
        }
    }
    Ok(())
}

/// Wraps serialised fields: as an object of the class that a schema names, a list of them as `squeakscope.Results`.
fn wrap<'py, S: JsonSchema>(
    value: Bound<'py, PyAny>,
    panel: Option<Bound<'py, PyCFunction>>,
) -> PyResult<Bound<'py, PyAny>> {
    static WRAP: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let wrap = WRAP.import(value.py(), "squeakscope._result", "wrap")?;
    wrap.call1((value, S::schema_name(), panel))
}
