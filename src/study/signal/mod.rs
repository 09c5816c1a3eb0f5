//! Everything the laboratory can say of one signal.
//!
//! [`analyse_signal`] makes all choices itself, by rules that [`SignalSearch`] states, and the
//! [`SignalReport`] tells them. [`live_analysis`] says the same to the analyses that slide along
//! a stream.
//!
//! Beyond the samples themselves the analysis of a long signal takes some 200 MB: the spectrum is that of
//! spans ([`MOST_SPECTRUM`]), nonlinear methods take the newest samples ([`MOST_NONLINEAR`]), and what runs
//! along the signal holds one window. Thirty minutes at 48 kHz, 86 million samples, stay below 1 GB.

mod analyse;
mod live;

use crate::analysis::{
    Clusters, Column, Combination, Crossing, DelayChoice, Divergence, Line, Measures, Naming,
    RecurrenceCounts, RecurrenceRule, SectionShape, Spectrum, Threshold, Verdict, ZeroOne,
};
use crate::import::Signal;

pub use analyse::analyse_signal;
pub use live::{highest_frequency, live_analysis};

/// What the user fixes; the signal decides the rest.
///
/// | choice | rule |
/// |---|---|
/// | spectrum | Blackman-Harris window over the whole stretch; of more than [`MOST_SPECTRUM`] samples the root mean square over half-overlapping spans of so many; a quarter of a bin is the uncertainty with which lines are named |
/// | spectrogram | Hann window of about `2 sqrt(N)` samples, a power of two; some 400 columns |
/// | nonlinear methods | the newest [`MOST_NONLINEAR`] samples |
/// | lag, dimension, Theiler window | as [`choose_delay`](crate::analysis::choose_delay) finds them |
/// | recurrence | Euclidean norm; 5 % of the pairs; one state in so many samples that a lag has 12 to 23 of them; the newest 10,000 states; a lag apart at least |
/// | along the signal | up to 120 windows over the whole stretch, of 1000 states or a third of it |
/// | section | `y(t + lag) =` mean, rising; the newest 2000 passages |
/// | exponents | Rosenstein and Kantz as [`DivergenceSearch::for_delay`](crate::analysis::DivergenceSearch::for_delay); radius of Kantz 5 % of the deviation, 2 % from 50,000 samples on |
/// | 0-1 test | one sample a lag, or as many as [`ZeroOneTest::stride_for`](crate::analysis::ZeroOneTest::stride_for) asks for |
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalSearch {
    /// Delay, samples.
    pub lag: Option<usize>,
    /// Embedding dimension.
    pub dimension: Option<usize>,
    /// Recurrence threshold.
    pub threshold: Option<Threshold>,
}

/// At most this many of the newest samples go through the nonlinear methods.
pub const MOST_NONLINEAR: usize = 50_000;

/// The longest stretch of which one spectrum is taken, samples: 87 s at 48 kHz. That of a longer signal is
/// the mean of several, so that it takes no more memory than the samples.
pub const MOST_SPECTRUM: usize = 1 << 22;

/// Fewer samples than these say too little.
pub const FEWEST_SAMPLES: usize = 500;

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
    /// Every so many samples one state was taken; counts and measures are in states.
    pub stride: usize,
    /// Delay, states.
    pub lag: usize,
    /// Everything counted.
    pub counts: RecurrenceCounts,
    /// The measures.
    pub measures: Measures,
    /// The most frequent spacing of diagonals, s.
    pub period: Option<f64>,
    /// Measures of a window that slides along the signal.
    pub along: Vec<MeasuresAt>,
    /// A picture of the newest part.
    pub picture: RecurrenceImage,
}

/// Measures of one window.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuresAt {
    /// Centre of the window, in the file's time, s.
    pub time: f64,
    /// The measures.
    pub measures: Measures,
}

/// A recurrence plot as pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct RecurrenceImage {
    /// Points along a side.
    pub size: usize,
    /// Time of the first and of the last state, s.
    pub span: [f64; 2],
    /// Distances, 0 (same) to 255 (largest), row-major, oldest first.
    pub distance: Vec<u8>,
    /// 255 recurrent, 0 not: at the distance that the threshold comes to. A rate is that of the
    /// picture itself; a number of neighbours is shown as the rate that it comes to.
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
    /// What they look like.
    pub shape: SectionShape,
    /// Level of the section, in the signal's unit.
    pub level: f64,
    /// How nearest neighbours part (Rosenstein).
    pub rosenstein: Divergence,
    /// How neighbourhoods part (Kantz).
    pub kantz: Divergence,
    /// The 0-1 test.
    pub zero_one: ZeroOne,
    /// Every so many samples one went through the 0-1 test.
    pub zero_one_stride: usize,
    /// The kind of motion.
    pub verdict: Verdict,
    /// How many of the newest samples the nonlinear methods used (all, unless the signal is longer
    /// than they can take).
    pub nonlinear_samples: usize,
}
