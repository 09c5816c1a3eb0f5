//! Everything the laboratory can say of one signal.

use crate::analysis::{
    AnalysisError, Clusters, Column, Combination, Crossing, DelayChoice, Divergence, Line,
    Measures, Naming, RecurrenceCounts, RecurrenceRule, Spectrum, Verdict, ZeroOne,
};
use crate::import::Signal;

/// A spectral line with its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedLine {
    /// Frequency and amplitude.
    pub line: Line,
    /// Its name, if one fits.
    pub name: Option<Combination>,
    /// Frequency less that of the name, Hz.
    pub misfit: Option<f64>,
}

/// The quantified recurrence plot.
#[derive(Clone, Debug, PartialEq)]
pub struct RecurrenceReport {
    /// What counted as the same.
    pub rule: RecurrenceRule,
    /// The threshold distance, in the signal's unit; `None` if each state had its own.
    pub epsilon: Option<f64>,
    /// Every so many samples one state was taken.
    pub stride: usize,
    /// Everything counted.
    pub counts: RecurrenceCounts,
    /// The measures.
    pub measures: Measures,
    /// The most frequent spacing of diagonals, s.
    pub period: Option<f64>,
    /// Measures of a window that slides along the signal.
    pub along: Vec<MeasuresAt>,
    /// A picture of the newest part.
    pub picture: RecurrencePicture,
}

/// Measures of one window.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuresAt {
    /// Centre of the window, s.
    pub time: f64,
    /// The measures.
    pub measures: Measures,
}

/// A recurrence plot as pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct RecurrencePicture {
    /// Points along a side.
    pub size: usize,
    /// Time of the first and of the last state, s.
    pub span: [f64; 2],
    /// Distances, 0 (same) to 255 (largest), row-major, oldest first.
    pub distance: Vec<u8>,
    /// 255 recurrent, 0 not.
    pub recurrent: Vec<u8>,
}

/// Everything the laboratory can say of one signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalReport {
    /// The signal, as analysed.
    pub signal: Signal,
    /// Amplitude spectrum of the whole signal.
    pub spectrum: Spectrum,
    /// Its lines, strongest first, with their names.
    pub lines: Vec<NamedLine>,
    /// How the lines read.
    pub naming: Naming,
    /// Share of the power in the noise floor, 0 to 1.
    pub floor_share: f64,
    /// The spectrogram.
    pub spectrogram: Vec<Column>,
    /// Lag and dimension, and the curves that led to them.
    pub delay: DelayChoice,
    /// The recurrence plot, quantified.
    pub recurrence: RecurrenceReport,
    /// Passages through the delay section, Fig. 10; points `(y(t), y(t + lag), y(t + 2 lag))`.
    pub section: Vec<Crossing>,
    /// Their groups.
    pub clusters: Clusters,
    /// How nearest neighbours part (Rosenstein).
    pub rosenstein: Divergence,
    /// How neighbourhoods part (Kantz).
    pub kantz: Divergence,
    /// The 0-1 test.
    pub zero_one: ZeroOne,
    /// The kind of motion.
    pub verdict: Verdict,
    /// How many of the newest samples the nonlinear methods used (all, unless the signal is longer
    /// than they can take).
    pub nonlinear_samples: usize,
}

/// Analyses a signal; `progress` is told the share done, 0 to 1, and the step's name, and says
/// whether to go on.
///
/// # Errors
/// [`AnalysisError`].
pub fn analyse_signal(
    _signal: Signal,
    _progress: &mut dyn FnMut(f64, &'static str) -> bool,
) -> Result<Option<SignalReport>, AnalysisError> {
    unimplemented!()
}
