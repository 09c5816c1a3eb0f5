//! Errors of the finite-element model.

/// An error of the finite-element model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FemError {
    /// An invalid dimension, material constant or mesh: which, and the requirement.
    #[error("{0}")]
    Input(String),
    /// The matrices do not fit into memory.
    #[error(
        "the finite elements need about {megabytes} MB of memory, which is not available: use larger \
         elements or fewer modes, or raise the memory limit"
    )]
    Memory {
        /// Memory required, MB.
        megabytes: usize,
    },
    /// The modes of a family cannot be computed: which, why, and the remedy.
    #[error("{0}")]
    Modes(String),
    /// A direction that does not point to the free surface of the ball.
    #[error(
        "direction {direction:?} (polar angle {polar_deg:.3} deg) does not point to the ball's free \
         surface, which extends from 0 to {limit_deg:.3} deg: choose a smaller tilt or patch"
    )]
    OutsideBall {
        /// Direction given.
        direction: [f64; 3],
        /// Its polar angle from the +z axis, degrees; NaN for an invalid direction.
        polar_deg: f64,
        /// Polar angle at which the beam begins, degrees.
        limit_deg: f64,
    },
}
