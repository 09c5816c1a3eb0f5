//! What travels from the analysis to a sink.

use std::sync::Arc;

use serde::Serialize;

use super::frame::{Exponents, Frame};
use super::header::Header;
use super::lesson::{Course, Lesson};
use super::observation::{Observation, Parting};
use crate::analysis::{
    DelayChoice, Divergence, Measures, RecurrenceImage, SectionPoint, SpectralLine, Verdict,
    ZeroOne,
};
use crate::dynamics::{ErrorEstimate, Tally};

/// What a stage of analysis says to the sink.
#[derive(Clone, Debug)]
pub enum Record {
    /// First of all, once.
    Header(Arc<Header>),
    /// The samples themselves, every frame, in order.
    Samples(Arc<Frame>),
    /// One-sided amplitude spectrum of the velocity over a sliding window.
    Spectrum {
        /// End of the window, s.
        time: f64,
        /// Spacing of the bins, Hz; the first bin is 0 Hz.
        bin: f64,
        /// Amplitudes, m/s.
        amplitude: Vec<f64>,
        /// The strongest lines, strongest first.
        peaks: Vec<SpectralLine>,
    },
    /// One column of the spectrogram.
    SpectrogramColumn {
        /// Centre of the window, s.
        time: f64,
        /// Spacing of the bins, Hz; the first bin is 0 Hz.
        bin: f64,
        /// Level of each bin, dB relative to an amplitude of 1 mm/s (of a signal from a file:
        /// of a thousandth of its unit).
        level_db: Vec<f32>,
    },
    /// Recurrence plot of the displacement in a sliding window.
    Recurrence {
        /// End of the window, s.
        time: f64,
        /// The plot; its threshold is in m.
        image: Arc<RecurrenceImage>,
    },
    /// Trail of delay vectors in three dimensions, (u(t), u(t - lag), u(t - 2 lag)), m.
    Embedding {
        /// Time of the newest point, s.
        time: f64,
        /// Points, oldest first.
        points: Vec<[f32; 3]>,
    },
    /// Lag and dimension chosen from a sliding window of the displacement (Fig. 8).
    Delay {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// Sample spacing, s.
        dt: f64,
        /// The choice and the curves that led to it.
        choice: Arc<DelayChoice>,
    },
    /// Recurrence quantification of a sliding window of the displacement.
    Quantification {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// Spacing of the states, s: lengths of lines times this are durations.
        dt: f64,
        /// Threshold distance used, m; `None` if each state had its own.
        threshold: Option<f64>,
        /// The measures.
        measures: Measures,
        /// The most frequent spacing of diagonals, s.
        period: Option<f64>,
    },
    /// Passages through the Poincare section that have become known since the last such record, in
    /// time order; at least one.
    Section {
        /// Time of the newest sample, s. A passage is known a few samples (of a delay section:
        /// also two delays) after it.
        time: f64,
        /// The passages, in the coordinates that [`Header::section`] names.
        points: Vec<SectionPoint>,
    },
    /// How neighbours part in a sliding window of the displacement, and the 0-1 test.
    Chaos {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// Sample spacing, s.
        dt: f64,
        /// Mean log distance of neighbours, and its straight part.
        divergence: Arc<Divergence>,
        /// The 0-1 test.
        zero_one: Arc<ZeroOne>,
    },
    /// The kind of motion in a sliding window of the displacement.
    Regime {
        /// End of the window, s.
        time: f64,
        /// Length of the window, s.
        window: f64,
        /// The verdict with its evidence.
        verdict: Arc<Verdict>,
    },
    /// Lyapunov exponents of the simulated motion so far.
    Exponents(Arc<Exponents>),
    /// How far the two copies have parted.
    Parting(Parting),
    /// How the run is doing.
    Health(Health),
    /// What the run shows now; [`text::narration`](crate::text::narration) puts it into words.
    Narration {
        /// Simulated time, s.
        time: f64,
        /// What is observed.
        observation: Observation,
    },
    /// Something that was done to the run while it went on.
    Event {
        /// Simulated time, s.
        time: f64,
        /// What was done.
        text: String,
    },
    /// What the run shows of the scene's mechanism so far; [`text::LessonText`](crate::text::LessonText)
    /// puts it into words.
    Lesson(Arc<Lesson>),
    /// One point of the course of a run that shows a mechanism.
    Course(Course),
    /// Something the user should know.
    Warning {
        /// Simulated time, s.
        time: f64,
        /// The words.
        text: String,
    },
    /// Last of all, once, when the run ended well or was interrupted.
    Summary(Arc<Summary>),
}

impl Record {
    /// Whether this is a picture whole in itself, so that a later one of its kind makes it
    /// needless to someone who only watches. A spectrogram column is none: leaving it out
    /// would leave a hole in the spectrogram.
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

/// How the run is doing, over the last frame or frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    /// Simulated time, s.
    pub time: f64,
    /// Simulated seconds a second of the simulation thread; 0 where nothing is simulated.
    pub real_time_factor: f64,
    /// The largest local error of a step; `None` where there is no estimate.
    pub error: Option<ErrorEstimate>,
    /// Accepted steps per simulated millisecond.
    pub steps_per_ms: f64,
    /// Rejected steps per simulated millisecond.
    pub rejections_per_ms: f64,
    /// Right-hand-side calls per simulated millisecond.
    pub calls_per_ms: f64,
    /// Contact transitions per simulated millisecond.
    pub events_per_ms: f64,
    /// Frames waiting between simulation and analysis.
    pub frames_waiting: usize,
    /// Records waiting between analysis and recorder.
    pub records_waiting: usize,
    /// Pictures replaced by later ones so far (only when viewing without saving).
    pub drops: u64,
    /// Energy audit: largest residual of the last frame relative to the energy turned over and 1e-12 J,
    /// below which nothing is resolved; `None` where none is told.
    pub audit: Option<f64>,
}

/// What the run came to.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Simulated time, s.
    #[serde(rename = "simulated_s")]
    pub simulated: f64,
    /// Wall time of the whole run, s.
    #[serde(rename = "wall_s")]
    pub wall: f64,
    /// Simulated seconds a second of the simulation thread; 0 where nothing is simulated.
    pub real_time_factor: f64,
    /// Lines of the spectrum of the velocity (m/s) over the last window, strongest first.
    #[serde(rename = "lines")]
    pub peaks: Vec<SpectralLine>,
    /// Half the peak-to-peak displacement over the last window, m.
    #[serde(rename = "amplitude_m")]
    pub amplitude: f64,
    /// Largest speed of the probe over the last window, m/s.
    #[serde(rename = "peak_velocity_m_per_s")]
    pub peak_velocity: f64,
    /// Work of the integrator.
    #[serde(flatten)]
    pub tally: Tally,
    /// Contact transitions; of a small system, events.
    pub transitions: u64,
    /// Relative residual of the energy audit at the end; `None` where nothing was audited.
    #[serde(rename = "energy_residual")]
    pub audit: Option<f64>,
    /// The last exponents; `None` unless asked for, or if the run ended before they settled.
    // They are read together with what they come to.
    #[serde(skip)]
    pub exponents: Option<Exponents>,
    /// How far the two copies had parted at the end; `None` unless asked for.
    #[serde(rename = "butterfly")]
    pub parting: Option<Parting>,
    /// Whether the run was interrupted before its planned end.
    pub interrupted: bool,
}
