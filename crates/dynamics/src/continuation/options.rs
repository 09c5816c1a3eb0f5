//! Options of the continuation.

use crate::{Accuracy, Method, MethodName};

/// Limits of the steps along a branch, in units of the scaled arclength: a step of 1 changes the state by the size of
/// the orbit, or the period by itself, or the parameter by the distance of its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// First step.
    pub initial: f64,
    /// Minimum step. The branch ends if it is too long.
    pub min: f64,
    /// Maximum step.
    pub max: f64,
}

/// Options of the continuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuationOptions {
    /// Lower and upper bound of the parameter.
    pub bounds: [f64; 2],
    /// Integration method with its tolerance, which bounds the accuracy of everything else.
    pub method: Method,
    /// Limits of the steps along the branch.
    pub steps: StepLimits,
}

impl ContinuationOptions {
    /// Default options for a parameter between two bounds, and for motions with the time scale `max_step` (s), the
    /// maximum step of the integration.
    pub fn new(bounds: [f64; 2], max_step: f64) -> Self {
        Self {
            bounds,
            method: MethodName::Lawson853.with(Accuracy::relative(1e-11), max_step),
            steps: StepLimits {
                initial: 0.01,
                min: 1e-6,
                max: 0.05,
            },
        }
    }
}
