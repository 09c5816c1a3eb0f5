//! Counters of the work done and the estimated local error. Both are shown live and compared in tests.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Work done by an integration so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SolverStats {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejections: u64,
    /// Evaluations of the right-hand side (of the nonlinear force, for exponential methods).
    pub rhs_evals: u64,
    /// Jacobian evaluations of implicit methods.
    pub jacobians: u64,
    /// Switches between explicit and implicit steps by the method `auto`.
    pub switches: u64,
    /// Guard crossings located, each guard counted separately.
    pub crossings: u64,
    /// Event instants: simultaneous crossings of several guards count once.
    pub events: u64,
    /// Guards that touch zero within a step without crossing it.
    pub grazings: u64,
    /// Steps taken without event location because guards were crossed too often (chattering).
    pub steps_without_event_location: u64,
}

/// Largest local error estimate over a set of accepted steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Error estimate divided by the tolerance, 0 to 1.
    pub ratio: f64,
    /// Tolerance per step, relative to the norm of the state.
    pub tolerance: f64,
}

impl ErrorEstimate {
    /// Error estimate relative to the norm of the state.
    pub fn relative(self) -> f64 {
        self.ratio * self.tolerance
    }
}
