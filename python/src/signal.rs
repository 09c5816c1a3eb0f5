//! Analyses of signals, one function each.

use std::str::FromStr;

use numpy::{PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use serde::Serialize;
use squeakscope::analysis::{
    self as library, AnalysisError, DelaySearch, Direction, DivergenceMethod, DivergenceSearch,
    FalseNeighbourSearch, RegimeSearch, ZeroOneTest,
};

use crate::array::{SignalArray, array, fields, matrix, samples};
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
pub fn positive(py: Python<'_>, name: &str, value: f64) -> PyResult<f64> {
    match value > 0.0 && value.is_finite() {
        true => Ok(value),
        false => Err(input(
            py,
            &format!("{name}: give a finite number above 0, not {value}"),
        )),
    }
}

/// Computes a result of a signal and returns it with its fields.
pub fn analysed<'py, R: Serialize + Send>(
    py: Python<'py>,
    signal: &SignalArray<'py>,
    work: impl FnOnce(&[f64]) -> Result<R, AnalysisError> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let samples = samples(py, signal)?;
    let samples = &samples[..];
    let found = long_call(py, None, |_| work(samples))?;
    result(py, &found)
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
    let vectors = library::DelayVectors::new(&samples(py, &signal)?, lag, dimension)
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
    let samples = samples(py, &signal)?;
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
        background: 0.0,
    };
    analysed(py, &signal, |samples| library::classify(samples, &search))
}
