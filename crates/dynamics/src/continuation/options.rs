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
    /// Whether to locate the kinks of a continuous system, for example of nodes that separate. Across kinks that are not
    /// located the multipliers are less accurate than the orbit. The jumps of other systems are always located.
    pub locate_kinks: bool,
    /// Maximum estimated error of an orbit after the last Newton correction, relative to its size.
    pub newton_tolerance: f64,
    /// Maximum number of Newton iterations per orbit.
    pub max_iterations: u32,
    /// Limits of the steps along the branch.
    pub steps: StepLimits,
    /// Maximum number of points in each direction.
    pub max_points: usize,
    /// Maximum period, s.
    pub max_period_s: f64,
    /// Maximum natural logarithm of the ratio between the largest and the smallest growth of the flow over a segment,
    /// which sets the number of segments. The relative error of the smallest multipliers is the tolerance of the integration
    /// times this ratio.
    pub max_segment_log_ratio: f64,
    /// Minimum number of segments.
    pub min_segments: usize,
    /// Target for the error of the parameter at bifurcations, relative to the distance of the bounds.
    pub bifurcation_accuracy: f64,
}

impl ContinuationOptions {
    /// Default options for a parameter between two bounds, and for motions with the time scale `max_step` (s), the
    /// maximum step of the integration.
    pub fn new(bounds: [f64; 2], max_step: f64) -> Self {
        Self {
            bounds,
            method: MethodName::Lawson853.with(Accuracy::relative(1e-11), max_step),
            locate_kinks: true,
            newton_tolerance: 1e-9,
            max_iterations: 8,
            steps: StepLimits::default(),
            max_points: 500,
            max_period_s: f64::INFINITY,
            max_segment_log_ratio: 8.0,
            min_segments: 2,
            bifurcation_accuracy: 1e-9,
        }
    }

    /// Checks the ranges.
    pub(super) fn check(&self) -> Result<(), ContinuationError> {
        let [low, high] = self.bounds;
        let width = high - low;
        let (newton, accuracy) = (self.newton_tolerance, self.bifurcation_accuracy);
        let StepLimits { initial, min, max } = self.steps;
        let ordered = min > 0.0 && min <= initial && initial <= max && max.is_finite();
        let ratio = self.max_segment_log_ratio;
        let fraction = |x: f64| x > 0.0 && x < 1.0;
        let checks = [
            (
                width > 0.0 && width.is_finite(),
                "the distance of the parameter's bounds",
                width,
                "finite, with the lower bound below the upper one",
            ),
            (
                fraction(newton),
                "the Newton tolerance",
                newton,
                "between 0 and 1",
            ),
            (
                fraction(accuracy),
                "the accuracy of bifurcations",
                accuracy,
                "between 0 and 1",
            ),
            (
                ordered,
                "the first step along the branch",
                initial,
                "positive, from the minimum to the maximum step",
            ),
            (
                ratio > 0.0,
                "the growth ratio of a segment",
                ratio,
                "positive",
            ),
        ];
        match checks.into_iter().find(|check| !check.0) {
            None => Ok(()),
            Some((_, name, value, allowed)) => Err(ContinuationError::Option {
                name,
                value,
                allowed,
            }),
        }
    }
}
