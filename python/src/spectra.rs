//! Spectra, spectrograms and tonal events of signals.

use pyo3::prelude::*;
use squeakscope::analysis::{
    AnalysisError,
    events::{EventOptions, tonal_events as find_events},
    tones::{LineCriterion, SpectrumAnalyser, Stft, Window},
};
use squeakscope::study::signal::SpectralLines;

use crate::array::{choice, positive, whole};
use crate::error::input;
use crate::result::Fields;
use crate::schema::{Spectrogram, Spectrum};
use crate::signal::{analysed, computed};

const WINDOWS: [(&str, Window); 2] = [
    ("hann", Window::Hann),
    ("blackman-harris", Window::BlackmanHarris),
];

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
    signal: Bound<'py, PyAny>,
    rate: f64,
    window: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (rate, window) = (positive("rate", rate)?, choice("window", window, &WINDOWS)?);
    let (spectrum, lines) = computed(&signal, |samples| {
        let spectrum = SpectrumAnalyser::new(window, rate).analyse(samples)?;
        let lines = spectrum.lines(&LineCriterion::default());
        let lines = SpectralLines::of(&spectrum, &lines);
        Ok((spectrum, lines))
    })?;
    let frequency = (0..spectrum.amplitude.len()).map(|k| k as f64 * spectrum.bin);
    Fields::of(py, &lines)?
        .array("frequency_hz", frequency.collect::<Vec<f64>>())?
        .array("amplitude", spectrum.amplitude)?
        .finish::<Spectrum>()
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
    signal: Bound<'py, PyAny>,
    rate: f64,
    length: i64,
    hop: Option<f64>,
    window: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (rate, window) = (positive("rate", rate)?, choice("window", window, &WINDOWS)?);
    let length = whole("length", length, 16)?;
    let hop = positive("hop", hop.unwrap_or(0.25 * length as f64))?;
    let have = signal.len().unwrap_or(length);
    if have < length {
        return Err(input(format!(
            "signal: {have} samples are shorter than the window; give at least {length}"
        )));
    }
    let (times, bin, amplitude) = computed(&signal, |samples| {
        let (mut times, mut bin, mut amplitude) = (Vec::new(), 0.0, Vec::new());
        Stft::new(window, length, hop, rate).push(samples, |column| {
            times.push(column.centre / rate);
            bin = column.bin;
            amplitude.extend(column.amplitude);
            Ok::<(), AnalysisError>(())
        })?;
        Ok((times, bin, amplitude))
    })?;
    let bins = length / 2 + 1;
    let frequency = (0..bins).map(|k| k as f64 * bin).collect::<Vec<f64>>();
    Fields::new(py)
        .array("time_s", times)?
        .array("frequency_hz", frequency)?
        .matrix("amplitude", amplitude, bins)?
        .finish::<Spectrogram>()
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
///     ``events`` with kind, start, end, frequency, level and ridge; ``hum``.
#[pyfunction]
#[pyo3(signature = (signal, rate, *, low_hz=200.0, high_hz=12_000.0, full_scale=1.0, shortest_s=0.2))]
pub fn tonal_events<'py>(
    signal: Bound<'py, PyAny>,
    rate: f64,
    low_hz: f64,
    high_hz: f64,
    full_scale: f64,
    shortest_s: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let rate = positive("rate", rate)?;
    let options = EventOptions {
        low_hz: positive("low_hz", low_hz)?,
        high_hz: positive("high_hz", high_hz)?,
        full_scale: positive("full_scale", full_scale)?,
        shortest_s,
        ..EventOptions::default()
    };
    analysed(&signal, |samples| find_events(samples, rate, &options))
}
