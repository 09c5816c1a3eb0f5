//! Signals of files, and their complete analysis.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use squeakscope::import::{Format, ImportError, Selection, Signal, Table, read_signal};
use squeakscope::plot::signal_figures;
use squeakscope::record::{ReadError, read_series};
use squeakscope::study::signal::{
    CalibrationError, CalibrationSource, SignalAnalysis, SignalError, SignalOptions, analyse_signal,
};

use crate::array::{optional, positive, vector};
use crate::call::long_call;
use crate::error::input;
use crate::result::Fields;
use crate::schema::SignalOfFile;

/// Analyse a signal completely: events, spectrum, embedding, recurrence, section, exponents and regime.
///
/// All choices follow from the signal.
///
/// Parameters
/// ----------
/// signal : array_like or str or os.PathLike
///     Samples, shape (n,), at least 500; or a file, as for :func:`read_signal`.
/// rate : float, optional
///     Sampling rate, Hz: of samples, and of a file without a clock.
/// column : str, optional
///     Column or channel of a file.
/// start, end : float, optional
///     Times between which a file is read, s.
/// calibration : str, optional
///     The level of a calibrator and its recording (``94dB=calibrator.wav``), the pressure for one unit (``12.5Pa``), or
///     the sensitivity of the microphone for a signal in V (``50mV/Pa``). The signal is converted to Pa, and the result
///     has ``sound_levels``.
/// unit : str
///     Unit of samples; a file states its own.
/// event : int, optional
///     Number of the tonal event to analyse, from 1. By default the strongest.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Result
///     The fields of ``squeakscope analyse --json``.
///
/// Raises
/// ------
/// InputError
///     If the file has no such signal, or it cannot be analysed or calibrated.
#[pyfunction]
#[pyo3(signature = (signal, rate=None, *, column=None, start=None, end=None, calibration=None, unit="", event=None,
    progress=None))]
pub fn analyse<'py>(
    py: Python<'py>,
    signal: Bound<'py, PyAny>,
    rate: Option<f64>,
    column: Option<String>,
    start: Option<f64>,
    end: Option<f64>,
    calibration: Option<&str>,
    unit: &str,
    event: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let calibration = calibration
        .map(str::parse::<CalibrationSource>)
        .transpose()
        .map_err(|error| input(format!("calibration: {error}")))?;
    let options = SignalOptions {
        event: optional("event", event, 1)?,
        ..SignalOptions::default()
    };
    let calibrator = Selection {
        column: column.clone(),
        ..Selection::default()
    };
    let path: Option<PathBuf> = signal.extract().ok();
    let given = match path {
        Some(_) => None,
        None => {
            let rate = rate.ok_or_else(|| input("rate: give the sampling rate of the samples"))?;
            let samples = vector("signal", &signal)?.as_slice()?.to_vec();
            Some(Signal {
                name: "signal".to_owned(),
                unit: unit.to_owned(),
                rate: positive("rate", rate)?,
                start: 0.0,
                samples,
            })
        }
    };
    let selection = Selection {
        column,
        rate,
        from: start,
        to: end,
        ..Selection::default()
    };
    let found = long_call(py, progress.as_ref(), |watch| {
        let signal = match (&path, given) {
            (Some(path), _) => read(path, &selection)?,
            (None, given) => given.expect("samples"),
        };
        let calibration = calibration
            .map(|source| source.calibration(&signal.unit, |path| read(path, &calibrator)))
            .transpose()?;
        let progress = &mut |share: f64, _: &str| watch.report(share);
        let options = SignalOptions {
            calibration,
            ..options
        };
        let mut found = analyse_signal(signal, &options, progress)?;
        found.file = path;
        Ok::<_, FileError>(found)
    })?;
    let fields = Fields::of(py, &found)?;
    let figures = move || signal_figures(&found);
    fields.drawn(figures)?.finish::<SignalAnalysis>()
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
    /// A signal without a calibration.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A signal that cannot be analysed.
    #[error(transparent)]
    Signal(#[from] SignalError),
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

/// Read a signal from a file: WAV, FLAC, MP3, AAC, M4A, Ogg, AIFF, text columns, .uff, .npy, .npz, .mat, or a recording.
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
/// skip_lines : int
///     Number of lines at the start of a text that are left out.
///
/// Returns
/// -------
/// Result
///     ``samples``, ``rate_hz``, ``start_s``, ``name``, ``unit``.
#[pyfunction]
#[pyo3(name = "read_signal", signature = (path, *, column=None, rate=None, start=None, end=None, skip_lines=0))]
pub fn read_signal_file<'py>(
    py: Python<'py>,
    path: PathBuf,
    column: Option<String>,
    rate: Option<f64>,
    start: Option<f64>,
    end: Option<f64>,
    skip_lines: u64,
) -> PyResult<Bound<'py, PyAny>> {
    let selection = Selection {
        column,
        rate,
        from: start,
        to: end,
        skip_lines,
        ..Selection::default()
    };
    let signal = long_call(py, None, |_| read(&path, &selection))?;
    Fields::new(py)
        .with("name", signal.name)?
        .with("unit", signal.unit)?
        .with("rate_hz", signal.rate)?
        .with("start_s", signal.start)?
        .array("samples", signal.samples)?
        .finish::<SignalOfFile>()
}
