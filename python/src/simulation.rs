//! Simulations that are advanced and changed step by step.

use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use squeakscope::pipeline::message::DisplayRates;
use squeakscope::pipeline::{self, PipelineError, Source};

use crate::array::whole;
use crate::call::long_call;
use crate::error::{input, raise};
use crate::samples::{SampleBuffer, Samples};
use crate::scene::{Scene, SceneOrName};

/// A simulation that is advanced by any number of samples, and changed in between: for control and for
/// learning.
///
/// The simulation has no end. It follows the schedules of the scene until :meth:`set` replaces that of the tilt.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path. Its analyses are not computed.
///
/// Raises
/// ------
/// InputError
///     If the scene is not valid.
///
/// Examples
/// --------
/// >>> import squeakscope as s
/// >>> simulation = s.Simulation("periodic-2deg")
/// >>> samples = simulation.step(1000)
/// >>> simulation.set("tilt_deg", 3.0)
/// >>> samples = simulation.step(1000)
#[pyclass(frozen, module = "squeakscope")]
pub struct Simulation {
    /// The scene.
    #[pyo3(get)]
    scene: Py<Scene>,
    source: Mutex<pipeline::Simulation>,
}

impl Simulation {
    fn with<T>(&self, work: impl FnOnce(&mut pipeline::Simulation) -> T) -> T {
        // A panic would have ended the call with an exception; the state is that of the last sample.
        work(&mut self.source.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[pymethods]
impl Simulation {
    #[new]
    fn new(py: Python<'_>, scene: SceneOrName) -> PyResult<Self> {
        let scene = scene.load(None)?.without_analyses();
        let mut source = long_call(py, None, |_| pipeline::Simulation::new(&scene))?;
        source.run_until_stopped();
        Ok(Self {
            scene: Py::new(py, Scene(scene))?,
            source: Mutex::new(source),
        })
    }

    /// Simulate further samples.
    ///
    /// Parameters
    /// ----------
    /// samples : int
    ///     Number of samples, at the sampling rate of the scene.
    ///
    /// Returns
    /// -------
    /// Samples
    ///     The samples; the first one follows the last of the previous call.
    ///
    /// Raises
    /// ------
    /// Error
    ///     If the simulation fails.
    fn step(&self, py: Python<'_>, samples: i64) -> PyResult<Samples> {
        let samples = whole("samples", samples, 0)?;
        let pictures = self.scene.get().0.record.patch_rate;
        let buffer = long_call(py, None, |watch| {
            self.with(|source| {
                let mut buffer = SampleBuffer::default();
                let mut left = samples;
                while left > 0 && watch.report(0.0).is_ok() {
                    let shown = DisplayRates {
                        speed: 1.0,
                        pictures,
                        every: 1,
                        apart: 0,
                    };
                    // Short enough to notice Ctrl-C.
                    source.set_frame_length(left.min(4096), shown);
                    let Some(frame) = source.next_frame()? else {
                        break;
                    };
                    left -= frame.len();
                    buffer.add(&frame);
                }
                Ok::<_, PipelineError>(buffer)
            })
        })?;
        buffer.into_samples(py)
    }

    /// Change a number of the system from the next sample on. The motion continues from its present state.
    ///
    /// Parameters
    /// ----------
    /// key : str
    ///     Dotted path of the number, or its name if that is unique: ``"load.tilt_deg"`` or ``"tilt_deg"``. A number
    ///     of the body cannot change.
    /// value : float
    ///     Value, in the unit of the key. A tilt replaces a tilt that is a function of time.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If there is no such number, or the scene does not permit the value. The simulation is unchanged.
    fn set(&self, py: Python<'_>, key: &str, value: f64) -> PyResult<()> {
        let scene = &self.scene.get().0;
        let parameter = scene.parameter(key).map_err(|error| raise(&error))?;
        long_call(py, None, |_| {
            self.with(|source| source.set(parameter, value))
        })
    }

    /// Add a Gaussian random velocity to each mode at the next sample.
    ///
    /// Parameters
    /// ----------
    /// size : float
    ///     Standard deviation of the modal velocities, sqrt(kg) m/s.
    /// seed : int
    ///     Seed of the random numbers.
    #[pyo3(signature = (size, seed=1))]
    fn kick(&self, py: Python<'_>, size: f64, seed: i64) -> PyResult<()> {
        if !(size.is_finite() && size >= 0.0) {
            return Err(input("size: give a finite number of at least 0"));
        }
        let seed = whole("seed", seed, 0)? as u64;
        long_call(py, None, |_| self.with(|source| source.kick(size, seed)))
    }

    /// Time of the next sample, s.
    #[getter]
    fn time(&self) -> f64 {
        self.with(|source| source.time())
    }

    fn __repr__(&self) -> String {
        let scene = &self.scene.get().0;
        format!(
            "<squeakscope.Simulation of {:?} at {} s>",
            scene.name,
            self.time()
        )
    }
}
