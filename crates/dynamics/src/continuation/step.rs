//! The length of the steps along a branch.

use super::follow::BranchState;
use super::point::Point;

/// Angle between successive tangents at which the step stays as it is, rad.
const TARGET_ANGLE: f64 = 0.15;

/// Largest angle between successive tangents, rad: beyond it a step may have jumped to another branch.
const MAX_ANGLE: f64 = 0.6;

/// Largest first Newton correction, relative to the step.
const MAX_FIRST_CORRECTION: f64 = 0.7;

/// Largest distance between two points with a corner of the branch between them, relative to the step.
const MAX_CORNER: f64 = 2.0;

/// Newton iterations at which the step stays as it is.
const TARGET_ITERATIONS: f64 = 4.0;

/// Maximum number of times that a step is shortened to separate bifurcations.
const MAX_RESOLUTIONS: u32 = 8;

impl BranchState<'_, '_> {
    /// Shortens the step; returns `false` at the minimum.
    pub fn shorten(&mut self) -> bool {
        let min = self.flow.options.steps.min;
        let is_possible = self.step > min;
        self.step = (0.5 * self.step).max(min);
        is_possible
    }

    /// Whether the step may be shortened to separate bifurcations; counts the attempts.
    pub fn may_resolve(&mut self) -> bool {
        self.resolutions += 1;
        self.resolutions <= MAX_RESOLUTIONS && self.step > self.flow.options.steps.min
    }

    /// Whether a step of length `step` from the present point may have jumped to another branch, or around a narrow turn.
    pub fn is_jump(&self, to: &Point, step: f64) -> bool {
        let from = &self.now;
        if from.has_corner_before(to) {
            // There the tangent does not predict the next point.
            return from.scale.norm(&to.shot.minus(&from.shot)) > MAX_CORNER * step;
        }
        angle(from, to) > MAX_ANGLE || to.first_correction > MAX_FIRST_CORRECTION * step
    }

    /// Chooses the length of the next step after an accepted one of length `step` from the present point.
    pub fn adapt(&mut self, to: &Point, step: f64) {
        let by_angle = TARGET_ANGLE / angle(&self.now, to).max(1e-6);
        let by_iterations = 2.0_f64.powf(TARGET_ITERATIONS - f64::from(to.orbit.iterations));
        let by_correction = 0.3 * step / to.first_correction.max(1e-12 * step);
        let factor = by_angle
            .min(by_iterations)
            .min(by_correction)
            .clamp(0.5, 2.0);
        // A step that was cut at a bound says nothing about longer ones.
        let length = step.max(1e-3 * self.step);
        let limits = self.flow.options.steps;
        self.step = (length * factor).clamp(limits.min, limits.max);
        self.resolutions = 0;
    }
}

/// Angle between the tangents of two points, rad.
fn angle(from: &Point, to: &Point) -> f64 {
    let scale = &from.scale;
    let norms = scale.norm(&from.tangent) * scale.norm(&to.tangent);
    (scale.dot(&from.tangent, &to.tangent) / norms)
        .clamp(-1.0, 1.0)
        .acos()
}
