//! Recurrence plots and their quantification.

use pyo3::prelude::*;
use squeakscope::analysis::{
    AnalysisError, DelayVectors, Measures, RateBase, RecurrenceCriterion, RecurrencePlot,
    Threshold, quantify,
};
use squeakscope::memory::check;

use crate::array::{SignalArray, fields, matrix, result_with, samples};
use crate::call::long_call;
use crate::error::input;
use crate::result::result;
use crate::signal::choice;

/// Default recurrence rate.
const RATE: f64 = 0.05;

/// The threshold among the arguments, of which at most one is given.
fn threshold(
    py: Python<'_>,
    distance: Option<f64>,
    deviations: Option<f64>,
    rate: Option<f64>,
    neighbours: Option<usize>,
) -> PyResult<Threshold> {
    let given = [
        distance.map(Threshold::Distance),
        deviations.map(Threshold::Spread),
        rate.map(Threshold::Rate),
        neighbours.map(Threshold::Neighbours),
    ];
    let mut given = given.into_iter().flatten();
    match (given.next(), given.next()) {
        (None, _) => Ok(Threshold::Rate(RATE)),
        (Some(one), None) => Ok(one),
        (Some(_), Some(_)) => Err(input(
            py,
            "give one of threshold, threshold_std, recurrence_rate and neighbours",
        )),
    }
}

/// The rule of a recurrence plot.
fn rule(
    py: Python<'_>,
    norm: &str,
    threshold: Threshold,
    theiler: usize,
    line_of_identity: bool,
) -> PyResult<RecurrenceCriterion> {
    if line_of_identity && theiler > 1 {
        let message = "line_of_identity: a Theiler window above 1 excludes it; omit one of them";
        return Err(input(py, message));
    }
    Ok(RecurrenceCriterion {
        norm: choice(py, "norm", norm, &["euclidean", "maximum", "manhattan"])?,
        threshold,
        theiler: match line_of_identity {
            true => 0,
            false => theiler.max(1),
        },
    })
}

/// Recurrence plot of the delay vectors of a signal.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,). The plot needs memory for the square of the number of states.
/// lag : int
///     Lag, samples.
/// dimension : int
///     Embedding dimension.
/// threshold : float, optional
///     Distance within which two states are recurrent, in the unit of the signal.
/// threshold_std : float, optional
///     The distance in standard deviations of the signal.
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
#[pyo3(signature = (signal, *, lag=1, dimension=1, threshold=None, threshold_std=None, recurrence_rate=None,
    neighbours=None, norm="euclidean", theiler=1))]
pub fn recurrence_plot<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    lag: usize,
    dimension: usize,
    threshold: Option<f64>,
    threshold_std: Option<f64>,
    recurrence_rate: Option<f64>,
    neighbours: Option<usize>,
    norm: &str,
    theiler: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let threshold = self::threshold(py, threshold, threshold_std, recurrence_rate, neighbours)?;
    let rule = rule(py, norm, threshold, theiler, false)?;
    let samples = samples(py, &signal)?;
    let samples = &samples[..];
    let plot = long_call(py, None, |_| {
        let vectors = DelayVectors::new(samples, lag, dimension)?;
        let states = vectors.len();
        // A distance, a pixel and an element of the matrix for each pair.
        let bytes = (states as u64)
            .saturating_mul(states as u64)
            .saturating_mul(10);
        check(bytes).map_err(|shortage| AnalysisError::Memory {
            samples: samples.len(),
            shortage,
        })?;
        let mut plot = RecurrencePlot::with(rule.norm, rule.theiler);
        plot.measure(&vectors, &(0..states).collect::<Vec<_>>());
        let found = plot.recurrences(rule.threshold)?;
        Ok::<_, AnalysisError>((states, found))
    })?;
    let (states, found) = plot;
    let pixels = found.pixels.into_iter().map(|pixel| pixel > 0);
    fields(
        py,
        [
            (
                "recurrent",
                matrix(py, pixels.collect::<Vec<bool>>(), states)?,
            ),
            ("threshold", found.distance.into_pyobject(py)?),
            ("rate", found.rate.into_pyobject(py)?.into_any()),
        ],
    )
}

/// Recurrence quantification analysis of the delay vectors of a signal.
///
/// The plot is not stored: memory is linear in the number of states.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
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
/// rate : float
///     Rate of the samples, Hz. With the default, durations are in samples.
///
/// Returns
/// -------
/// Result
///     Measures of Marwan et al. (Phys. Rep. 438, 237, 2007): ``recurrence_rate``, ``determinism``,
///     ``laminarity``, ``entropy`` and more; None where a measure is not defined. ``states`` and ``threshold``.
#[pyfunction]
#[pyo3(signature = (signal, *, lag=1, dimension=1, threshold=None, threshold_std=None, recurrence_rate=None,
    neighbours=None, norm="euclidean", theiler=1, min_diagonal=2, min_vertical=2, line_of_identity=false,
    rate_base="counted", rate=1.0))]
pub fn rqa<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    lag: usize,
    dimension: usize,
    threshold: Option<f64>,
    threshold_std: Option<f64>,
    recurrence_rate: Option<f64>,
    neighbours: Option<usize>,
    norm: &str,
    theiler: usize,
    min_diagonal: usize,
    min_vertical: usize,
    line_of_identity: bool,
    rate_base: &str,
    rate: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let threshold = self::threshold(py, threshold, threshold_std, recurrence_rate, neighbours)?;
    let quantification = Quantification {
        lag,
        dimension,
        rule: rule(py, norm, threshold, theiler, line_of_identity)?,
        lines: [min_diagonal, min_vertical],
        base: base(py, rate_base)?,
        rate,
    };
    let samples = samples(py, &signal)?;
    let samples = &samples[..];
    let (measures, rule, states) = long_call(py, None, |_| quantification.of(samples))?;
    let more = [
        ("threshold", rule.threshold.distance().into_pyobject(py)?),
        ("states", states.into_pyobject(py)?.into_any()),
    ];
    result_with(py, &measures, more)
}

/// Recurrence quantification in windows along a signal.
///
/// Parameters
/// ----------
/// signal : array_like
///     Samples, shape (n,).
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
#[pyo3(signature = (signal, window, *, hop=None, lag=1, dimension=1, threshold=None, threshold_std=None,
    recurrence_rate=None, neighbours=None, norm="euclidean", theiler=1, min_diagonal=2, min_vertical=2,
    line_of_identity=false, rate_base="counted", rate=1.0, progress=None))]
pub fn rqa_windowed<'py>(
    py: Python<'py>,
    signal: SignalArray<'py>,
    window: usize,
    hop: Option<usize>,
    lag: usize,
    dimension: usize,
    threshold: Option<f64>,
    threshold_std: Option<f64>,
    recurrence_rate: Option<f64>,
    neighbours: Option<usize>,
    norm: &str,
    theiler: usize,
    min_diagonal: usize,
    min_vertical: usize,
    line_of_identity: bool,
    rate_base: &str,
    rate: f64,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let threshold = self::threshold(py, threshold, threshold_std, recurrence_rate, neighbours)?;
    let quantification = Quantification {
        lag,
        dimension,
        rule: rule(py, norm, threshold, theiler, line_of_identity)?,
        lines: [min_diagonal, min_vertical],
        base: base(py, rate_base)?,
        rate,
    };
    let hop = hop.unwrap_or(window);
    let samples = samples(py, &signal)?;
    let samples = &samples[..];
    if window == 0 || hop == 0 || window > samples.len() {
        let message = format!("window, hop: give 1 to {} samples", samples.len());
        return Err(input(py, &message));
    }
    let found = long_call(py, progress.as_ref(), |watch| {
        let mut found = Vec::new();
        for start in (0..=samples.len() - window).step_by(hop) {
            if !watch.report(start as f64 / samples.len() as f64) {
                break;
            }
            let (measures, ..) = quantification.of(&samples[start..start + window])?;
            let time = (start as f64 + 0.5 * window as f64) / rate;
            found.push(squeakscope::study::signal::MeasuresAt { time, measures });
        }
        Ok::<_, AnalysisError>(found)
    })?;
    result(py, &found)
}

fn base(py: Python<'_>, word: &str) -> PyResult<RateBase> {
    match word {
        "counted" => Ok(RateBase::Counted),
        "all" => Ok(RateBase::All),
        _ => Err(input(
            py,
            &format!("rate_base: `{word}` is not a choice; give one of counted, all"),
        )),
    }
}

/// A quantification with all of its choices.
struct Quantification {
    lag: usize,
    dimension: usize,
    rule: RecurrenceCriterion,
    /// Shortest diagonal and vertical line, states.
    lines: [usize; 2],
    base: RateBase,
    /// Rate of the samples, Hz.
    rate: f64,
}

impl Quantification {
    /// The measures of a signal, the rule with its distance, and the number of states.
    fn of(&self, samples: &[f64]) -> Result<(Measures, RecurrenceCriterion, usize), AnalysisError> {
        let vectors = DelayVectors::new(samples, self.lag, self.dimension)?;
        let rule = self.rule.fixed(&vectors)?;
        let [diagonal, vertical] = self.lines;
        let measures = quantify(&vectors, &rule)?.measures(diagonal, vertical, self.base);
        Ok((measures.in_seconds(1.0 / self.rate), rule, vectors.len()))
    }
}
