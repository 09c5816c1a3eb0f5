//! Analyses of signals, one function each.

use numpy::{PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use squeakscope::analysis::{
    self as library, AnalysisError,
    chaos::{DivergenceMethod, DivergenceSearch, ZeroOneTest},
    delay::{DelaySearch, FalseNeighbourSearch},
    poincare::Direction,
    regime::RegimeSearch,
};

use crate::array::{choice, optional, positive, vector, whole};
use crate::call::long_call;
use crate::error::raise;
use crate::result::{Fields, result, timed};
use crate::schema::Section;

/// Computes a result of a signal and returns it with its fields.
pub fn analysed<'py, R: Serialize + JsonSchema + Send>(
    signal: &Bound<'py, PyAny>,
    work: impl FnOnce(&[f64]) -> Result<R, AnalysisError> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    result(signal.py(), &computed(signal, work)?)
}

/// What follows from the samples of a signal.
pub fn computed<R: Send>(
    signal: &Bound<'_, PyAny>,
    work: impl FnOnce(&[f64]) -> Result<R, AnalysisError> + Send,
) -> PyResult<R> {
    let samples = vector("signal", signal)?;
    let samples = samples.as_slice()?;
    long_call(signal.py(), None, |_| work(samples))
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
    signal: Bound<'py, PyAny>,
    max_lag: Option<i64>,
    bins: Option<i64>,
) -> PyResult<Bound<'py, PyAny>> {
    let (lag, bins) = (optional("max_lag", max_lag, 0)?, optional("bins", bins, 1)?);
    analysed(&signal, |samples| {
        let rules = DelaySearch::for_samples(samples.len());
        let (lag, bins) = (lag.unwrap_or(rules.largest_lag), bins.unwrap_or(rules.bins));
        library::delay::mutual_information(samples, lag, bins)
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
    signal: Bound<'py, PyAny>,
    lag: i64,
    max_dimension: i64,
    theiler: Option<i64>,
    distance_ratio: f64,
    size_ratio: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let lag = whole("lag", lag, 1)?;
    let theiler = optional("theiler", theiler, 0)?.unwrap_or(lag);
    let search = FalseNeighbourSearch {
        distance_ratio: positive("distance_ratio", distance_ratio)?,
        size_ratio: positive("size_ratio", size_ratio)?,
        ..FalseNeighbourSearch::new(lag, whole("max_dimension", max_dimension, 1)?, theiler)
    };
    analysed(&signal, |samples| {
        library::delay::false_neighbours(samples, &search)
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
pub fn choose_delay<'py>(signal: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    analysed(&signal, |samples| {
        library::delay::choose_delay(samples, &DelaySearch::for_samples(samples.len()))
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
    signal: Bound<'py, PyAny>,
    lag: i64,
    dimension: i64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (lag, dimension) = (whole("lag", lag, 1)?, whole("dimension", dimension, 1)?);
    let samples = vector("signal", &signal)?;
    let vectors = library::delay::DelayVectors::new(samples.as_slice()?, lag, dimension)
        .map(|vectors| vectors.len())
        .map_err(|error| raise(&error))?;
    let stride = samples.strides()[0];
    let shape = ((vectors, dimension), (stride, stride * lag as isize));
    let tricks = py.import("numpy.lib.stride_tricks")?;
    // The shape, the strides, no subclass, not writeable.
    let view = tricks.call_method1("as_strided", (&*samples, shape.0, shape.1, false, false))?;
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
/// rate : float, optional
///     Sampling rate, Hz. Without it times are in samples, and names of fields have no ``_s``.
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
#[pyo3(signature = (signal, lag, *, rate=None, level=None, dimension=3, direction="rising"))]
pub fn poincare_section<'py>(
    py: Python<'py>,
    signal: Bound<'py, PyAny>,
    lag: i64,
    rate: Option<f64>,
    level: Option<f64>,
    dimension: i64,
    direction: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (lag, dimension) = (whole("lag", lag, 1)?, whole("dimension", dimension, 2)?);
    let per_second = positive("rate", rate.unwrap_or(1.0))?;
    let (rising, falling) = (
        ("rising", Direction::Rising),
        ("falling", Direction::Falling),
    );
    let both = ("both", Direction::Both);
    let direction = choice("direction", direction, &[rising, falling, both])?;
    let (level, crossings) = computed(&signal, |samples| {
        let level = level.unwrap_or_else(|| library::stats::mean(samples));
        Ok((
            level,
            library::poincare::delay_section(samples, lag, dimension, level, direction)?,
        ))
    })?;
    let times = crossings.iter().map(|found| found.sample / per_second);
    let times = times.collect::<Vec<f64>>();
    let points = crossings.into_iter().flat_map(|found| found.point);
    Fields::new(py)
        .array("time_s", times)?
        .matrix("points", points.collect::<Vec<f64>>(), dimension)?
        .with("level", level)?
        .timed::<Section>(rate)
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
/// rate : float, optional
///     Sampling rate, Hz. Without it times are in samples, and names of fields have no ``_s``.
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
#[pyo3(signature = (signal, lag, dimension, theiler, *, rate=None, method="rosenstein", radius=0.05, horizon=None))]
pub fn largest_exponent<'py>(
    py: Python<'py>,
    signal: Bound<'py, PyAny>,
    lag: i64,
    dimension: i64,
    theiler: i64,
    rate: Option<f64>,
    method: &str,
    radius: f64,
    horizon: Option<i64>,
) -> PyResult<Bound<'py, PyAny>> {
    let per_second = positive("rate", rate.unwrap_or(1.0))?;
    let (lag, dimension) = (whole("lag", lag, 1)?, whole("dimension", dimension, 1)?);
    let theiler = whole("theiler", theiler, 0)?;
    let horizon = optional("horizon", horizon, 1)?;
    let radius = positive("radius", radius)?;
    let kantz = DivergenceMethod::Kantz { radius };
    let methods = [
        ("rosenstein", DivergenceMethod::Rosenstein),
        ("kantz", kantz),
    ];
    let method = choice("method", method, &methods)?;
    let found = computed(&signal, |samples| {
        let mut search = DivergenceSearch::for_delay(lag, dimension, theiler, samples.len());
        search.horizon = horizon.unwrap_or(search.horizon);
        search.method = method;
        Ok(library::chaos::divergence(samples, &search)?.in_seconds(per_second))
    })?;
    timed(py, &found, rate)
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
    signal: Bound<'py, PyAny>,
    stride: Option<i64>,
    frequencies: i64,
    seed: i64,
) -> PyResult<Bound<'py, PyAny>> {
    let (stride, seed) = (optional("stride", stride, 1)?, whole("seed", seed, 0)?);
    let frequencies = whole("frequencies", frequencies, 1)?;
    analysed(&signal, |samples| {
        let stride = stride.unwrap_or_else(|| ZeroOneTest::recommended_stride(samples));
        let test = ZeroOneTest {
            stride,
            frequencies,
            seed: seed as u64,
        };
        library::chaos::zero_one(samples, &test)
    })
}

/// Classify the type of motion of a signal: periodic, quasi-periodic, chaotic, noise, transient or silent.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), at least 64; of more than 10,000 the last ones are used.
/// rate : float, optional
///     Sampling rate, Hz. Without it times and frequencies refer to samples, and names have no unit.
/// silence : float
///     Amplitude below which the signal is silent, in its unit.
/// background : float
///     Power of the background of a recording, in the square of the unit; 0 if unknown.
///
/// Returns
/// -------
/// Result
///     ``regime``, ``confidence`` and the ``evidence``.
#[pyfunction]
#[pyo3(signature = (signal, rate=None, *, silence=0.0, background=0.0))]
pub fn regime<'py>(
    py: Python<'py>,
    signal: Bound<'py, PyAny>,
    rate: Option<f64>,
    silence: f64,
    background: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let background = (background != 0.0).then(|| positive("background", background));
    let search = RegimeSearch {
        sample_rate: positive("rate", rate.unwrap_or(1.0))?,
        silence,
        background: background.transpose()?.unwrap_or(0.0),
    };
    let found = computed(&signal, |samples| {
        library::regime::classify(samples, &search)
    })?;
    timed(py, &found, rate)
}
