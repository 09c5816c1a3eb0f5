//! Runs of a scene.

use std::path::PathBuf;

use pyo3::prelude::*;
use squeakscope::pipeline::message::Record;
use squeakscope::pipeline::{self, Monitor, PipelineError, RunResult, Sink, SinkError};

use squeakscope::record::{Output, RerunSink, RunFigures};

use crate::call::long_call;
use crate::error::input;
use crate::result::{Fields, result};
use crate::samples::{SampleBuffer, Samples};
use crate::scene::{Scene, SceneOrName};

/// A finished run: its samples and its results.
#[pyclass(frozen, module = "squeakscope")]
pub struct Run {
    /// The scene that was run.
    #[pyo3(get)]
    scene: Py<Scene>,
    /// The samples; empty if the run was asked to keep none.
    #[pyo3(get)]
    samples: Py<Samples>,
    /// Result of the run: amplitude, lines, energy audit, statistics of the solver.
    #[pyo3(get)]
    summary: Py<PyAny>,
    /// Lyapunov exponents at the end; None if the scene does not compute them.
    #[pyo3(get)]
    exponents: Option<Py<PyAny>>,
    /// Last classification of the displacement, with its evidence; None if the run is too short.
    #[pyo3(get)]
    verdict: Option<Py<PyAny>>,
}

#[pymethods]
impl Run {
    /// Fields of the samples and of the summary are also attributes of the run.
    fn __getattr__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if name.starts_with('_') {
            return Err(pyo3::exceptions::PyAttributeError::new_err(name.to_owned()));
        }
        match self.samples.bind(py).getattr_opt(name)? {
            Some(found) => Ok(found),
            None => self.summary.bind(py).getattr(name),
        }
    }

    fn __dir__(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let mut names = ["scene", "samples", "summary", "exponents", "verdict"]
            .map(str::to_owned)
            .to_vec();
        for part in [self.samples.bind(py).as_any(), self.summary.bind(py)] {
            names.extend(part.dir()?.extract::<Vec<String>>()?);
        }
        names.retain(|name| !name.starts_with('_') && name != "to_dict");
        names.sort();
        names.dedup();
        Ok(names)
    }

    /// The table of the summary, for notebooks.
    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary.bind(py).call_method0("_repr_html_")
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let scene = &self.scene.get().0;
        let simulated: f64 = self.summary.bind(py).getattr("simulated_s")?.extract()?;
        Ok(format!(
            "<squeakscope.Run of {:?}: {simulated} s>",
            scene.name
        ))
    }
}

/// Collects the records of a run, draws its figures, and passes the records to a recording.
struct Collector {
    keep_samples: bool,
    samples: SampleBuffer,
    figures: RunFigures,
    recording: Option<RerunSink>,
}

impl Collector {
    fn recording(
        &mut self,
        work: impl FnOnce(&mut RerunSink) -> Result<(), SinkError>,
    ) -> Result<(), SinkError> {
        self.recording.as_mut().map_or(Ok(()), work)
    }
}

impl Sink for Collector {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if let Record::Samples(frame) = &record
            && self.keep_samples
        {
            self.samples.add(frame);
        }
        (&mut self.figures).accept(record.clone())?;
        self.recording(|recording| recording.accept(record))
    }

    fn idle(&mut self) -> Result<(), SinkError> {
        self.recording(Sink::idle)
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        self.recording(Sink::finish)
    }
}

/// Simulate a scene with all of its analyses.
///
/// Parameters
/// ----------
/// scene : Scene, str or os.PathLike
///     The scene, or its name or path.
/// duration : float, optional
///     Simulated time, s. By default that of the scene.
/// record : str or os.PathLike, optional
///     Save the recording to this file (.rrd), which the Rerun viewer opens. An existing file is replaced.
/// samples : bool
///     Whether to keep the samples. A long run without them needs little memory.
/// progress : callable, optional
///     Called about 20 times a second with the share of the work that is done, 0 to 1. An exception that it
///     raises ends the run.
///
/// Returns
/// -------
/// Run
///
/// Raises
/// ------
/// InputError
///     If the scene is not valid.
/// Error
///     If the simulation or the recording fails.
/// KeyboardInterrupt
///     After Ctrl-C; the recording contains the run until then.
///
/// Examples
/// --------
/// >>> import squeakscope as s
/// >>> run = s.run("periodic-2deg", duration=0.05)
/// >>> round(run.lines[0].frequency_hz, -2)
/// 4100.0
#[pyfunction]
#[pyo3(signature = (scene, *, duration=None, record=None, samples=true, progress=None))]
pub fn run(
    py: Python<'_>,
    scene: SceneOrName,
    duration: Option<f64>,
    record: Option<PathBuf>,
    samples: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Run> {
    let scene = scene.load(duration)?;
    if let Some(path) = &record
        && path.extension().is_none_or(|ending| ending != "rrd")
    {
        return Err(input(format!(
            "record: `{}` does not end in .rrd; choose such a name",
            path.display()
        )));
    }
    let mut collector = Collector {
        keep_samples: samples,
        samples: SampleBuffer::default(),
        figures: RunFigures::new(scene.record),
        recording: None,
    };
    let summary = long_call(py, progress.as_ref(), |watch| {
        let source = pipeline::Simulation::new(&scene)?;
        if let Some(path) = record {
            let output = Output {
                save: Some(path),
                ..Output::default()
            };
            let recording = RerunSink::new(&output, scene.record);
            collector.recording =
                Some(recording.map_err(|error| PipelineError::Sink(error.into()))?);
        }
        let monitor = Monitor {
            stop: &watch.stop,
            progress: &|time| {
                watch.show(time / scene.duration);
            },
        };
        pipeline::drive(
            source,
            "squeakscope.run() in Python",
            &mut collector,
            monitor,
        )
    })?;
    let found = RunResult::new(&scene, &summary, None);
    let exponents = found.exponents.as_ref().map(|found| result(py, found));
    let verdict = summary.verdict.as_deref().map(|found| result(py, found));
    let figures = collector.figures.figures();
    let fields = Fields::of(py, &found)?.drawn(move || figures.clone())?;
    Ok(Run {
        samples: Py::new(py, collector.samples.into_samples(py)?)?,
        summary: fields.finish::<RunResult<'_>>()?.unbind(),
        exponents: exponents.transpose()?.map(Bound::unbind),
        verdict: verdict.transpose()?.map(Bound::unbind),
        scene: Py::new(py, Scene(scene))?,
    })
}
