//! Recurrence plots and their quantification.

use std::ops::Range;

use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use squeakscope::analysis::{
    AnalysisError,
    delay::DelayVectors,
    recurrence::{Measures, Norm, RateBase, RecurrenceCriterion, Recurrences, Threshold},
};

use crate::array::{check_names, choice, numeric, optional, options, positive, vector, whole};
use crate::call::{Watch, long_call};
use crate::error::input;
use crate::result::{Fields, timed};
use crate::schema::{Plot, Quantified};

/// Default recurrence rate.
const RATE: f64 = 0.05;

options! {
    /// What recurs, as the caller gives it.
    Choices {
        lag: i64 = 1,
        dimension: i64 = 1,
        threshold: Option<f64> = None,
        threshold_std: Option<f64> = None,
        recurrence_rate: Option<f64> = None,
        neighbours: Option<i64> = None,
        norm: String = "euclidean".to_owned(),
        theiler: i64 = 1,
    }
}

options! {
    /// How the lines are counted, as the caller gives it.
    Counting {
        min_diagonal: i64 = 2,
        min_vertical: i64 = 2,
        line_of_identity: bool = false,
        rate_base: String = "counted".to_owned(),
        rate: Option<f64> = None,
    }
}

/// A signal or states.
struct States {
    /// Samples, or states one after another.
    values: Vec<f64>,
    /// Number of coordinates of given states; `None` for samples.
    columns: Option<usize>,
    lag: usize,
    dimension: usize,
}

impl States {
    fn new(name: &str, signal: &Bound<'_, PyAny>, choices: &Choices) -> PyResult<Self> {
        let lag = whole("lag", choices.lag, 1)?;
        let dimension = whole("dimension", choices.dimension, 1)?;
        let array = numeric(name, signal)?;
        let columns = match *array.shape() {
            [_, columns] => Some(columns),
            _ => None,
        };
        if columns.is_some() && (lag, dimension) != (1, 1) {
            return Err(input(
                "lag, dimension: states of several coordinates have no delays; omit both, or give one column",
            ));
        }
        let flat = if columns.is_some() {
            array.call_method0("ravel")?
        } else {
            signal.clone()
        };
        Ok(Self {
            values: vector(name, &flat)?.as_slice()?.to_vec(),
            columns,
            lag,
            dimension,
        })
    }

    /// Number of samples or states given.
    fn len(&self) -> usize {
        self.values.len() / self.columns.unwrap_or(1).max(1)
    }

    /// Calls `work` with the vectors of a part of the signal. States are delay vectors whose lag is their number.
    fn with_vectors<T>(
        &self,
        part: Range<usize>,
        watch: &Watch,
        work: impl FnOnce(&DelayVectors<'_>) -> Result<T, AnalysisError>,
    ) -> Result<T, AnalysisError> {
        let Some(columns) = self.columns else {
            let vectors = DelayVectors::new(&self.values[part], self.lag, self.dimension)?;
            return work(&vectors.with_stop(&watch.stop));
        };
        let column = |c: usize| part.clone().map(move |row| self.values[row * columns + c]);
        let turned: Vec<f64> = (0..columns).flat_map(column).collect();
        work(&DelayVectors::new(&turned, part.len(), columns)?.with_stop(&watch.stop))
    }
}

/// Signals and their recurrences.
struct Recurrence {
    states: States,
    /// The second signal of a cross recurrence.
    other: Option<States>,
    rule: RecurrenceCriterion,
}

impl Recurrence {
    fn new(
        signal: &Bound<'_, PyAny>,
        other: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
        identity: bool,
    ) -> PyResult<Self> {
        let choices = Choices::of(options)?;
        let neighbours = optional("neighbours", choices.neighbours, 1)?;
        let given = [
            choices.threshold.map(Threshold::Distance),
            choices.threshold_std.map(Threshold::Spread),
            choices.recurrence_rate.map(Threshold::Rate),
            neighbours.map(Threshold::Neighbours),
        ];
        let mut given = given.into_iter().flatten();
        let threshold = given.next().unwrap_or(Threshold::Rate(RATE));
        if given.next().is_some() {
            return Err(input(
                "give one of threshold, threshold_std, recurrence_rate and neighbours",
            ));
        }
        let theiler = whole("theiler", choices.theiler, 0)?;
        if identity && theiler > 1 {
            return Err(input(
                "line_of_identity: a Theiler window above 1 excludes it; omit one of them",
            ));
        }
        let norms = [
            ("euclidean", Norm::Euclidean),
            ("maximum", Norm::Maximum),
            ("manhattan", Norm::Manhattan),
        ];
        let states = States::new("signal", signal, &choices)?;
        let other = other
            .map(|other| States::new("other", other, &choices))
            .transpose()?;
        if let Some(other) = other
            .as_ref()
            .filter(|other| other.columns != states.columns)
        {
            let [here, there] = [&states, other].map(|states| states.columns.unwrap_or(1));
            return Err(input(format!(
                "other: it has {there} coordinates, and the signal has {here}; give as many"
            )));
        }
        Ok(Self {
            states,
            other,
            rule: RecurrenceCriterion {
                norm: choice("norm", &choices.norm, &norms)?,
                threshold,
                theiler: if identity { 0 } else { theiler.max(1) },
            },
        })
    }

    /// Calls `work` with the recurrences of a part of the signal, or of the signal with the other one.
    fn with<T>(
        &self,
        part: Range<usize>,
        watch: &Watch,
        work: impl FnOnce(&Recurrences<'_>) -> Result<T, AnalysisError>,
    ) -> Result<T, AnalysisError> {
        self.states.with_vectors(part, watch, |first| {
            let Some(other) = &self.other else {
                return work(&Recurrences::of(first, &self.rule)?);
            };
            other.with_vectors(0..other.len(), watch, |second| {
                let RecurrenceCriterion {
                    norm, threshold, ..
                } = self.rule;
                work(&Recurrences::cross(first, second, norm, threshold)?)
            })
        })
    }
}

/// A quantification with all of its choices.
struct Quantification {
    recurrence: Recurrence,
    /// Shortest diagonal and vertical line, states.
    lines: [usize; 2],
    base: RateBase,
    /// Time between two samples, s; 1 without a rate.
    step: f64,
    rate: Option<f64>,
}

impl Quantification {
    fn new(
        signal: &Bound<'_, PyAny>,
        other: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        check_names(options, &[Choices::NAMES, Counting::NAMES])?;
        let counting = Counting::of(options)?;
        let bases = [("counted", RateBase::Counted), ("all", RateBase::All)];
        Ok(Self {
            recurrence: Recurrence::new(signal, other, options, counting.line_of_identity)?,
            lines: [
                whole("min_diagonal", counting.min_diagonal, 1)?,
                whole("min_vertical", counting.min_vertical, 1)?,
            ],
            base: choice("rate_base", &counting.rate_base, &bases)?,
            step: 1.0 / positive("rate", counting.rate.unwrap_or(1.0))?,
            rate: counting.rate,
        })
    }

    /// The measures of a part of the signal, the distance of the threshold, and the number of states.
    fn of(
        &self,
        part: Range<usize>,
        watch: &Watch,
    ) -> Result<(Measures, Option<f64>, usize), AnalysisError> {
        let [diagonal, vertical] = self.lines;
        self.recurrence.with(part, watch, |found| {
            let counts = found.counts();
            let measures = counts.measures(diagonal, vertical, self.base);
            Ok((
                measures.in_seconds(self.step),
                found.distance(),
                counts.rows,
            ))
        })
    }
}

/// Recurrence plot of the delay vectors of a signal, or of states.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), or states, shape (n, coordinates), such as ``run.q``, which are used without delays. The
///     plot needs memory for the square of the number of states.
/// other : array_like, optional
///     A second signal, or states: cross recurrence, whose rows are the states of the first and whose columns are those of
///     the second. All pairs count; standard deviations are those of the first.
/// lag : int
///     Lag, samples.
/// dimension : int
///     Embedding dimension.
/// threshold : float, optional
///     Distance within which two states are recurrent, in the unit of the signal.
/// threshold_std : float, optional
///     The distance in standard deviations of the signal, or of all coordinates together.
/// recurrence_rate : float, optional
///     The distance at which this share of all pairs is recurrent. The default, with 0.05.
/// neighbours : int, optional
///     A distance for each state, within which it has this number of neighbours.
/// norm : {"euclidean", "maximum", "manhattan"}
///     Norm of the distance.
/// theiler : int
///     Theiler window, states: closer pairs do not count for the threshold.
///
/// Returns
/// -------
/// Result
///     ``recurrent``, a boolean matrix; ``threshold``, and the recurrence ``rate``.
#[pyfunction]
#[pyo3(signature = (signal, other=None, **options), text_signature = "(signal, other=None, *, lag=1, dimension=1, \
    threshold=None, threshold_std=None, recurrence_rate=None, neighbours=None, norm='euclidean', theiler=1)")]
pub fn recurrence_plot<'py>(
    py: Python<'py>,
    signal: Bound<'py, PyAny>,
    other: Option<Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    check_names(options, &[Choices::NAMES])?;
    let recurrence = Recurrence::new(&signal, other.as_ref(), options, false)?;
    let all = 0..recurrence.states.len();
    let plot = |found: &Recurrences<'_>| {
        let matrix = found.matrix()?;
        Ok((matrix, found.counts(), found.distance()))
    };
    let (matrix, counts, distance) =
        long_call(py, None, |watch| recurrence.with(all, watch, plot))?;
    Fields::new(py)
        .matrix("recurrent", matrix, counts.columns)?
        .with("threshold", distance)?
        .with(
            "rate",
            counts.recurrent as f64 / counts.pairs().max(1) as f64,
        )?
        .finish::<Plot>()
}

/// Recurrence quantification analysis of the delay vectors of a signal, or of states.
///
/// The plot is not stored: memory is linear in the number of states.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), or states, shape (n, coordinates).
/// other : array_like, optional
///     A second signal, or states: cross recurrence, as in :func:`recurrence_plot`.
/// lag : int
///     Lag, samples.
/// dimension : int
///     Embedding dimension.
/// threshold, threshold_std, recurrence_rate, neighbours : optional
///     One of them, as in :func:`recurrence_plot`.
/// norm : {"euclidean", "maximum", "manhattan"}
///     Norm of the distance.
/// theiler : int
///     Theiler window, states: pairs with ``|i - j| < theiler`` do not count. 1 excludes the line of identity.
/// min_diagonal, min_vertical : int
///     Shortest diagonal and vertical line, states.
/// line_of_identity : bool
///     Whether the line of identity counts: as recurrent points, and as a diagonal line.
/// rate_base : {"counted", "all"}
///     Pairs to which the recurrence rate refers: those outside the Theiler window, or all of them.
/// rate : float, optional
///     Rate of the samples, Hz. Without it durations are in samples, and names of fields have no ``_s``.
///
/// Returns
/// -------
/// Result
///     Measures of Marwan et al. (Phys. Rep. 438, 237, 2007): ``recurrence_rate``, ``determinism``,
///     ``laminarity``, ``entropy`` and more; None where a measure is not defined. ``states`` and ``threshold``.
#[pyfunction]
#[pyo3(signature = (signal, other=None, **options), text_signature = "(signal, other=None, *, lag=1, dimension=1, \
    threshold=None, threshold_std=None, recurrence_rate=None, neighbours=None, norm='euclidean', theiler=1, \
    min_diagonal=2, min_vertical=2, line_of_identity=False, rate_base='counted', rate=None)")]
pub fn rqa<'py>(
    py: Python<'py>,
    signal: Bound<'py, PyAny>,
    other: Option<Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let quantification = Quantification::new(&signal, other.as_ref(), options)?;
    let all = 0..quantification.recurrence.states.len();
    let (measures, distance, states) = long_call(py, None, |watch| quantification.of(all, watch))?;
    Fields::of(py, &measures)?
        .with("threshold", distance)?
        .with("states", states)?
        .timed::<Quantified>(quantification.rate)
}

/// Recurrence quantification in windows along a signal.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,), or states, shape (n, coordinates).
/// window : int
///     Length of a window, samples.
/// hop : int, optional
///     Distance of two windows, samples. By default the length of a window.
/// **options
///     As for :func:`rqa`. A threshold other than a distance holds in each window by itself.
/// progress : callable, optional
///     Called with the share of the work that is done, 0 to 1.
///
/// Returns
/// -------
/// Results
///     The measures of each window, with the time of its centre.
#[pyfunction]
#[pyo3(signature = (signal, window, *, hop=None, progress=None, **options), text_signature = "(signal, window, *, hop=None, \
    lag=1, dimension=1, threshold=None, threshold_std=None, recurrence_rate=None, neighbours=None, norm='euclidean', \
    theiler=1, min_diagonal=2, min_vertical=2, line_of_identity=False, rate_base='counted', rate=None, progress=None)")]
pub fn rqa_windowed<'py>(
    py: Python<'py>,
    signal: Bound<'py, PyAny>,
    window: i64,
    hop: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let quantification = Quantification::new(&signal, None, options)?;
    let window = whole("window", window, 1)?;
    let hop = optional("hop", hop, 1)?.unwrap_or(window);
    let samples = quantification.recurrence.states.len();
    if window > samples {
        return Err(input(format!("window: give 1 to {samples} samples")));
    }
    let found = long_call(py, progress.as_ref(), |watch| {
        let mut found = Vec::new();
        for start in (0..=samples - window).step_by(hop) {
            if watch.report(start as f64 / samples as f64).is_err() {
                break;
            }
            let (measures, ..) = quantification.of(start..start + window, watch)?;
            let time = (start as f64 + 0.5 * window as f64) * quantification.step;
            found.push(squeakscope::study::signal::MeasuresAt {
                time_s: time,
                measures,
            });
        }
        Ok::<_, AnalysisError>(found)
    })?;
    timed(py, &found, quantification.rate)
}
