//! Types of some parameters of a scene.

/// A parameter that the scene specifies, or that is determined from the signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AutoOr<T> {
    /// The specified value.
    Given(T),
    /// The latest choice of [`AnalysisSpec::delay`](super::AnalysisSpec::delay); undefined before the first
    /// choice.
    Auto,
}

impl<T> AutoOr<T> {
    /// Returns the specified value, or else `auto`.
    pub fn or(self, auto: T) -> T {
        match self {
            Self::Given(value) => value,
            Self::Auto => auto,
        }
    }

    /// Applies a function to a specified value.
    pub fn map<U>(self, convert: impl FnOnce(T) -> U) -> AutoOr<U> {
        match self {
            Self::Given(value) => AutoOr::Given(convert(value)),
            Self::Auto => AutoOr::Auto,
        }
    }
}

/// Surface of a Poincare section, and the coordinates shown of each crossing.
#[derive(Clone, Debug, PartialEq)]
pub enum SectionSurface {
    /// `y(t + lag) = level` of the delay trajectory (Fig. 10); the coordinates are `(y(t), y(t + 2 lag))`.
    Delay {
        /// Delay, s.
        lag: AutoOr<f64>,
        /// Displacement at the surface, m.
        level: f64,
    },
    /// The plane `normal_q . q + normal_qdot . dq/dt = offset` of the modal state. Missing components of a
    /// normal are zero. Not available for a signal without modes.
    State {
        /// Components of the normal along the modal coordinates.
        normal_q: Vec<f64>,
        /// Components of the normal along the modal velocities, s.
        normal_qdot: Vec<f64>,
        /// Offset, sqrt(kg) m.
        offset: f64,
        /// The two coordinates of the section plot, sqrt(kg) m or sqrt(kg) m/s.
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
