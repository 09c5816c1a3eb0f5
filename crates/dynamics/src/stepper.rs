//! The interface of a single step, common to all methods.

use super::error_control::{MethodTraits, StateNorm};
use super::tangents::TangentBlock;
use super::{Differentiable, SolverStats, Switching, System};

/// The last step: time and state at its two ends.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// Start of the last step, s.
    pub start_time: f64,
    /// State at the start of the last step.
    pub start: Vec<f64>,
    /// End of the last step, s.
    pub end_time: f64,
    /// End time of the last step before it was shortened at an event, s.
    pub full_end_time: f64,
    /// State at the end of the last step.
    pub end: Vec<f64>,
    /// Slope at the end of the last step, without the linear part that the method integrates exactly.
    pub end_slope: Vec<f64>,
    /// Error estimate of `end`; zero for a method without embedded estimate.
    pub error: Vec<f64>,
}

impl Step {
    /// Storage for states of length `dim`.
    pub fn new(dim: usize) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            start_time: 0.0,
            start: zeros.clone(),
            end_time: 0.0,
            full_end_time: 0.0,
            end: zeros.clone(),
            end_slope: zeros.clone(),
            error: zeros,
        }
    }

    /// Length of the state.
    pub fn dim(&self) -> usize {
        self.start.len()
    }

    /// Length of the step before shortening, s.
    pub fn length(&self) -> f64 {
        self.full_end_time - self.start_time
    }

    /// Whether the last step was shortened at an event.
    pub fn is_shortened(&self) -> bool {
        self.end_time < self.full_end_time
    }

    /// Moves the start of the step to its end.
    pub fn start_at_end(&mut self) {
        self.start_time = self.end_time;
        self.start.copy_from_slice(&self.end);
    }

    /// Moves the end of the step back to its start.
    pub fn revert(&mut self) {
        self.end_time = self.start_time;
        self.full_end_time = self.start_time;
        self.end.copy_from_slice(&self.start);
    }

    /// The state at time `t` (s) if that is an end of the step.
    pub fn at_end(&self, t: f64) -> Option<&[f64]> {
        match t {
            _ if t == self.end_time => Some(&self.end),
            _ if t == self.start_time => Some(&self.start),
            _ => None,
        }
    }
}

/// A single-step method with its workspace. Steps do not allocate.
///
/// The work is counted in the given counters.
pub(super) trait Stepper {
    /// The last step.
    fn step(&self) -> &Step;

    /// Mutable access to the last step.
    fn step_mut(&mut self) -> &mut Step;

    /// Properties of the method.
    fn traits(&self) -> &'static MethodTraits;

    /// Evaluates the right-hand side at the present state and discards the last step.
    fn reinitialise(&mut self, sys: &dyn System, status: Option<&[u8]>, stats: &mut SolverStats);

    /// Moves the start of the next step to the end of the last one.
    fn begin_step(&mut self);

    /// Reverts the last step.
    fn reject_step(&mut self);

    /// Attempts a step from the present start to `end_time`. It overwrites an earlier attempt, so a
    /// rejected step needs no cleanup.
    fn attempt(
        &mut self,
        sys: &dyn System,
        status: Option<&[u8]>,
        end_time: f64,
        stats: &mut SolverStats,
    );

    /// Error norm of the attempted step.
    fn error(&self, sys: &dyn System) -> StateNorm;

    /// Evaluates the additional stages that the dense output needs.
    fn prepare_dense_output(
        &mut self,
        _sys: &dyn System,
        _status: Option<&[u8]>,
        _stats: &mut SolverStats,
    ) {
    }

    /// Writes the state at time `t` (s) within the last step by dense output.
    fn interpolate(&mut self, t: f64, out: &mut [f64]);

    /// Shortens the last step to end at time `t` (s), with the state from the dense output.
    fn shorten(&mut self, t: f64) {
        // An event at the end of the step needs no shortening.
        if t == self.step().end_time {
            return;
        }
        let mut end = std::mem::take(&mut self.step_mut().end);
        self.interpolate(t, &mut end);
        self.step_mut().end = end;
        self.step_mut().end_time = t;
    }

    /// Enables tangent vectors; returns the number of slopes that each of them needs.
    fn enable_tangents(&mut self, sys: &dyn System) -> usize;

    /// Propagates tangent vectors from the start of the step to its end, shortened or not.
    fn propagate_tangents(
        &mut self,
        sys: &dyn System,
        status: Option<&[u8]>,
        block: &mut TangentBlock,
        stats: &mut SolverStats,
    );
}

/// The switching interface of a system that is known to have one.
pub(super) fn switching(sys: &dyn System) -> &dyn Switching {
    sys.switching().expect("checked at construction")
}

/// The derivative of a system that is known to have one.
pub(super) fn differentiable(sys: &dyn System) -> &dyn Differentiable {
    sys.differentiable().expect("checked at construction")
}
