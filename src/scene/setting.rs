//! What some keys of an analysis give.

/// A value that the scene gives or the signal decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting<T> {
    /// As given.
    Given(T),
    /// As [`AnalysisSpec::delay`](super::AnalysisSpec::delay) last chose it; there is none before its first choice.
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
