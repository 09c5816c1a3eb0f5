//! Errors of the continuation.

use thiserror::Error;

use super::{FamilyError, StepLimits};
use crate::DynamicsError;

/// A periodic orbit that cannot be found.
#[derive(Debug, Error)]
pub enum ContinuationError {
    /// The family has no system at a value of the parameter.
    #[error("no system at parameter {parameter}: {source}")]
    Family {
        /// Value of the parameter.
        parameter: f64,
        /// The cause.
        source: FamilyError,
    },
    /// An integration failed.
    #[error("the integration of the orbit at parameter {parameter} failed: {source}")]
    Integration {
        /// Value of the parameter.
        parameter: f64,
        /// The cause.
        source: DynamicsError,
    },
    /// Newton's method did not converge.
    #[error(
        "Newton's method did not converge at parameter {parameter}: correction {correction:.1e} of the size of the \
         orbit after {iterations} iterations; start closer to an orbit, or take shorter steps"
    )]
    NotConverged {
        /// Value of the parameter.
        parameter: f64,
        /// Last correction, relative to the size of the orbit.
        correction: f64,
        /// Number of iterations.
        iterations: usize,
    },
    /// The motion does not return to its start.
    #[error(
        "the motion from the given state does not return within {time_s} s: its closest return is {distance:.1e} of \
         the size of the motion away; simulate longer first, or start from a periodic motion"
    )]
    NoReturn {
        /// Time searched, s.
        time_s: f64,
        /// Distance of the closest return, relative to the size of the motion.
        distance: f64,
    },
    /// The multipliers could not be computed.
    #[error(
        "the iteration for the multipliers did not converge at parameter {parameter}; report this case"
    )]
    Multipliers {
        /// Value of the parameter.
        parameter: f64,
    },
    /// The bounds of the parameter are not a range.
    #[error(
        "the distance of the parameter's bounds is {width:e}: it must be finite, with the lower bound below the upper one"
    )]
    Bounds {
        /// The upper bound minus the lower one.
        width: f64,
    },
    /// The limits of the steps along the branch are not in order.
    #[error(
        "the first step along the branch is {}: it must lie between the minimum {}, which is positive, and the maximum {}",
        .0.initial, .0.min, .0.max
    )]
    Steps(StepLimits),
    /// A bifurcation has no branch of twice the period.
    #[error("there is no branch of periodic orbits to switch to: {why}")]
    NoSwitch {
        /// The reason.
        why: &'static str,
    },
}
