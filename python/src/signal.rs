//! Analyses of signals, one function each.

use std::path::Path;
use std::str::FromStr;

use numpy::{PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use serde::Serialize;
use squeakscope::analysis::{
    self as library, AnalysisError, DelaySearch, Direction, DivergenceMethod, DivergenceSearch,
    EventOptions, FalseNeighbourSearch, LineCriterion, RegimeSearch, SpectrumAnalyser, Stft,
    Window, ZeroOneTest, identify_lines,
};
use squeakscope::import::{
    Clock, Column, Format, ImportError, Selection, Signal, Table, read_signal,
};
use squeakscope::record::{ReadError, read_series};
use squeakscope::study::signal::{SignalOptions, SpectralLines, analyse_signal};

use crate::array::{SignalArray, array, fields, matrix, result_with, samples};
use crate::call::long_call;
use crate::error::{input, raise};
use crate::result::result;

/// Parses a word that selects one of several choices.
pub fn choice<T: FromStr>(py: Python<'_>, name: &str, word: &str, all: &[&str]) -> PyResult<T> {
    word.parse().map_err(|_| {
        let message = format!(
            "{name}: `{word}` is not a choice; give one of {}",
            all.join(", ")
        );
        input(py, &message)
    })
}

/// Checks a number of a unit above 0.
fn positive(py: Python<'_>, name: &str, value: f64) -> PyResult<f64> {
    match value > 0.0 && value.is_finite() {
        true => Ok(value),
        false => Err(input(
            py,
            &format!("{name}: give a finite number above 0, not {value}"),
        )),
    }
}

fn window(py: Python<'_>, word: &str) -> PyResult<Window> {
    match word {
        "hann" => Ok(Window::Hann),
        "blackman-harris" => Ok(Window::BlackmanHarris),
        _ => Err(input(
            py,
            &format!("window: `{word}` is not a choice; give one of hann, blackman-harris"),
        )),
    }
}

/// Computes a result of a signal and returns it with its fields.
fn analysed<'py, R: Serialize + Send>(
    py: Python<'py>,
    signal: &SignalArray<'py>,
    work: impl FnOnce(&[f64]) -> Result<R, AnalysisError> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let samples = samples(signal);
    let samples = &samples[..];
    let found = long_call(py, None, |_| work(samples))?;
    result(py, &found)
}

/// Amplitude spectrum of a signal, and its named lines.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), at least 16.
/// rate : float
///     Sampling rate, Hz.
/// window : {"blackman-harris", "hann"}
///     Window function.
///
/// Returns
/// -------
/// Result
///     ``frequency_hz`` and ``amplitude`` (one-sided, in the unit of the signal), ``lines`` with frequencies
///     interpolated between the bins and their names, ``bases``, ``broadband_share``.
#[pyfunction]
#[pyo3(signature = (signal, rate, *, window="blackman-harris"))]
pub fn spectrum<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    rate: f64,
    window: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (rate, window) = (positive(py, "rate", rate)?, self::window(py, window)?);
    let samples = samples(&signal);
    let samples = &samples[..];
    let (spectrum, lines) = long_call(py, None, |_| {
        let spectrum = SpectrumAnalyser::new(window, rate).analyse(samples)?;
        let lines = spectrum.lines(&LineCriterion::default());
        let naming = identify_lines(&lines, 0.25 * spectrum.bin);
        let lines = SpectralLines::new(&spectrum, &lines, naming);
        Ok::<_, AnalysisError>((spectrum, lines))
    })?;
    let frequency = (0..spectrum.amplitude.len()).map(|k| k as f64 * spectrum.bin);
    let arrays = [
        ("frequency_hz", array(py, frequency.collect::<Vec<f64>>())),
        ("amplitude", array(py, spectrum.amplitude)),
    ];
    result_with(py, &lines, arrays)
}

/// Spectrogram of a signal.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
/// rate : float
///     Sampling rate, Hz.
/// length : int
///     Length of the window, samples, at least 16.
/// hop : float, optional
///     Distance of two windows, samples. By default a quarter of the length.
/// window : {"hann", "blackman-harris"}
///     Window function.
///
/// Returns
/// -------
/// Result
///     ``time_s`` (centres of the windows), ``frequency_hz``, and ``amplitude`` of shape (times, frequencies).
#[pyfunction]
#[pyo3(signature = (signal, rate, *, length=1024, hop=None, window="hann"))]
pub fn spectrogram<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    rate: f64,
    length: usize,
    hop: Option<f64>,
    window: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (rate, window) = (positive(py, "rate", rate)?, self::window(py, window)?);
    let hop = positive(py, "hop", hop.unwrap_or(0.25 * length as f64))?;
    let samples = samples(&signal);
    let samples = &samples[..];
    if samples.len() < length {
        let have = samples.len();
        let message =
            format!("signal: {have} samples are shorter than the window; give at least {length}");
        return Err(input(py, &message));
    }
    let (times, bin, amplitude) = long_call(py, None, |_| {
        let (mut times, mut bin, mut amplitude) = (Vec::new(), 0.0, Vec::new());
        Stft::new(window, length, hop, rate).push(samples, |column| {
            times.push(column.centre / rate);
            bin = column.bin;
            amplitude.extend(column.amplitude);
            Ok::<(), AnalysisError>(())
        })?;
        Ok::<_, AnalysisError>((times, bin, amplitude))
    })?;
    let bins = length / 2 + 1;
    let frequency = (0..bins).map(|k| k as f64 * bin).collect::<Vec<f64>>();
    fields(
        py,
        [
            ("time_s", array(py, times)),
            ("frequency_hz", array(py, frequency)),
            ("amplitude", matrix(py, amplitude, bins)?),
        ],
    )
}

/// Tonal events of a sound: what sounds when.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), at least 0.2 s.
/// rate : float
///     Sampling rate, Hz.
/// low_hz, high_hz : float
///     Lowest and highest frequency of a fundamental, Hz.
/// full_scale : float
///     Amplitude of full scale, in the unit of the signal.
/// shortest_s : float
///     Shortest event, s.
///
/// Returns
/// -------
/// Result
///     ``events`` with start, end, frequency, level and ridge; ``hum`` and ``wow``.
#[pyfunction]
#[pyo3(signature = (signal, rate, *, low_hz=200.0, high_hz=12_000.0, full_scale=1.0, shortest_s=0.2))]
pub fn tonal_events<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    rate: f64,
    low_hz: f64,
    high_hz: f64,
    full_scale: f64,
    shortest_s: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let rate = positive(py, "rate", rate)?;
    let options = EventOptions {
        low_hz: positive(py, "low_hz", low_hz)?,
        high_hz: positive(py, "high_hz", high_hz)?,
        full_scale: positive(py, "full_scale", full_scale)?,
        shortest_s,
        ..EventOptions::default()
    };
    analysed(py, &signal, |samples| {
        library::tonal_events(samples, rate, &options)
    })
}

/// Mutual information of a signal with its delayed copy.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
/// max_lag : int, optional
///     Largest lag, samples. By default a 25th of the signal, at most 500.
/// bins : int, optional
///     Bins per axis of the joint histogram. By default 8 to 64, more for more samples.
///
/// Returns
/// -------
/// Result
///     The information in bits at each lag from 0.
#[pyfunction]
#[pyo3(signature = (signal, *, max_lag=None, bins=None))]
pub fn mutual_information<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    max_lag: Option<usize>,
    bins: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let rules = DelaySearch::for_samples(signal.len());
    let (lag, bins) = (
        max_lag.unwrap_or(rules.largest_lag),
        bins.unwrap_or(rules.bins),
    );
    analysed(py, &signal, |samples| {
        library::mutual_information(samples, lag, bins)
    })
}

/// Shares of false nearest neighbours of a delay embedding (Kennel, Brown and Abarbanel 1992).
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
/// lag : int
///     Lag, samples.
/// max_dimension : int
///     Largest embedding dimension.
/// theiler : int, optional
///     Theiler window, samples: pairs closer in time are not neighbours. By default the lag.
/// distance_ratio, size_ratio : float
///     Limits of the two criteria.
///
/// Returns
/// -------
/// Result
///     ``share`` of false neighbours for each dimension from 1.
#[pyfunction]
#[pyo3(signature = (signal, lag, *, max_dimension=10, theiler=None, distance_ratio=15.0, size_ratio=2.0))]
pub fn false_neighbours<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    lag: usize,
    max_dimension: usize,
    theiler: Option<usize>,
    distance_ratio: f64,
    size_ratio: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let search = FalseNeighbourSearch {
        distance_ratio: positive(py, "distance_ratio", distance_ratio)?,
        size_ratio: positive(py, "size_ratio", size_ratio)?,
        ..FalseNeighbourSearch::new(lag, max_dimension, theiler.unwrap_or(lag))
    };
    analysed(py, &signal, |samples| {
        library::false_neighbours(samples, &search)
    })
}

/// Choose the lag and the dimension of a delay embedding.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
///
/// Returns
/// -------
/// Result
///     Lag, dimension and Theiler window, in samples, and the curves on which the choice is based.
#[pyfunction]
pub fn choose_delay<'py>(py: Python<'py>, signal: SignalArray<'py>) -> PyResult<Bound<'py, PyAny>> {
    let search = DelaySearch::for_samples(signal.len());
    analysed(py, &signal, |samples| {
        library::choose_delay(samples, &search)
    })
}

/// Delay vectors of a signal.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
/// lag : int
///     Lag, samples.
/// dimension : int
///     Number of coordinates.
///
/// Returns
/// -------
/// numpy.ndarray
///     Read-only view of the signal, shape (n - (dimension - 1) lag, dimension).
#[pyfunction]
pub fn embed<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    lag: usize,
    dimension: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let vectors = library::DelayVectors::new(&samples(&signal), lag, dimension)
        .map(|vectors| vectors.len())
        .map_err(|error| raise(py, &error))?;
    let stride = signal.strides()[0];
    let options = pyo3::types::PyDict::new(py);
    options.set_item("writeable", false)?;
    let view = py
        .import("numpy.lib.stride_tricks")?
        .getattr("as_strided")?;
    let shape = ((vectors, dimension), (stride, stride * lag as isize));
    let view = view.call((&**signal, shape.0, shape.1), Some(&options))?;
    Ok(view.cast_into()?)
}

/// Poincare section of the delay trajectory at ``y(t + lag) = level``.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
/// lag : int
///     Lag, samples.
/// rate : float
///     Sampling rate, Hz. With the default, times are in samples.
/// level : float, optional
///     Level of the section. By default the mean of the signal.
/// dimension : int
///     Number of coordinates of a point, at least 2.
/// direction : {"rising", "falling", "both"}
///     Direction of the crossings.
///
/// Returns
/// -------
/// Result
///     ``time_s`` of the crossings, ``points`` of shape (crossings, dimension), ``level``.
#[pyfunction]
#[pyo3(signature = (signal, lag, *, rate=1.0, level=None, dimension=3, direction="rising"))]
pub fn poincare_section<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    lag: usize,
    rate: f64,
    level: Option<f64>,
    dimension: usize,
    direction: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let rate = positive(py, "rate", rate)?;
    let all = ["rising", "falling", "both"];
    let direction: Direction = choice(py, "direction", direction, &all)?;
    let samples = samples(&signal);
    let samples = &samples[..];
    let level = level.unwrap_or_else(|| library::mean(samples));
    let crossings = long_call(py, None, |_| {
        library::delay_section(samples, lag, dimension, level, direction)
    })?;
    let times = crossings.iter().map(|crossing| crossing.sample / rate);
    let times = array(py, times.collect::<Vec<f64>>());
    let points = crossings.into_iter().flat_map(|crossing| crossing.point);
    fields(
        py,
        [
            ("time_s", times),
            (
                "points",
                matrix(py, points.collect::<Vec<f64>>(), dimension)?,
            ),
            ("level", level.into_pyobject(py)?.into_any()),
        ],
    )
}

/// Largest Lyapunov exponent of a signal from the divergence of nearest neighbours.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
/// lag : int
///     Lag, samples.
/// dimension : int
///     Embedding dimension.
/// theiler : int
///     Theiler window, samples: a mean period of a flow, 1 for a map.
/// rate : float
///     Sampling rate, Hz. With the default, times are in samples.
/// method : {"rosenstein", "kantz"}
///     Distance that is followed.
/// radius : float
///     Radius of the neighbourhoods of Kantz's method, standard deviations of the signal.
/// horizon : int, optional
///     Time over which neighbours are followed, samples. By default 20 Theiler windows or lags, at most a
///     quarter of the signal.
///
/// Returns
/// -------
/// Result
///     ``curve`` of mean logarithmic distances, and its ``region``: a scaling region whose slope is the
///     exponent, or None.
#[pyfunction]
#[pyo3(signature = (signal, lag, dimension, theiler, *, rate=1.0, method="rosenstein", radius=0.05, horizon=None))]
pub fn largest_exponent<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    lag: usize,
    dimension: usize,
    theiler: usize,
    rate: f64,
    method: &str,
    radius: f64,
    horizon: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let rate = positive(py, "rate", rate)?;
    let mut search = DivergenceSearch::for_delay(lag, dimension, theiler, signal.len());
    search.horizon = horizon.unwrap_or(search.horizon);
    search.method = match method {
        "rosenstein" => DivergenceMethod::Rosenstein,
        "kantz" => DivergenceMethod::Kantz {
            radius: positive(py, "radius", radius)?,
        },
        _ => {
            let message =
                format!("method: `{method}` is not a choice; give one of rosenstein, kantz");
            return Err(input(py, &message));
        }
    };
    analysed(py, &signal, |samples| {
        Ok(library::divergence(samples, &search)?.in_seconds(rate))
    })
}

/// The 0-1 test for chaos (Gottwald and Melbourne 2009).
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
/// stride : int, optional
///     Use every ``stride``-th sample. By default the smallest stride at which the signal is not oversampled.
/// frequencies : int
///     Number of random frequencies.
/// seed : int
///     Seed of the frequencies.
///
/// Returns
/// -------
/// Result
///     ``k``, near 0 for regular and near 1 for chaotic motion.
#[pyfunction]
#[pyo3(signature = (signal, *, stride=None, frequencies=100, seed=1))]
pub fn zero_one_test<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    stride: Option<usize>,
    frequencies: usize,
    seed: u64,
) -> PyResult<Bound<'py, PyAny>> {
    analysed(py, &signal, |samples| {
        let stride = stride.unwrap_or_else(|| ZeroOneTest::recommended_stride(samples));
        let test = ZeroOneTest {
            stride,
            frequencies,
            seed,
        };
        library::zero_one(samples, &test)
    })
}

/// Classify the type of motion of a signal: periodic, quasi-periodic, chaotic, noise, transient or silent.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), at least 64; of more than 10,000 the last ones are used.
/// rate : float
///     Sampling rate, Hz.
/// silence : float
///     Amplitude below which the signal is silent, in its unit.
///
/// Returns
/// -------
/// Result
///     ``regime``, ``confidence`` and the ``evidence``.
#[pyfunction]
#[pyo3(signature = (signal, rate=1.0, *, silence=0.0))]
pub fn regime<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    rate: f64,
    silence: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let search = RegimeSearch {
        sample_rate: positive(py, "rate", rate)?,
        silence,
    };
    analysed(py, &signal, |samples| library::classify(samples, &search))
}

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
        samples: samples(&signal).into_owned(),
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

/// Resolution of time in a recording, s.
const NANOSECOND: f64 = 1e-9;

/// Reads a signal from a file, or the error of a recording.
fn read(path: &Path, selection: &Selection) -> Result<Result<Signal, ReadError>, ImportError> {
    let failed = |problem| ImportError {
        path: path.to_owned(),
        problem,
    };
    if Format::of(path).map_err(failed)? != Format::Rrd {
        return read_signal(path, selection).map(Ok);
    }
    let series = match read_series(path, selection.column.as_deref()) {
        Ok(series) => series,
        Err(error) => return Ok(Err(error)),
    };
    let table = Table {
        columns: vec![Column::new(series.name, &series.unit, series.values)],
        clock: Clock::Times {
            times: series.times,
            resolution: NANOSECOND,
        },
    };
    let rest = Selection {
        column: None,
        ..selection.clone()
    };
    table.signal(&rest).map(Ok).map_err(failed)
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
    path: std::path::PathBuf,
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
    let signal = signal.map_err(|error| raise(py, &error))?;
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
