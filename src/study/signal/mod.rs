//! Complete analysis of one signal.
//!
//! [`analyse_signal`] makes all choices by the rules of [`SignalOptions`] and reports them in the
//! [`SignalAnalysis`]. [`live_analysis`] gives the corresponding settings of the sliding analyses.
//!
//! The analysis of a long signal takes about 200 MB in addition to the samples: the spectrum is an average
//! over spans ([`MAX_SPECTRUM_SAMPLES`]), nonlinear methods use the newest samples
//! ([`MAX_NONLINEAR_SAMPLES`]), and the analyses along the signal hold one window. A signal of 30 min at 48
//! kHz, 86 million samples, needs less than 1 GB.

mod analyse;
mod live;

use serde::{Deserialize, Serialize};

use crate::analysis::{
    Column, DelayChoice, Divergence, LineIdentification, Measures, RecurrenceCriterion,
    RecurrenceImage, RecurrencePeriods, SectionPoint, SectionShape, SpectralLine, Spectrum,
    Threshold, Verdict, ZeroOne,
};
use crate::import::Signal;

pub use analyse::analyse_signal;
pub use live::{highest_frequency, live_analysis};

/// Options of a signal's analysis; the other choices follow from the signal.
///
/// | choice | rule |
/// |---|---|
/// | spectrum | Blackman-Harris window over the whole signal; with more than [`MAX_SPECTRUM_SAMPLES`] samples the RMS average over half-overlapping spans of that length; lines are named with an uncertainty of a quarter bin |
/// | spectrogram | Hann window of about `2 sqrt(N)` samples, a power of two; about 400 columns |
/// | nonlinear methods | the newest [`MAX_NONLINEAR_SAMPLES`] samples |
/// | delay, dimension, Theiler window | from [`choose_delay`](crate::analysis::choose_delay) |
/// | recurrence | Euclidean norm; recurrence rate 5 %; 12 to 23 states per delay; the newest 10,000 states; Theiler window of one delay |
/// | along the signal | up to 120 windows of 1000 states or a third of the signal |
/// | section | `y(t + lag) =` mean, rising; the newest 2000 crossings |
/// | exponents | Rosenstein and Kantz with [`DivergenceSearch::for_delay`](crate::analysis::DivergenceSearch::for_delay); Kantz radius 5 % of the standard deviation, 2 % from 50,000 samples |
/// | 0-1 test | one sample per delay, or the stride of [`ZeroOneTest::recommended_stride`](crate::analysis::ZeroOneTest::recommended_stride) if larger |
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalOptions {
    /// Delay, samples; `None` for the chosen one.
    pub lag: Option<usize>,
    /// Embedding dimension; `None` for the chosen one.
    pub dimension: Option<usize>,
    /// Recurrence threshold; `None` for a recurrence rate of 5 %.
    pub threshold: Option<Threshold>,
}

/// Maximum number of samples for the nonlinear methods; they use the newest ones.
pub const MAX_NONLINEAR_SAMPLES: usize = 50_000;

/// Maximum length of a single spectrum, samples: 87 s at 48 kHz. A longer signal is averaged over several
/// spans, so that the spectrum takes no more memory than the samples.
pub const MAX_SPECTRUM_SAMPLES: usize = 1 << 22;

/// Minimum number of samples of an analysis.
pub const MIN_SAMPLES: usize = 500;

/// Statistics of a signal's samples, in the unit of the signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalStatistics {
    /// Name of the column or channel, or of the file.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// Sample count.
    #[serde(rename = "sample_count")]
    pub samples: usize,
    /// Sample rate, Hz.
    #[serde(rename = "sample_rate_hz")]
    pub rate_hz: f64,
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Minimum of the samples.
    #[serde(rename = "minimum")]
    pub smallest: f64,
    /// Maximum of the samples.
    #[serde(rename = "maximum")]
    pub largest: f64,
    /// Mean value.
    pub mean: f64,
    /// Standard deviation.
    #[serde(rename = "standard_deviation")]
    pub deviation: f64,
}

/// The spectral lines of a signal and their names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpectralLines {
    /// Bin width of the spectrum, Hz.
    #[serde(rename = "bin_width_hz")]
    pub bin_hz: f64,
    /// Broadband share: share of the spectral power outside the lines, 0 to 1.
    pub broadband_share: f64,
    /// Fundamental frequencies and names of the lines.
    #[serde(flatten)]
    pub naming: LineIdentification,
    /// Beat frequency: the lowest difference frequency of the two fundamentals, Hz; `None` if there are not
    /// two.
    pub beat_hz: Option<f64>,
    /// Spectral lines in descending order of amplitude.
    pub lines: Vec<NamedLine>,
}

/// A spectral line and the misfit of its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedLine {
    /// The line with its name.
    #[serde(flatten)]
    pub line: SpectralLine,
    /// Misfit: frequency of the line minus that of its name, Hz; `None` without a name.
    pub misfit_hz: Option<f64>,
}

/// Delay embedding: the reconstruction of the state space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DelayEmbedding {
    /// Delay and dimension, and the curves on which the choice is based.
    #[serde(flatten)]
    pub choice: DelayChoice,
    /// Lag of the delay vectors, s.
    pub lag_s: f64,
    /// Theiler window, s.
    pub theiler_s: f64,
}

/// Recurrence analysis of a signal: quantification along the signal, and a recurrence plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecurrenceAnalysis {
    /// Recurrence rule: norm, threshold and Theiler window.
    #[serde(flatten)]
    pub rule: RecurrenceCriterion,
    /// Threshold distance epsilon, in the unit of the signal; `None` if each state has its own.
    pub epsilon: Option<f64>,
    /// Samples per state: one state is taken every `stride_samples` samples.
    pub stride_samples: usize,
    /// Number of states.
    pub states: usize,
    /// Theiler window, s.
    pub theiler_s: f64,
    /// Recurrence periods: the distances between diagonal lines, shortest first.
    #[serde(rename = "recurrence_periods")]
    pub periods: RecurrencePeriods,
    /// Recurrence measures of the newest states; times in seconds.
    pub measures: Measures,
    /// Recurrence measures in windows along the signal.
    #[serde(rename = "windows")]
    pub along: Vec<MeasuresAt>,
    /// Recurrence plot of the newest samples at the equivalent threshold. A recurrence rate is that of the
    /// picture itself; a number of neighbours is shown as its recurrence rate.
    #[serde(skip)]
    pub picture: RecurrenceImage,
}

/// Recurrence measures at the time of one window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuresAt {
    /// Centre of the window in the time of the file, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Recurrence measures of the window; times in seconds.
    #[serde(flatten)]
    pub measures: Measures,
}

/// Poincaré section of a delay embedding: `y(t + lag) = level`, rising, as in Fig. 10.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoincareSection {
    /// The level, in the unit of the signal.
    pub level: f64,
    /// Shape of the section points.
    #[serde(flatten)]
    pub shape: SectionShape,
    /// Mean return time, s; `None` with fewer than two crossings.
    #[serde(rename = "mean_return_time_s")]
    pub mean_return_s: Option<f64>,
    /// The crossings: time in the file, s, and `(y(t), y(t + 2 lag))`.
    #[serde(rename = "crossings")]
    pub passages: Vec<SectionPoint>,
}

/// Result of the analysis of a signal.
///
/// Amplitudes, levels and distances are in the unit of the signal, times in seconds. The signal itself and
/// data used only for figures are not serialised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalAnalysis {
    /// The signal.
    #[serde(skip)]
    pub signal: Signal,
    /// The signal: its unit, sample rate and statistics.
    #[serde(rename = "signal")]
    pub facts: SignalStatistics,
    /// Verdict on the regime of the motion, with its confidence.
    pub verdict: Verdict,
    /// Amplitude spectrum of the signal.
    #[serde(skip)]
    pub spectrum: Spectrum,
    /// Lines of the spectrum.
    #[serde(rename = "spectrum")]
    pub tones: SpectralLines,
    /// Columns of the spectrogram.
    #[serde(skip)]
    pub spectrogram: Vec<Column>,
    /// Number of newest samples used by the nonlinear methods: all, unless the signal has more than
    /// 50,000 ([`MAX_NONLINEAR_SAMPLES`]).
    pub nonlinear_samples: usize,
    /// Delay embedding: the reconstruction of the state space.
    pub embedding: DelayEmbedding,
    /// Recurrence quantification.
    pub recurrence: RecurrenceAnalysis,
    /// Poincaré section.
    pub section: PoincareSection,
    /// Divergence of nearest neighbours (Rosenstein), in seconds.
    pub rosenstein: Divergence,
    /// Divergence of neighbourhoods (Kantz), in seconds.
    pub kantz: Divergence,
    /// The 0-1 test for chaos.
    pub zero_one: ZeroOne,
}
