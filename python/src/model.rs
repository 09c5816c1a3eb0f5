//! The arrays of a scene's model.

use std::error::Error;
use std::io::Cursor;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use squeakscope::export::encode_model;
use squeakscope::joint::BallJoint;
use squeakscope::pipeline::initial_state;
use squeakscope::scene::Scene;

use crate::error::raise;
use crate::scene::SceneOrName;

/// Contact patch, modes and equilibrium of a scene at its start.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
///
/// Returns
/// -------
/// dict of numpy.ndarray
///     The arrays of ``squeakscope model``: ``positions``, ``normals``, ``areas``, ``pre_stress``, ``stiffness``,
///     ``shapes``, ``omega`` and others, in SI units.
///
/// Raises
/// ------
/// InputError
///     If the scene is not valid, or describes no ball joint.
#[pyfunction]
pub fn model<'py>(py: Python<'py>, scene: SceneOrName) -> PyResult<Bound<'py, PyDict>> {
    let scene = scene.load(None)?;
    let npz = py.detach(|| encoded(&scene));
    let npz = PyBytes::new(py, &npz.map_err(|error| raise(&*error))?);
    let file = py.import("io")?.call_method1("BytesIO", (npz,))?;
    let arrays = py.import("numpy")?.call_method1("load", (file,))?;
    let dict = py.get_type::<PyDict>().call1((arrays,))?;
    Ok(dict.cast_into()?)
}

/// The model as the bytes of a `.npz` file.
fn encoded(scene: &Scene) -> Result<Vec<u8>, Box<dyn Error + Send + Sync>> {
    let joint = scene.joint()?;
    let model = BallJoint::new(&joint.spec)?.model(joint.tilt.at(0.0))?;
    let start = initial_state(scene, model.modes());
    let mut npz = Cursor::new(Vec::new());
    encode_model(&mut npz, &model, &start)?;
    Ok(npz.into_inner())
}
