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

use serde::{Deserialize, Serialize};

use crate::analysis::{
    Column, DelayChoice, Divergence, Measures, Naming, RecurrenceImage, RecurrenceRule,
    SectionPoint, SectionShape, SpectralLine, Spectrum, Threshold, Verdict, ZeroOne,
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

/// What there is to say of the samples by themselves; amounts in the signal's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalFacts {
    /// Name of the column or channel, or of the file.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// How many samples.
    pub samples: usize,
    /// Samples a second, Hz.
    pub rate_hz: f64,
    /// Time of the first sample.
    pub start_s: f64,
    /// How long it lasts.
    pub duration_s: f64,
    /// Smallest sample.
    pub smallest: f64,
    /// Largest sample.
    pub largest: f64,
    /// Mean.
    pub mean: f64,
    /// Root mean square about the mean.
    pub deviation: f64,
}

/// The lines of the spectrum, and how they read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tones {
    /// Spacing of the bins.
    pub bin_hz: f64,
    /// Share of the power in the noise floor, 0 to 1.
    pub floor_share: f64,
    /// How the lines read.
    #[serde(flatten)]
    pub naming: Naming,
    /// Lowest difference frequency of both bases, if there are two.
    pub beat_hz: Option<f64>,
    /// The lines, strongest first.
    pub lines: Vec<NamedLine>,
}

/// A spectral line, and how well its name fits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedLine {
    /// The line with its name.
    #[serde(flatten)]
    pub line: SpectralLine,
    /// Frequency less that of the name; `None` without a name.
    pub misfit_hz: Option<f64>,
}

/// The state space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateSpace {
    /// Lag and dimension, and the curves that led to them.
    #[serde(flatten)]
    pub choice: DelayChoice,
    /// Delay.
    pub lag_s: f64,
    /// Theiler window.
    pub theiler_s: f64,
}

/// The quantified recurrence plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecurrenceReport {
    /// What counted as the same.
    #[serde(flatten)]
    pub rule: RecurrenceRule,
    /// The threshold distance, in the signal's unit; `None` if each state had its own.
    pub epsilon: Option<f64>,
    /// Every so many samples one state was taken.
    pub stride_samples: usize,
    /// How many states.
    pub states: usize,
    /// Theiler window.
    pub theiler_s: f64,
    /// The most frequent spacing of diagonals.
    pub period_s: Option<f64>,
    /// The measures, in seconds.
    #[serde(rename = "whole")]
    pub measures: Measures,
    /// Measures of a window that slides along the signal.
    pub along: Vec<MeasuresAt>,
    /// A picture that ends with the newest sample, at the distance that the threshold comes to. A rate is that of
    /// the picture itself; a number of neighbours is shown as the rate that it comes to.
    #[serde(skip)]
    pub picture: RecurrenceImage,
}

/// Measures of one window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuresAt {
    /// Centre of the window, in the file's time, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// The measures, in seconds.
    #[serde(flatten)]
    pub measures: Measures,
}

/// The delay section `y(t + lag) = level`, rising, Fig. 10.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// The level, in the signal's unit.
    pub level: f64,
    /// What the passages look like.
    #[serde(flatten)]
    pub shape: SectionShape,
    /// Mean time from one passage to the next; `None` of fewer than two.
    pub mean_return_s: Option<f64>,
    /// The passages: `t`, in the file's time, and `(y(t), y(t + 2 lag))`.
    pub passages: Vec<SectionPoint>,
}

/// Everything the laboratory can say of one signal.
///
/// Amplitudes, levels and distances are in the signal's own unit, times in seconds. Written are the
/// results; the signal itself, and what is only drawn, are not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignalReport {
    /// The signal, as analysed.
    #[serde(skip)]
    pub signal: Signal,
    /// Facts of the signal.
    #[serde(rename = "signal")]
    pub facts: SignalFacts,
    /// The kind of motion.
    pub verdict: Verdict,
    /// Amplitude spectrum of the signal.
    #[serde(skip)]
    pub spectrum: Spectrum,
    /// The lines of the spectrum.
    #[serde(rename = "spectrum")]
    pub tones: Tones,
    /// The spectrogram.
    #[serde(skip)]
    pub spectrogram: Vec<Column>,
    /// How many of the newest samples the nonlinear methods used (all, unless the signal is longer
    /// than they can take).
    pub nonlinear_samples: usize,
    /// The state space.
    pub embedding: StateSpace,
    /// The recurrence plot, quantified.
    pub recurrence: RecurrenceReport,
    /// Where the motion passes through a surface.
    pub section: Section,
    /// How nearest neighbours part (Rosenstein), in seconds.
    pub rosenstein: Divergence,
    /// How neighbourhoods part (Kantz), in seconds.
    pub kantz: Divergence,
    /// The 0-1 test.
    pub zero_one: ZeroOne,
}
