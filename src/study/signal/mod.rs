//! Complete analysis of one signal.
//!
//! [`analyse_signal`] makes all choices by the rules of [`SignalOptions`] and reports them in the
//! [`SignalAnalysis`]. [`live_analysis`] gives the corresponding settings of the sliding analyses.
//!
//! Of a sound, the tonal events are found first ([`MeasuredSound`]): what sounds when. Spectrum, embedding,
//! recurrence, exponents and the type of motion then belong to the longest stationary stretch of one event
//! ([`AnalysedStretch`]), along its ridge where the frequency drifts. They belong to the whole signal if
//! there is no tone within 40 dB of the recording and no event is requested, or if the sample rate is not that
//! of sound. An analysis whose assumptions do not hold is skipped, and says why ([`Outcome`]).
//!
//! The analysis of a long signal takes about 200 MB in addition to the samples: the spectrum is an average
//! over spans ([`MAX_SPECTRUM_SAMPLES`]), nonlinear methods use the newest samples
//! ([`MAX_NONLINEAR_SAMPLES`]), and the analyses along the signal hold one window. A signal of 30 min at 48
//! kHz, 86 million samples, needs less than 1 GB.

mod analyse;
mod calibration;
mod files;
mod live;
pub(crate) mod report;
mod sound;
mod stretch;
#[cfg(feature = "table")]
mod table;
mod truth;

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::{
    AnalysisError,
    chaos::{Divergence, ZeroOne},
    delay::DelayChoice,
    events::TonalEvent,
    levels::{Calibration, LevelReference},
    poincare::{SectionPoint, SectionShape},
    recurrence::{
        Measures, Norm, RecurrenceCriterion, RecurrenceImage, RecurrencePeriods, Threshold,
    },
    regime::Verdict,
    tones::{Column, LineIdentification, SpectralLine, Spectrum},
};
use crate::import::Signal;
use crate::study::Stopped;

pub use analyse::analyse_signal;
pub use calibration::{CalibratedLevels, CalibrationError, CalibrationSource};
pub use files::{AnalysedFiles, FailedFile};
pub use live::{FREQUENCY_MARGIN, live_analysis};
pub use sound::{MeasuredSound, SOUND_RATES_HZ};
#[cfg(feature = "table")]
pub use table::write_events;
pub use truth::{Score, TotalScore};

/// Options of a signal's analysis; the other choices follow from the signal.
///
/// | choice | rule |
/// |---|---|
/// | tonal events | searched at sample rates from 8 to 192 kHz ([`SOUND_RATES_HZ`]) in at least 0.2 s, from 200 Hz to 12 kHz |
/// | analysed stretch | of the event with the largest energy (mean power times duration) among those at most 40 dB below the level of the recording, or of [`SignalOptions::event`]: the longest interval in which the level, averaged over 0.2 s, stays within 6 dB, without clipped samples and dropouts where half of it remains, and of more than 2^20 samples the last; the whole signal without such an event, or if the stretch reaches within 0.1 s (a tenth of a short signal) of its ends and needs neither filter nor demodulation |
/// | filter | if more than 1 % of the power is outside: from a third of the lowest fundamental that sounds in the stretch to half a harmonic above the highest harmonic, the harmonics counted as odd ones |
/// | demodulation | if the fundamental drifts by more than 0.05 % and four bins of the stretch: [`demodulate`](crate::analysis::events::demodulate) along the ridge |
/// | skipped | all nonlinear methods without a stationary stretch of 40 periods and 500 samples; exponents and 0-1 test with clipped samples in the stretch, in noise or a transient; the verdict *noise* if there are events |
/// | spectrum | Blackman-Harris window over the whole stretch; with more than [`MAX_SPECTRUM_SAMPLES`] samples the RMS average over half-overlapping spans of that length; lines are named with an uncertainty of a quarter bin |
/// | spectrogram | of the whole signal: Hann window of about `2 sqrt(N)` samples, a power of two; about 400 columns |
/// | nonlinear methods | of the stretch the newest [`MAX_NONLINEAR_SAMPLES`] samples |
/// | type of motion | [`classify`](crate::analysis::regime::classify) of the whole stretch |
/// | delay, dimension, Theiler window | from [`choose_delay`](crate::analysis::delay::choose_delay) |
/// | interpolation | for recurrence and section, band-limited, to at least 8 samples per period of the highest line of a hundredth of the strongest one; not of more than 2^20 samples |
/// | recurrence | Euclidean norm and lines of at least 2 states unless given; recurrence rate 5 %; 12 to 23 states per delay; the newest 10,000 states; Theiler window of one delay |
/// | along the stretch | up to 120 windows of 1000 states or a third of the stretch |
/// | section | `y(t + lag) =` mean, rising; the newest 2000 crossings |
/// | exponents | Rosenstein and Kantz with [`DivergenceSearch::for_delay`](crate::analysis::chaos::DivergenceSearch::for_delay); Kantz radius 5 % of the standard deviation, 2 % from 50,000 samples |
/// | 0-1 test | one sample per delay, or the stride of [`ZeroOneTest::recommended_stride`](crate::analysis::chaos::ZeroOneTest::recommended_stride) if larger |
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalOptions {
    /// Delay, samples; `None` for the chosen one.
    pub lag: Option<usize>,
    /// Embedding dimension; `None` for the chosen one.
    pub dimension: Option<usize>,
    /// Recurrence threshold; `None` for a recurrence rate of 5 %.
    pub threshold: Option<Threshold>,
    /// Norm of the distance of two states in recurrence analysis.
    pub norm: Norm,
    /// Theiler window of recurrence analysis, samples; 0 counts the line of identity. `None` for the delay.
    pub theiler: Option<usize>,
    /// Shortest diagonal line of recurrence quantification, states; `None` for 2.
    pub min_diagonal: Option<usize>,
    /// Shortest vertical line of recurrence quantification, states; `None` for 2.
    pub min_vertical: Option<usize>,
    /// Number of the event to analyse, from 1; `None` for the strongest.
    pub event: Option<usize>,
    /// Whether to list events more than 40 dB below the recording, too.
    pub faint: bool,
    /// Calibration that converts the signal to Pa; `None` if there is none.
    pub calibration: Option<Calibration>,
}

/// Error of a signal's analysis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SignalError {
    /// An analysis failed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// The caller stopped it.
    #[error("stopped")]
    Stopped(#[from] Stopped),
    /// The requested event does not exist.
    #[error("there is no event {number}: {}", available(*found))]
    NoEvent {
        /// Number of the requested event.
        number: usize,
        /// Number of events found.
        found: usize,
    },
    /// Tonal events are not searched in such a signal.
    #[error(
        "tonal events are searched only in sound: sample rates from {} to {} Hz and at least 0.2 s; omit \
         the event",
        SOUND_RATES_HZ.start(), SOUND_RATES_HZ.end()
    )]
    NotSound,
}

/// The events that can be requested.
fn available(found: usize) -> String {
    match found {
        0 => "no tonal event was found; omit the event to analyse the whole signal".to_owned(),
        1 => "one tonal event was found; give 1".to_owned(),
        _ => format!("{found} tonal events were found; give 1 to {found}"),
    }
}

/// Outcome of an analysis: its result, or the reason why it was skipped. In JSON it is the result itself,
/// or an object with the field `skipped`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Outcome<T> {
    /// The result.
    Computed(T),
    /// An assumption of the analysis does not hold.
    Skipped {
        /// Reason why the analysis was skipped.
        skipped: SkipReason,
    },
}

/// Reason why an analysis was skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, thiserror::Error)]
#[serde(rename_all = "kebab-case")]
pub enum SkipReason {
    /// The event has no stationary stretch of sufficient length.
    #[error("the event has no stationary stretch of sufficient length")]
    NotStationary,
    /// The analysed stretch contains clipped samples.
    #[error("the stretch contains clipped samples")]
    Clipped,
    /// There are tonal events, but the noise in the analysed stretch hides the motion.
    #[error("the noise in the stretch hides the motion")]
    Noise,
    /// The motion is a transient.
    #[error("the motion is a transient, so averages over time are meaningless")]
    Transient,
    /// The signal is constant, or constant with dither of one step of its resolution.
    #[error("the signal is constant")]
    Silent,
}

impl<T> Outcome<T> {
    /// Computes a result unless there is a reason to skip it.
    ///
    /// # Errors
    /// Those of `compute`.
    pub fn unless<E>(
        reason: Option<SkipReason>,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<Self, E> {
        match reason {
            Some(skipped) => Ok(Self::Skipped { skipped }),
            None => compute().map(Self::Computed),
        }
    }

    /// Computes another result from this one; if this one was skipped, so is the other.
    ///
    /// # Errors
    /// Those of `compute`.
    pub fn try_map<U, E>(&self, compute: impl FnOnce(&T) -> Result<U, E>) -> Result<Outcome<U>, E> {
        match self {
            Self::Computed(result) => compute(result).map(Outcome::Computed),
            Self::Skipped { skipped } => Ok(Outcome::Skipped { skipped: *skipped }),
        }
    }

    /// The result.
    ///
    /// # Errors
    /// The reason, if the analysis was skipped.
    pub fn get(&self) -> Result<&T, SkipReason> {
        match self {
            Self::Computed(result) => Ok(result),
            Self::Skipped { skipped } => Err(*skipped),
        }
    }
}

/// Maximum number of samples for the nonlinear methods; they use the newest ones.
pub const MAX_NONLINEAR_SAMPLES: usize = 50_000;

/// Maximum length of a single spectrum, samples: 87 s at 48 kHz. A longer signal is averaged over several
/// spans, so that the spectrum takes no more memory than the samples.
pub const MAX_SPECTRUM_SAMPLES: usize = 1 << 22;

/// Minimum number of samples of an analysis.
pub const MIN_SAMPLES: usize = 500;

/// Statistics of a signal's samples, in the unit of the signal.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SignalStatistics {
    /// Name of the column or channel, or of the file.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// Sample count.
    pub sample_count: usize,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Minimum of the samples.
    pub minimum: f64,
    /// Maximum of the samples.
    pub maximum: f64,
    /// Mean value.
    pub mean: f64,
    /// Standard deviation.
    pub standard_deviation: f64,
}

/// The spectral lines of a signal and their names.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SpectralLines {
    /// Bin width of the spectrum, Hz.
    pub bin_width_hz: f64,
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
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct NamedLine {
    /// The line with its name.
    #[serde(flatten)]
    pub line: SpectralLine,
    /// Misfit: frequency of the line minus that of its name, Hz; `None` without a name.
    pub misfit_hz: Option<f64>,
}

/// Delay embedding: the reconstruction of the state space.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
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
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RecurrenceAnalysis {
    /// Recurrence rule: norm, threshold and Theiler window.
    #[serde(flatten)]
    pub rule: RecurrenceCriterion,
    /// Threshold distance epsilon, in the unit of the signal; `None` if each state has its own.
    pub epsilon: Option<f64>,
    /// Shortest diagonal line that counts, states.
    pub min_diagonal_states: usize,
    /// Shortest vertical line that counts, states.
    pub min_vertical_states: usize,
    /// Whether the line of identity counts, as recurrent points and as a diagonal line. The recurrence rate refers to
    /// the pairs that count.
    pub line_of_identity: bool,
    /// Interpolated samples per sample: more than 1 where a line has fewer than 8 samples per period.
    pub interpolation: usize,
    /// Interpolated samples per state: one state is taken every `stride_samples`.
    pub stride_samples: usize,
    /// Delay, states.
    #[serde(skip)]
    pub lag_states: usize,
    /// Dimension of the states.
    #[serde(skip)]
    pub dimension: usize,
    /// Number of states.
    pub states: usize,
    /// Theiler window, s.
    pub theiler_s: f64,
    /// Recurrence periods: the distances between diagonal lines, shortest first.
    pub recurrence_periods: RecurrencePeriods,
    /// Recurrence measures of the newest states; times in seconds.
    pub measures: Measures,
    /// Recurrence measures in windows along the signal.
    pub windows: Vec<MeasuresAt>,
    /// Recurrence plot of the newest samples at the equivalent threshold. A recurrence rate is that of the
    /// picture itself; a number of neighbours is shown as its recurrence rate.
    #[serde(skip)]
    pub picture: RecurrenceImage,
}

/// Recurrence measures at the time of one window.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MeasuresAt {
    /// Centre of the window in the time of the file, s.
    pub time_s: f64,
    /// Recurrence measures of the window; times in seconds.
    #[serde(flatten)]
    pub measures: Measures,
}

/// Poincaré section of a delay embedding: `y(t + lag) = level`, rising, as in Fig. 10.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PoincareSection {
    /// The level, in the unit of the signal.
    pub level: f64,
    /// Shape of the section points.
    #[serde(flatten)]
    pub shape: SectionShape,
    /// Mean return time, s; `None` with fewer than two crossings.
    pub mean_return_time_s: Option<f64>,
    /// The crossings: time in the file, s, and `(y(t), y(t + 2 lag))`.
    pub crossings: Vec<SectionPoint>,
}

/// The part of a signal from which spectrum, embedding, recurrence, section, exponents and verdict follow.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct AnalysedStretch {
    /// Start of the stretch in the time of the file, s.
    pub start_s: f64,
    /// End of the stretch in the time of the file, s.
    pub end_s: f64,
    /// Number of the event in the list of events, from 1; `None` for the whole signal.
    pub event: Option<usize>,
    /// Whether the stretch was demodulated along the ridge of the event: resampled so that the fundamental
    /// has the constant frequency of the event. Times within the stretch are stretched accordingly.
    pub demodulated: bool,
    /// Pass band of the filter, Hz; `None` without a filter.
    pub band_hz: Option<[f64; 2]>,
    /// Whether samples in the stretch are clipped: harmonics may then be artefacts of the recording.
    pub clipped: bool,
}

/// Result of the analysis of a signal.
///
/// Amplitudes, levels and distances are in the unit of the signal, times in seconds. The signal itself and
/// data used only for figures are not serialised.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "AnalysedFile")]
pub struct SignalAnalysis {
    /// Path of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// The signal.
    #[serde(skip)]
    pub signal: Signal,
    /// Tonal events of a sound, and the condition of the recording; `None` if the signal is not a sound.
    #[serde(flatten)]
    pub sound: Option<MeasuredSound>,
    /// The signal: its unit, sample rate and statistics.
    #[serde(rename = "signal")]
    pub facts: SignalStatistics,
    /// The analysed stretch: all further results belong to it.
    pub stretch: AnalysedStretch,
    /// The samples of the stretch, filtered and demodulated; `None` if it is the whole signal.
    #[serde(skip)]
    pub part: Option<Signal>,
    /// Verdict on the regime of the motion, with its confidence.
    pub verdict: Outcome<Verdict>,
    /// Amplitude spectrum of the stretch.
    #[serde(skip)]
    pub spectrum: Spectrum,
    /// Lines of the spectrum.
    #[serde(rename = "spectrum")]
    pub tones: SpectralLines,
    /// Columns of the spectrogram of the whole signal.
    #[serde(skip)]
    pub spectrogram: Vec<Column>,
    /// Number of newest samples used by the nonlinear methods, except for the type of motion: all, unless the stretch has
    /// more than 50,000 ([`MAX_NONLINEAR_SAMPLES`]).
    pub nonlinear_samples: usize,
    /// Delay embedding: the reconstruction of the state space.
    pub embedding: Outcome<DelayEmbedding>,
    /// Recurrence quantification.
    pub recurrence: Outcome<RecurrenceAnalysis>,
    /// Poincaré section.
    pub section: Outcome<PoincareSection>,
    /// Divergence of nearest neighbours (Rosenstein), in seconds.
    pub rosenstein: Outcome<Divergence>,
    /// Divergence of neighbourhoods (Kantz), in seconds.
    pub kantz: Outcome<Divergence>,
    /// The 0-1 test for chaos.
    pub zero_one: Outcome<ZeroOne>,
    /// Sound levels; absent without a calibration, unless the file is a sound in Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound_levels: Option<CalibratedLevels>,
    /// Events compared with labels; absent without labels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<Score>,
}

impl SignalAnalysis {
    /// The samples that were analysed: those of the stretch, or the whole signal.
    pub fn analysed(&self) -> &Signal {
        self.part.as_ref().unwrap_or(&self.signal)
    }

    /// The analysed event; `None` if the whole signal was analysed.
    pub fn event(&self) -> Option<&TonalEvent> {
        let number = self.stretch.event?;
        self.events().get(number - 1)
    }

    /// The tonal events, none if the signal is not a sound.
    pub fn events(&self) -> &[TonalEvent] {
        self.sound.as_ref().map_or(&[], |sound| &sound.tonal.events)
    }

    /// Upper frequency limit for display, Hz: `margin` times the highest line or harmonic of an event, at most the Nyquist
    /// frequency, which is also the value without lines and events.
    pub fn highest_frequency(&self, margin: f64) -> f64 {
        let nyquist = 0.5 * self.signal.rate;
        let lines = self.tones.lines.iter().map(|named| named.line.frequency);
        let harmonic = |event: &TonalEvent| event.harmonics as f64 * event.frequency_high_hz;
        let events = self.events().iter().map(harmonic);
        let highest = lines.chain(events).reduce(f64::max);
        highest.map_or(nyquist, |highest| (margin * highest).min(nyquist))
    }

    /// What the levels of the events are relative to.
    pub fn level_reference(&self) -> LevelReference {
        let sound = self.sound.as_ref();
        sound.map_or_else(LevelReference::default, |sound| sound.level_reference)
    }
}
