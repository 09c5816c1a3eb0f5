//! Options of the continuation.

use super::ContinuationError;
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

impl Default for StepLimits {
    fn default() -> Self {
        Self {
            initial: 0.01,
            min: 1e-6,
            max: 0.05,
        }
    }
}

/// Options of the continuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuationOptions {
    /// Lower and upper bound of the parameter.
    pub bounds: [f64; 2],
    /// Integration method with its tolerance, which bounds the accuracy of everything else.
    pub method: Method,
    /// Maximum estimated error of an orbit after the last Newton correction, relative to its size.
    pub newton_tolerance: f64,
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
            newton_tolerance: 1e-9,
            steps: StepLimits::default(),
        }
    }

    /// Checks the ranges.
    pub(super) fn check(&self) -> Result<(), ContinuationError> {
        let [low, high] = self.bounds;
        let width = high - low;
        let newton = self.newton_tolerance;
        let StepLimits { initial, min, max } = self.steps;
        let fail = |name, value, allowed| {
            Err(ContinuationError::Option {
                name,
                value,
                allowed,
            })
        };
        if !(width > 0.0 && width.is_finite()) {
            let allowed = "finite, with the lower bound below the upper one";
            return fail("the distance of the parameter's bounds", width, allowed);
        }
        if !(newton > 0.0 && newton < 1.0) {
            return fail("the Newton tolerance", newton, "between 0 and 1");
        }
        if !(min > 0.0 && min <= initial && initial <= max && max.is_finite()) {
            let allowed = "positive, from the minimum to the maximum step";
            return fail("the first step along the branch", initial, allowed);
        }
        Ok(())
    }
}
