//! Scenes.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use squeakscope::scene::{self as library, PRESETS};

use crate::error::{input, raise};

/// The description of a run: a body, its load and contact, the integrator and the analyses.
///
/// Scenes are immutable; :meth:`replace` returns a changed one.
///
/// Examples
/// --------
/// >>> import squeakscope as s
/// >>> scene = s.Scene.load("torus-1.75deg").replace(**{"load.tilt_deg": 4})
/// >>> scene["load.tilt_deg"]
/// 4.0
#[pyclass(frozen, eq, module = "squeakscope")]
#[derive(PartialEq)]
pub struct Scene(pub library::Scene);

/// A scene, or the name or path of one.
#[derive(FromPyObject)]
pub enum SceneOrName {
    Scene(Py<Scene>),
    #[pyo3(transparent)]
    Name(std::path::PathBuf),
}

impl SceneOrName {
    /// Returns the scene, with its simulated time (s) replaced if `duration` is given.
    pub fn load(self, duration: Option<f64>) -> PyResult<library::Scene> {
        let scene = match self {
            Self::Scene(scene) => Ok(scene.get().0.clone()),
            Self::Name(name) => library::Scene::load(&name.to_string_lossy()),
        };
        let scene = match duration {
            Some(duration) => scene.and_then(|scene| scene.with_duration(1e3 * duration)),
            None => scene,
        };
        scene.map_err(|error| raise(&error))
    }
}

#[pymethods]
impl Scene {
    /// Load a scene by the name of a built-in scene or the path of a scene file.
    ///
    /// Parameters
    /// ----------
    /// name : str or os.PathLike
    ///     Name of a built-in scene (see :func:`scenes`), or path of a scene file.
    ///
    /// Returns
    /// -------
    /// Scene
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If there is no such scene, or it is not valid.
    #[staticmethod]
    fn load(name: std::path::PathBuf) -> PyResult<Self> {
        Ok(Self(SceneOrName::Name(name).load(None)?))
    }

    /// Parse the text of a scene file.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     The scene in TOML.
    /// name : str
    ///     Name of the scene if the text gives none; messages contain it.
    #[staticmethod]
    #[pyo3(signature = (text, name="scene"))]
    fn parse(text: &str, name: &str) -> PyResult<Self> {
        let scene = library::Scene::parse(name, text);
        scene.map(Self).map_err(|error| raise(&error))
    }

    /// Return the scene with other values of some keys.
    ///
    /// Parameters
    /// ----------
    /// **values
    ///     Values by the dotted paths of their keys, or by their names where these occur in one table only, as
    ///     in ``scene.replace(**{"load.tilt_deg": 4, "nodes": 200})``. Numbers, words, booleans and lists of
    ///     them, in the units of the scene file; None removes a key. A tilt replaces a tilt that is a function
    ///     of time.
    ///
    /// Returns
    /// -------
    /// Scene
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If there is no such key, or a value is out of range.
    #[pyo3(signature = (**values))]
    fn replace(&self, values: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut overrides = Vec::new();
        for (key, value) in values.into_iter().flatten() {
            overrides.push((key.extract::<String>()?, literal(&value)?));
        }
        let scene = self.0.with_overrides(&overrides);
        scene.map(Self).map_err(|error| raise(&error))
    }

    /// Value of a numeric key in the unit of the scene file: as written, or its default; that at the start of
    /// the run for a function of time.
    fn __getitem__(&self, key: &str) -> PyResult<f64> {
        let parameter = self.0.parameter(key).map_err(|error| raise(&error))?;
        let value = self.0.value_of(parameter);
        value.ok_or_else(|| input(format!("the scene has no number `{key}`")))
    }

    /// Name of the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// One line that states the content of the scene.
    #[getter]
    fn title(&self) -> &str {
        &self.0.title
    }

    /// A few sentences (Markdown) on what to observe.
    #[getter]
    fn about(&self) -> &str {
        &self.0.about
    }

    /// Text of the scene file, including changes.
    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    /// Simulated time, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.0.duration
    }

    /// Sampling rate, Hz.
    #[getter]
    fn sample_rate(&self) -> f64 {
        self.0.sample_rate
    }

    /// Properties of this valid scene that are probably unintended, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings()
    }

    /// The numbers of the simulated system by the paths of their keys, in the units of the scene file.
    #[getter]
    fn parameters(&self) -> std::collections::BTreeMap<&'static str, f64> {
        let all = self.0.physical_parameters().into_iter();
        all.map(|(parameter, value)| (parameter.path(), value))
            .collect()
    }

    fn __repr__(&self) -> String {
        format!("<squeakscope.Scene {:?}: {}>", self.0.name, self.0.title)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let parse = py.get_type::<Self>().getattr("parse")?;
        Ok((parse, (self.0.text.clone(), self.0.name.clone())))
    }
}

/// A Python value as the literal of a scene file.
fn literal(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if value.is_none() {
        return Ok("absent".to_owned());
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(value.is_truthy()?.to_string());
    }
    if value.is_instance_of::<PyString>() {
        // A string in Python is a string in TOML, whatever its letters.
        return Ok(format!("{:?}", value.extract::<String>()?));
    }
    if let Ok(number) = value.extract::<i64>() {
        return Ok(number.to_string());
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(format!("{number:?}"));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        let entries = table.iter().map(|(key, value)| {
            Ok(format!(
                "{} = {}",
                key.extract::<String>()?,
                literal(&value)?
            ))
        });
        let entries = entries.collect::<PyResult<Vec<_>>>()?;
        return Ok(format!("{{{}}}", entries.join(", ")));
    }
    let items = value.try_iter()?.map(|item| literal(&item?));
    Ok(format!(
        "[{}]",
        items.collect::<PyResult<Vec<_>>>()?.join(", ")
    ))
}

/// Names and titles of the built-in scenes.
///
/// Returns
/// -------
/// dict of str
///     Title by name.
#[pyfunction]
pub fn scenes<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for preset in PRESETS {
        let scene = preset.scene().map_err(|error| raise(&error))?;
        all.set_item(preset.name, scene.title)?;
    }
    Ok(all)
}
