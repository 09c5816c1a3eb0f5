//! The validated scene.

use crate::joint::JointSpec;
use crate::scene::Schedule;

/// A validated scene. SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name, as in `squeakscope run NAME`.
    pub name: String,
    /// One line that says what the scene shows.
    pub title: String,
    /// A few sentences (Markdown): what to look for.
    pub about: String,
    /// The scene's whole text as read, with what the command line changed at its end as comments.
    pub text: String,
    /// The joint.
    pub joint: JointSpec,
    /// Tilt of the load, rad, as a function of time.
    pub tilt: Schedule,
    /// How the run starts.
    pub start: Start,
    /// Simulated time, s.
    pub duration: f64,
    /// Samples a second, Hz.
    pub sample_rate: f64,
    /// Samples a frame.
    pub frame_samples: usize,
    /// The integrator.
    pub integrator: Integrator,
    /// Which analyses run.
    pub analysis: AnalysisSpec,
    /// What is recorded, and how often.
    pub record: RecordSpec,
}

/// The initial state: at the steady-sliding equilibrium with a random kick of the modal velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Standard deviation of each modal velocity, sqrt(kg) m/s; zero means exactly at rest.
    pub kick: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Integrator and its accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    /// The method.
    pub method: Method,
    /// Relative tolerance of adaptive methods.
    pub tolerance: f64,
    /// Step of fixed-step methods, and the largest step of adaptive ones, s.
    pub max_step: f64,
}

/// The choice of integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Exponential (Lawson) pair of order 5(4): the linear modal part is exact.
    Lawson54,
    /// Plain embedded pair of order 5(4).
    Tsit54,
    /// Classical Runge-Kutta of order 4, fixed step.
    Rk4,
}

/// Analyses; an absent one is not computed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnalysisSpec {
    /// Sliding amplitude spectrum of the probe's velocity.
    pub spectrum: Option<SpectrumSpec>,
    /// Spectrogram of the probe's velocity.
    pub spectrogram: Option<SpectrogramSpec>,
    /// Recurrence plot of the probe's displacement.
    pub recurrence: Option<RecurrenceSpec>,
}

/// Sliding spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumSpec {
    /// Length of the window, s.
    pub window: f64,
    /// Time between spectra, s.
    pub every: f64,
}

/// Spectrogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrogramSpec {
    /// Length of the window, s.
    pub window: f64,
    /// Time between columns, s.
    pub every: f64,
    /// Highest frequency kept, Hz.
    pub max_frequency: f64,
}

/// Evolving recurrence plot in a sliding window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecurrenceSpec {
    /// Length of the window, s.
    pub window: f64,
    /// Points along a side.
    pub size: usize,
    /// Time between plots, s.
    pub every: f64,
    /// Delay `tau` of Eq. (25), s.
    pub lag: f64,
    /// Embedding dimension `m` of Eq. (25).
    pub dimension: usize,
    /// Threshold `epsilon` of Eq. (26).
    pub threshold: RecurrenceThreshold,
}

/// How the threshold of Eq. (26) is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecurrenceThreshold {
    /// A distance, m.
    Distance(f64),
    /// The distance at which this share of the pairs is recurrent, 0 to 1.
    Rate(f64),
}

/// What is recorded and how often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordSpec {
    /// Snapshots of the contact patch a second, Hz.
    pub patch_rate: f64,
    /// Snapshots of the deforming body a second, Hz.
    pub body_rate: f64,
    /// Energy samples a second, Hz.
    pub energy_rate: f64,
    /// Exaggeration of the body's deformation.
    pub exaggeration: f64,
}
