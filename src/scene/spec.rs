//! The validated scene.

use super::accuracy::Advised;
use super::mechanism::Mechanism;
use super::subject::SubjectSpec;
use super::tables::analysis::AnalysisSpec;
use super::tables::{Integrator, RecordSpec, Start};

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
