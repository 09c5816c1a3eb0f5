//! Signals of files, and their complete analysis.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use squeakscope::import::{Format, ImportError, Selection, Signal, Table, read_signal};
use squeakscope::record::{ReadError, read_series};
use squeakscope::study::signal::{SignalOptions, analyse_signal};

use crate::array::{SignalArray, array, fields, samples};
use crate::call::long_call;
use crate::result::result;
use crate::signal::positive;

/// Analyse a signal completely: events, spectrum, embedding, recurrence, section, exponents and regime.
///
/// All choices follow from the signal; :func:`read_signal` reads one from a file.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), at least 500.
/// rate : float
///     Sampling rate, Hz.
/// unit : str
///     Unit of the signal.
/// event : int, optional
///     Number of the tonal event to analyse, from 1. By default the strongest.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
#[pyfunction]
#[pyo3(signature = (signal, rate, *, unit="", event=None, progress=None))]
pub fn analyse<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    rate: f64,
    unit: &str,
    event: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let signal = Signal {
        name: "signal".to_owned(),
        unit: unit.to_owned(),
        rate: positive(py, "rate", rate)?,
        start: 0.0,
        samples: samples(py, &signal)?.into_owned(),
    };
    let options = SignalOptions {
        event,
        ..SignalOptions::default()
    };
    let found = long_call(py, progress.as_ref(), |watch| {
        analyse_signal(signal, &options, &mut |share, _| watch.report(share))
    })?;
    result(py, &found)
}

/// Why a file has no signal.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// A file of another program.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A recording of this program.
    #[error(transparent)]
    Recording(#[from] ReadError),
}

/// Reads a signal from a file.
fn read(path: &Path, selection: &Selection) -> Result<Signal, FileError> {
    let failed = |problem| ImportError {
        path: path.to_owned(),
        problem,
    };
    if Format::of(path).map_err(failed)? != Format::Rrd {
        return Ok(read_signal(path, selection)?);
    }
    let series = read_series(path, selection.column.as_deref())?;
    let table = Table::of_series(series.name, &series.unit, series.times, series.values);
    let rest = Selection {
        column: None,
        ..selection.clone()
    };
    Ok(table.signal(&rest).map_err(failed)?)
}

/// Read a signal from a file: WAV, text columns, .npy, .npz, or a recording.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     The file.
/// column : str, optional
///     Name of the column or channel, or its index from 0. By default the only one; the displacement of the probe of
///     a recording of this program.
/// rate : float, optional
///     Sampling rate of a file without a clock, Hz.
/// start, end : float, optional
///     Times between which the file is read, s.
///
/// Returns
/// -------
/// Result
///     ``samples``, ``rate_hz``, ``start_s``, ``name``, ``unit``.
#[pyfunction]
#[pyo3(name = "read_signal", signature = (path, *, column=None, rate=None, start=None, end=None))]
pub fn read_signal_file<'py>(
    py: Python<'py>,
    path: PathBuf,
    column: Option<String>,
    rate: Option<f64>,
    start: Option<f64>,
    end: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let selection = Selection {
        column,
        rate,
        from: start,
        to: end,
        max_samples: None,
    };
    let signal = long_call(py, None, |_| read(&path, &selection))?;
    fields(
        py,
        [
            ("name", signal.name.into_pyobject(py)?.into_any()),
            ("unit", signal.unit.into_pyobject(py)?.into_any()),
            ("rate_hz", signal.rate.into_pyobject(py)?.into_any()),
            ("start_s", signal.start.into_pyobject(py)?.into_any()),
            ("samples", array(py, signal.samples)),
        ],
    )
}
