//! The samples of a simulation as arrays.

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use squeakscope::pipeline::message::Frame;

/// The samples of a simulation, as NumPy arrays of equal length ``n``.
#[pyclass(frozen, get_all, module = "squeakscope")]
pub struct Samples {
    /// Times, s, shape (n,).
    t: Py<PyArray1<f64>>,
    /// Modal coordinates in the perturbation from equilibrium, sqrt(kg) m, shape (n, modes).
    q: Py<PyArray2<f64>>,
    /// Modal velocities, sqrt(kg) m/s, shape (n, modes).
    qdot: Py<PyArray2<f64>>,
    /// Displacement of the central contact point in the sliding direction, m, shape (n,).
    u: Py<PyArray1<f64>>,
    /// Velocity of the same point, m/s, shape (n,).
    v: Py<PyArray1<f64>>,
    /// Tilt of the load, degrees, shape (n,).
    tilt_deg: Py<PyArray1<f64>>,
    /// Load, N, shape (n,).
    load_n: Py<PyArray1<f64>>,
    /// Factor on the rotation, shape (n,).
    rotation_factor: Py<PyArray1<f64>>,
    /// Snapshots of the shown contact nodes.
    contact: Py<Contact>,
}

/// Snapshots of the ``m`` shown contact nodes (`record.patch_nodes`) at ``k`` instants; empty arrays without a patch.
#[pyclass(frozen, get_all, module = "squeakscope")]
pub struct Contact {
    /// Times, s, shape (k,).
    t: Py<PyArray1<f64>>,
    /// State of each node, shape (k, m): 0 sticking, 1 sliding, 2 separated.
    state: Py<PyArray2<u8>>,
    /// Normal force on each node, N, shape (k, m).
    normal_force: Py<PyArray2<f64>>,
    /// Friction force on the ball at each node, N, shape (k, m, 3).
    friction: Py<PyArray3<f64>>,
    /// Positions of the nodes relative to the centre of the ball at the last instant, m, shape (m, 3).
    position: Py<PyArray2<f64>>,
}

#[pymethods]
impl Samples {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.t.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "<squeakscope.Samples of {} instants>",
            self.__len__(py)?
        ))
    }
}

/// Samples as they arrive.
#[derive(Default)]
pub struct SampleBuffer {
    modes: usize,
    t: Vec<f64>,
    q: Vec<f64>,
    qdot: Vec<f64>,
    u: Vec<f64>,
    v: Vec<f64>,
    tilt_deg: Vec<f64>,
    load_n: Vec<f64>,
    rotation_factor: Vec<f64>,
    snapshot_t: Vec<f64>,
    state: Vec<u8>,
    normal_force: Vec<f64>,
    friction: Vec<f64>,
    position: Vec<f64>,
}

impl SampleBuffer {
    /// Adds the samples of a frame.
    pub fn add(&mut self, frame: &Frame) {
        let samples = frame.len();
        self.modes = frame.modes;
        self.t.extend((0..samples).map(|k| frame.time(k)));
        self.q.extend_from_slice(&frame.q);
        self.qdot.extend_from_slice(&frame.qdot);
        self.u.extend_from_slice(&frame.displacement);
        self.v.extend_from_slice(&frame.velocity);
        for (values, value) in [
            (&mut self.tilt_deg, frame.tilt.to_degrees()),
            (&mut self.load_n, frame.load),
            (&mut self.rotation_factor, frame.rotation_factor),
        ] {
            values.extend(std::iter::repeat_n(value, samples));
        }
        for snapshot in &frame.patch {
            self.snapshot_t.push(snapshot.time);
            let states = snapshot.states.iter();
            self.state.extend(states.map(|state| *state as u8));
            self.normal_force.extend_from_slice(&snapshot.normal_force);
            self.friction.extend(snapshot.friction.iter().flatten());
        }
        if !frame.patch.is_empty() {
            self.position.clear();
            let positions = frame.geometry.positions.iter();
            self.position.extend(positions.flatten());
        }
    }

    /// The arrays; the numbers are not copied.
    pub fn into_samples(self, py: Python<'_>) -> PyResult<Samples> {
        let (samples, instants) = (self.t.len(), self.snapshot_t.len());
        let nodes = self.position.len() / 3;
        let one = |values| PyArray1::from_vec(py, values).unbind();
        let two = |values, shape: [usize; 2]| {
            let array = PyArray1::from_vec(py, values).reshape(shape)?;
            PyResult::Ok(array.unbind())
        };
        let contact = Contact {
            t: one(self.snapshot_t),
            state: PyArray1::from_vec(py, self.state)
                .reshape([instants, nodes])?
                .unbind(),
            normal_force: two(self.normal_force, [instants, nodes])?,
            friction: PyArray1::from_vec(py, self.friction)
                .reshape([instants, nodes, 3])?
                .unbind(),
            position: two(self.position, [nodes, 3])?,
        };
        Ok(Samples {
            t: one(self.t),
            q: two(self.q, [samples, self.modes])?,
            qdot: two(self.qdot, [samples, self.modes])?,
            u: one(self.u),
            v: one(self.v),
            tilt_deg: one(self.tilt_deg),
            load_n: one(self.load_n),
            rotation_factor: one(self.rotation_factor),
            contact: Py::new(py, contact)?,
        })
    }
}
