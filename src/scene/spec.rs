//! The validated scene.

use crate::analysis::{Direction, DivergenceMethod, Norm, Threshold};
use crate::scene::{Advised, Mechanism, SubjectSpec};

/// A validated scene. SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name, as in `squeakscope run NAME`.
    pub name: String,
    /// One line that says what the scene shows.
    pub title: String,
    /// A few sentences (Markdown): what to look for.
    pub about: String,
    /// The mechanism that the scene shows, if it is one of those that have a lesson.
    pub mechanism: Option<Mechanism>,
    /// The scene's whole text as read, with what the command line changed at its end as comments.
    pub text: String,
    /// What is run.
    pub subject: SubjectSpec,
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
    /// The cheapest integrators for some errors, where the scene knows them.
    pub advice: Vec<Advised>,
    /// Which analyses run.
    pub analysis: AnalysisSpec,
    /// What is recorded, and how often.
    pub record: RecordSpec,
}

impl Scene {
    /// The number of samples of the whole run, at least one.
    pub fn samples(&self) -> u64 {
        (self.duration * self.sample_rate).round().max(1.0) as u64
    }
}

/// The initial state: at the steady-sliding equilibrium (of a small system: at a given place and
/// velocity), with a random kick of the modal velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Position of a small system, m; zero for a joint.
    pub position: f64,
    /// Velocity of a small system before the kick, m/s; zero for a joint.
    pub velocity: f64,
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
    /// What happens where the law changes.
    pub events: Events,
}

/// What a step does where a contact node opens or closes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Events {
    /// It goes through; the control of its error shortens it where that matters.
    #[default]
    Through,
    /// It ends exactly there.
    Exact,
}

/// The choice of integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Exponential (Lawson) pair of order 5(4): the linear modal part is exact.
    Lawson54,
    /// Plain embedded pair of order 5(4).
    Tsit54,
    /// Exponential (Lawson) pair of order 8(5, 3).
    Lawson853,
    /// Plain embedded pair of order 8(5, 3).
    Dop853,
    /// Linearly implicit method of order 5(4), with the analytic Jacobian.
    Rodas5p,
    /// The exponential pair of order 5(4), and the implicit method while the system is stiff.
    Auto,
    /// Classical Runge-Kutta of order 4, fixed step.
    Rk4,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Lawson54,
        Self::Lawson853,
        Self::Tsit54,
        Self::Dop853,
        Self::Rodas5p,
        Self::Auto,
        Self::Rk4,
    ];

    /// Its name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lawson54 => "lawson54",
            Self::Tsit54 => "tsit54",
            Self::Lawson853 => "lawson853",
            Self::Dop853 => "dop853",
            Self::Rodas5p => "rodas5p",
            Self::Auto => "auto",
            Self::Rk4 => "rk4",
        }
    }

    /// Whether its step is given, not chosen by an estimate of the error.
    pub const fn has_fixed_step(self) -> bool {
        matches!(self, Self::Rk4)
    }
}

/// Analyses; an absent one is not computed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnalysisSpec {
    /// Sliding amplitude spectrum of the probe's velocity.
    pub spectrum: Option<SlidingSpec>,
    /// Spectrogram of the probe's velocity.
    pub spectrogram: Option<SpectrogramSpec>,
    /// Choice of delay and embedding dimension from the probe's displacement.
    pub delay: Option<DelaySpec>,
    /// Recurrence plot of the probe's displacement.
    pub recurrence: Option<RecurrenceSpec>,
    /// Recurrence quantification of the probe's displacement.
    pub quantification: Option<QuantificationSpec>,
    /// Poincare section.
    pub section: Option<SectionSpec>,
    /// Largest Lyapunov exponent and 0-1 test of the probe's displacement.
    pub chaos: Option<ChaosSpec>,
    /// Kind of motion of the probe's displacement.
    pub regime: Option<RegimeSpec>,
    /// Lyapunov exponents from the tangent flow of the simulation itself.
    pub exponents: Option<ExponentsSpec>,
    /// A second copy of the joint that starts almost in the same state.
    pub butterfly: Option<ButterflySpec>,
}

/// A window that slides along the samples, and how often it is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingSpec {
    /// Length of the window, s.
    pub window: f64,
    /// Time from one look to the next, s.
    pub every: f64,
}

/// A value that the scene gives or the signal decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting<T> {
    /// As given.
    Given(T),
    /// As [`AnalysisSpec::delay`] last chose it; there is none before its first choice.
    Auto,
}

impl<T> Setting<T> {
    /// The value given, or else another.
    pub fn or(self, auto: T) -> T {
        match self {
            Self::Given(value) => value,
            Self::Auto => auto,
        }
    }

    /// The same in other terms.
    pub fn map<U>(self, convert: impl FnOnce(T) -> U) -> Setting<U> {
        match self {
            Self::Given(value) => Setting::Given(convert(value)),
            Self::Auto => Setting::Auto,
        }
    }
}

/// Delay vectors, Eq. (25).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddingSpec {
    /// Delay `tau`, s.
    pub lag: Setting<f64>,
    /// Embedding dimension `m`.
    pub dimension: Setting<usize>,
}

/// Which states count as the same, Eq. (26).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearnessSpec {
    /// How distances are measured.
    pub norm: Norm,
    /// Threshold `epsilon`; a distance is in m.
    pub threshold: Threshold,
}

/// Spectrogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrogramSpec {
    /// The window of a column, and the time between columns.
    pub sliding: SlidingSpec,
    /// Highest frequency kept, Hz.
    pub max_frequency: f64,
}

/// Choice of delay and embedding dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelaySpec {
    /// The window, and the time between choices.
    pub sliding: SlidingSpec,
    /// Largest delay tried, s.
    pub largest_lag: f64,
    /// Largest dimension tried.
    pub largest_dimension: usize,
    /// Bins along an axis of the joint histogram of the mutual information.
    pub bins: usize,
    /// Share of false neighbours that counts as none, 0 to 1.
    pub false_share: f64,
}

/// Evolving recurrence plot in a sliding window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecurrenceSpec {
    /// The window, and the time between plots.
    pub sliding: SlidingSpec,
    /// Points along a side.
    pub size: usize,
    /// The states.
    pub embedding: EmbeddingSpec,
    /// Which of them count as the same.
    pub nearness: NearnessSpec,
}

/// Recurrence quantification in a sliding window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantificationSpec {
    /// The window, and the time between its measures.
    pub sliding: SlidingSpec,
    /// Spacing of the states, s, at least that of the samples; the delay is rounded to a whole
    /// number of it.
    pub step: f64,
    /// The states.
    pub embedding: EmbeddingSpec,
    /// Which of them count as the same.
    pub nearness: NearnessSpec,
    /// Theiler window, s: states nearer in time are not compared.
    pub theiler: f64,
    /// Shortest diagonal line, states.
    pub least_diagonal: usize,
    /// Shortest vertical line, states.
    pub least_vertical: usize,
}

/// Poincare section.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionSpec {
    /// Time between reports of the passages, s.
    pub every: f64,
    /// The surface.
    pub surface: SectionSurface,
    /// Which passages count.
    pub direction: Direction,
}

/// The surface of a Poincare section, and what is shown of a passage.
#[derive(Clone, Debug, PartialEq)]
pub enum SectionSurface {
    /// `y(t + lag) = level` of the delay trajectory (Fig. 10); shown are `(y(t), y(t + 2 lag))`.
    Delay {
        /// Delay, s.
        lag: Setting<f64>,
        /// Level of the displacement, m.
        level: f64,
    },
    /// The plane `normal_q . q + normal_qdot . dq/dt = offset` of the modal state. Modes that a
    /// normal does not reach have a zero in it. A signal without modes has no such section.
    State {
        /// Components of the normal along the modal coordinates.
        normal_q: Vec<f64>,
        /// Components of the normal along the modal velocities, s.
        normal_qdot: Vec<f64>,
        /// Offset, sqrt(kg) m.
        offset: f64,
        /// The two coordinates shown, sqrt(kg) m or sqrt(kg) m/s.
        shown: [StateCoordinate; 2],
    },
}

/// A coordinate of the modal state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateCoordinate {
    /// Modal coordinate of the mode with this index, from 0.
    Q(usize),
    /// Modal velocity of the mode with this index, from 0.
    Qdot(usize),
}

/// Chaos from data alone, in a sliding window: how neighbours part, and the 0-1 test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChaosSpec {
    /// The window, and the time between results.
    pub sliding: SlidingSpec,
    /// The states.
    pub embedding: EmbeddingSpec,
    /// Theiler window, s: states nearer in time are no neighbours.
    pub theiler: f64,
    /// How long neighbours are followed, s.
    pub horizon: f64,
    /// Whose distance is followed.
    pub method: DivergenceMethod,
}

/// Verdict on the kind of motion in a sliding window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegimeSpec {
    /// The window, and the time between verdicts.
    pub sliding: SlidingSpec,
    /// Amplitude below which it is silent, m.
    pub silence: f64,
}

/// How many of something there shall be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// All there are.
    All,
    /// So many, from the first on.
    First(usize),
}

/// Lyapunov exponents, Eq. (23), from tangent vectors that go along with the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentsSpec {
    /// How many, the largest first; 1 to the dimension of the system.
    pub count: usize,
    /// Time from the start whose growth is forgotten, s.
    pub settle: f64,
    /// Time from one result to the next, s.
    pub every: f64,
}

/// The butterfly: a second copy of the joint from almost the same state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ButterflySpec {
    /// When the second copy starts, s.
    pub start: f64,
    /// Distance at the start in the norm of the vibration's energy, relative to the size that the
    /// motion has had by then.
    pub distance: f64,
    /// Time from one result to the next, s.
    pub every: f64,
}

/// What is recorded and how often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordSpec {
    /// Snapshots of the contact patch a second, Hz; 0 for none.
    pub patch_rate: f64,
    /// Snapshots of the deforming body a second, Hz; 0 for none.
    pub body_rate: f64,
    /// Energy samples a second, Hz; 0 for no energy audit.
    pub energy_rate: f64,
    /// Exaggeration of the body's deformation.
    pub exaggeration: f64,
}

impl RecordSpec {
    /// Of a subject with neither a patch nor a body to take snapshots of: its samples.
    pub const SAMPLES_ONLY: Self = Self {
        patch_rate: 0.0,
        body_rate: 0.0,
        energy_rate: 0.0,
        exaggeration: 1.0,
    };
}
