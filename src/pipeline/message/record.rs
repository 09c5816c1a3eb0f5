//! Messages from the analysis to a sink.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::frame::Frame;
use super::header::Header;
use super::lesson::{Lesson, LevelSample};
use super::observation::{Exponents, Observation, TrajectoryDivergence};
use crate::analysis::{
    chaos::{Divergence, ZeroOne},
    delay::DelayChoice,
    poincare::SectionPoint,
    recurrence::{Measures, RecurrenceImage, RecurrencePeriods},
    regime::Verdict,
    tones::SpectralLine,
};
use crate::dynamics::{ErrorEstimate, SolverStats};
use crate::pipeline::lesson::Fact;

/// A message of an analysis stage to the sink.
#[derive(Clone, Debug)]
pub enum Record {
    /// The first record of a run.
    Header(Arc<Header>),
    /// The samples of a frame, for every frame in order.
    Samples(Arc<Frame>),
    /// One-sided amplitude spectrum of the velocity in a sliding window.
    Spectrum {
        /// End of the window, s.
        time: f64,
        /// Spacing of the bins, Hz; the first bin is 0 Hz.
        bin: f64,
        /// Amplitudes, m/s.
        amplitude: Vec<f64>,
        /// Strongest spectral lines, in descending order.
        peaks: Vec<SpectralLine>,
    },
    /// One column of the spectrogram.
    SpectrogramColumn {
        /// Centre of the window, s.
        time: f64,
        /// Spacing of the bins, Hz; the first bin is 0 Hz.
        bin: f64,
        /// Level of each bin, dB re an amplitude of 1 mm/s (for a signal from a file: 1/1000 of its unit).
        level_db: Vec<f32>,
    },
    /// Recurrence plot of the displacement in a sliding window.
    Recurrence {
        /// End of the window, s.
        time: f64,
        /// The plot; its threshold is in m.
        image: Arc<RecurrenceImage>,
    },
    /// Delay vectors in three dimensions, (u(t), u(t - lag), u(t - 2 lag)), m.
    Embedding {
        /// Time of the newest point, s.
        time: f64,
        /// Points, oldest first.
        points: Vec<[f32; 3]>,
    },
    /// Delay and embedding dimension chosen from a sliding window of the displacement (Fig. 8).
    Delay {
        /// End of the window, s.
        time: f64,
        /// Sample spacing, s.
        dt: f64,
        /// The choice and the curves on which it is based.
        choice: Arc<DelayChoice>,
    },
    /// Recurrence quantification of a sliding window of the displacement.
    Quantification {
        /// End of the window, s.
        time: f64,
        /// Spacing of the states, s: it converts lengths of lines to durations.
        dt: f64,
        /// Threshold distance, m; `None` if each state has its own.
        threshold: Option<f64>,
        /// Recurrence quantification measures.
        measures: Measures,
        /// Distances between diagonal lines, s.
        periods: RecurrencePeriods,
    },
    /// New points of the Poincare section, in time order; at least one.
    Section {
        /// Time of the newest sample, s. A crossing is known a few samples after it; that of a delay section
        /// two more delays later.
        time: f64,
        /// Section points, in the coordinates given by [`Header::section`].
        points: Vec<SectionPoint>,
    },
    /// Divergence of nearby states in a sliding window of the displacement, and the 0-1 test.
    Chaos {
        /// End of the window, s.
        time: f64,
        /// Sample spacing, s.
        dt: f64,
        /// Mean logarithmic distance of nearby states, and its linear part.
        divergence: Arc<Divergence>,
        /// The 0-1 test.
        zero_one: Arc<ZeroOne>,
    },
    /// Regime of the motion in a sliding window of the displacement.
    Regime {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// The classification with its evidence.
        verdict: Arc<Verdict>,
    },
    /// Lyapunov exponents of the simulated motion so far.
    Exponents(Arc<Exponents>),
    /// Distance of the perturbed trajectory.
    TrajectoryDivergence(TrajectoryDivergence),
    /// Performance and accuracy of the run.
    Health(Health),
    /// An observation about the motion; [`text::narration`](crate::text::narration) renders it as text.
    Narration {
        /// Simulated time, s.
        time: f64,
        /// The observation.
        observation: Observation,
    },
    /// A command that was applied to the run.
    Event {
        /// Simulated time, s.
        time: f64,
        /// Description.
        text: String,
    },
    /// Measurements for the scene's mechanism so far; [`text::lesson`](crate::text::lesson) renders
    /// them as text.
    Lesson(Arc<Lesson>),
    /// Level and strongest spectral line at one instant of a run that demonstrates a mechanism.
    LevelSample(LevelSample),
    /// A warning to the user.
    Warning {
        /// Simulated time, s.
        time: f64,
        /// Text of the message.
        text: String,
    },
    /// The last record of a run that was completed or stopped by the user.
    Summary(Arc<Summary>),
}

impl Record {
    /// Whether a newer record of this kind makes the record obsolete on a display. A spectrogram column does
    /// not count: dropping it would leave a gap in the spectrogram.
    pub fn is_picture(&self) -> bool {
        matches!(
            self,
            Self::Spectrum { .. }
                | Self::Recurrence { .. }
                | Self::Embedding { .. }
                | Self::Delay { .. }
        )
    }
}

/// Performance and accuracy of a run over its last frame or frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    /// Simulated time, s.
    pub time: f64,
    /// Simulated time per computing time of the simulation thread; 0 if nothing is simulated.
    pub real_time_factor: f64,
    /// Largest local error of a step; `None` without an error estimate.
    pub error: Option<ErrorEstimate>,
    /// Accepted steps per simulated millisecond.
    pub steps_per_ms: f64,
    /// Rejected steps per simulated millisecond.
    pub rejections_per_ms: f64,
    /// Right-hand-side evaluations per simulated millisecond.
    pub rhs_evals_per_ms: f64,
    /// Contact transitions per simulated millisecond.
    pub events_per_ms: f64,
    /// Number of frames in the channel from the simulation to the analysis.
    pub frames_waiting: usize,
    /// Number of records in the channel from the analysis to the recorder.
    pub records_waiting: usize,
    /// Number of pictures replaced by newer ones so far (only if the run is displayed but not saved).
    pub drops: u64,
    /// Energy audit: largest residual of the last frame relative to the largest energy so far plus 1e-12 J,
    /// the absolute tolerance; `None` without energy samples.
    pub audit: Option<f64>,
}

/// Results of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Summary {
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Wall time of the whole run, s.
    pub wall_s: f64,
    /// Simulated time per computing time of the simulation thread; 0 if nothing is simulated.
    pub real_time_factor: f64,
    /// Spectral lines of the velocity (m/s) in the last window, in descending order.
    pub lines: Vec<SpectralLine>,
    /// Half the peak-to-peak displacement in the last window, m.
    pub amplitude_m: f64,
    /// Peak velocity of the probe in the last window, m/s.
    pub peak_velocity_m_per_s: f64,
    /// Whether the vibration is at rest in the last window: its peak velocity is below the limit of the scene, and
    /// it has no lines.
    pub at_rest: bool,
    /// Whether the joint is quiet in the last window: its peak velocity is below 1 % of the sliding speed.
    pub quiet: bool,
    /// Type of motion at the end: `at rest`; or the type of the attractor, if Lyapunov exponents decide on it, such as
    /// `periodic`, `quasi-periodic`, `chaotic` or `fixed point`; or else the type by the last classification of the
    /// displacement. `None` if the run is too short.
    pub motion: Option<String>,
    /// Confidence of a classification, 0 to 1; `None` without one, and if it is undetermined.
    pub motion_confidence: Option<f64>,
    /// Last classification of the displacement, requested by the scene or of the end of the run; `None` if the run is too
    /// short.
    #[serde(skip)]
    pub verdict: Option<Arc<Verdict>>,
    /// Solver statistics.
    #[serde(flatten)]
    pub stats: SolverStats,
    /// Contact transitions; for a small system, events.
    pub transitions: u64,
    /// Relative residual of the energy audit at the end; `None` without an audit.
    pub energy_residual: Option<f64>,
    /// Last Lyapunov exponents; `None` if not requested, or if the run ended before averaging started.
    // Printed together with the attractor that they indicate.
    #[serde(skip)]
    pub exponents: Option<Exponents>,
    /// Final distance of the perturbed trajectory; `None` if not requested.
    pub divergence: Option<TrajectoryDivergence>,
    /// Facts of the lesson at the end of the run; empty for a scene without a mechanism.
    pub facts: Vec<Fact>,
    /// Mean rate of the displayed analysis: share of its windows that was computed; `None` if all were, without a
    /// budget.
    pub analysis_rate: Option<f64>,
    /// Whether the run was stopped before its planned end.
    pub interrupted: bool,
}

impl Summary {
    /// Type of motion with its confidence, and whether the joint is quiet; `None` if the run is too short.
    pub fn describe_motion(&self) -> Option<String> {
        let confidence = self.motion_confidence;
        let confidence = confidence.map(|share| format!(", confidence {:.0} %", 100.0 * share));
        let quiet = if self.quiet {
            "; the joint is quiet"
        } else {
            ""
        };
        let motion = self.motion.as_ref()?;
        Some(format!("{motion}{}{quiet}", confidence.unwrap_or_default()))
    }
}
