//! Systems of the caller over parameters, for studies that take scenes, too.

use std::error::Error;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use squeakscope::dynamics::DynamicsError;
use squeakscope::pipeline::{PipelineError, Prepared};
use squeakscope::study::{Subject, Trial};

use crate::call::{Watch, watched_call};
use crate::error::input;
use crate::integrate::System;
use crate::scene::SceneOrName;
use crate::system::Calls;

/// Samples in a period; a quarter of it is the delay of the section.
const SAMPLES: f64 = 48.0;

/// Steps in a period, at least.
const STEPS: f64 = 20.0;

/// Amplitude of a motion that is silent, relative to the initial state.
const SILENT: f64 = 1e-9;

/// Distance from an equilibrium within which motions are small, relative to its state.
const SMALL: f64 = 0.05;

/// A scene, or a function that returns systems.
#[derive(FromPyObject)]
pub enum Studied {
    Scene(SceneOrName),
    #[pyo3(transparent)]
    Systems(Py<PyAny>),
}

/// Systems that a function of the caller returns for values of parameters, its keyword arguments.
pub struct OwnSystems {
    function: Py<PyAny>,
    calls: Arc<Calls>,
}

impl OwnSystems {
    pub fn new(py: Python<'_>, function: Py<PyAny>) -> PyResult<Self> {
        if !function.bind(py).is_callable() {
            return Err(input(
                "scene: give a scene, its name, or a function of the parameters that returns a squeakscope.System",
            ));
        }
        Ok(Self {
            function,
            calls: Arc::default(),
        })
    }

    /// Does work that calls the functions, with progress and Ctrl-C. Their first exception ends it.
    pub fn call<T: Send, E: Error + Send + 'static>(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Watch) -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let watch = Watch::with_stop(&self.calls.watch.stop);
        let done = watched_call(py, progress, &watch, |watch| {
            let mut work = Some(work);
            let mut done = None;
            self.enter(&mut || done = work.take().map(|work| work(watch)));
            done.expect("the work is done once")
        });
        self.calls.take_fault().map_or(done, Err)
    }

    fn built(&self, py: Python<'_>, names: &[String], values: &[f64]) -> PyResult<Trial> {
        let arguments = PyDict::new(py);
        for (name, value) in names.iter().zip(values) {
            if name == SEED {
                arguments.set_item(name, *value as u64)?;
            } else {
                arguments.set_item(name, value)?;
            }
        }
        let found = self.function.bind(py).call((), Some(&arguments))?;
        let Ok(definition) = found.cast::<System>() else {
            let kind = found.get_type();
            return Err(input(format!(
                "the function of the parameters must return a squeakscope.System, not {}",
                kind.name()?
            )));
        };
        let definition = definition.get();
        let (period, state) = (definition.period, definition.z0.clone());
        let max_step = definition.options.max_step.unwrap_or(period / STEPS);
        let calls = Arc::clone(&self.calls);
        let (system, integrator) =
            definition.start(py, calls, (0.0, period), (period, Some(max_step)))?;
        Ok(Trial {
            sample_rate: SAMPLES / period,
            lag: 0.25 * period,
            max_step,
            drive_period: (!system.autonomous).then_some(period),
            period: Some(period),
            silence: SILENT * size(&state),
            seed: 1,
            scene: None,
            prepared: Prepared {
                probe: vec![1.0],
                integrator,
                state,
                ball: None,
            },
        })
    }
}

/// Name of the parameter of basins, which is a whole number.
pub const SEED: &str = "seed";

fn size(state: &[f64]) -> f64 {
    state.iter().fold(0.0, |most, x| most.max(x.abs()))
}

impl Subject for OwnSystems {
    fn trial(&self, names: &[String], values: &[f64]) -> Result<Trial, PipelineError> {
        Python::attach(|py| self.built(py, names, values)).map_err(|error| {
            self.calls.fail(error);
            // The study ends with the exception.
            PipelineError::Dynamics(DynamicsError::MissingCapability {
                what: "functions",
                purpose: "studies",
            })
        })
    }

    /// Calls from this thread find the state of the interpreter that is made here.
    fn enter(&self, work: &mut (dyn FnMut() + Send)) {
        Python::attach(|py| py.detach(work));
    }

    fn hopf_size(&self, _omega: f64, state: &[f64]) -> f64 {
        match size(state) {
            0.0 => SMALL,
            size => SMALL * size,
        }
    }
}
