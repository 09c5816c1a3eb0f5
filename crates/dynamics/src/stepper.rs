//! The interface of a single step, common to all methods.

use super::error_control::{MethodTraits, StateNorm};
use super::system::{add_linear, force};
use super::tangents::TangentBlock;
use super::{Differentiable, SolverStats, Switching, System};

/// The law of a system, with a frozen status if there is one.
#[derive(Clone, Copy)]
pub(super) struct Law<'a> {
    pub sys: &'a dyn System,
    pub status: Option<&'a [u8]>,
}

impl Law<'_> {
    /// The derivative of the force of a system that is known to have one.
    fn derivative(&self) -> &dyn Differentiable {
        self.sys.differentiable().expect("checked at construction")
    }

    /// Length of a record.
    pub fn record_len(self) -> usize {
        self.derivative().record_len()
    }

    /// Writes `[f | g]`, and its record if there is one to fill.
    pub fn force(self, t: f64, z: &[f64], out: &mut [f64], record: Option<&mut Vec<f64>>) {
        match record {
            None => force(self.sys, self.status, t, z, out),
            Some(record) => self
                .derivative()
                .force_recorded(self.status, t, z, out, record),
        }
    }

    /// Writes `dz/dt`, the right-hand side of the law.
    pub fn rhs(self, t: f64, z: &[f64], dz: &mut [f64], record: Option<&mut Vec<f64>>) {
        self.force(t, z, &mut dz[self.sys.modes()..], record);
        self.add_linear(z, dz, 1);
    }

    /// Adds the linear part to `dz = [. | f | g]`. `z` is one state, or `width` tangent vectors.
    pub fn add_linear(self, z: &[f64], dz: &mut [f64], width: usize) {
        add_linear(self.sys.omega(), self.sys.damping(), z, dz, width);
    }

    /// Writes the nonlinear part of the derivative of `width` tangent vectors.
    pub fn product(self, record: &mut [f64], vectors: &[f64], width: usize, out: &mut [f64]) {
        self.derivative()
            .product(self.status, record, vectors, width, out);
    }

    /// Writes the partial time derivative of `[f | g]`.
    pub fn time_derivative(self, t: f64, z: &[f64], out: &mut [f64]) {
        self.derivative().time_derivative(self.status, t, z, out);
    }

    /// Projects a state and tangent vectors onto the constraint of the status, if there is one.
    pub fn settle(self, t: f64, z: &mut [f64], tangents: (&mut [f64], usize)) {
        if let (Some(status), Some(switching)) = (self.status, self.sys.switching()) {
            switching.settle(status, t, z, tangents);
        }
    }
}

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
    /// Work of all steps.
    pub stats: SolverStats,
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
            stats: SolverStats::default(),
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
pub(super) trait Stepper {
    /// The last step.
    fn step(&self) -> &Step;

    /// Mutable access to the last step.
    fn step_mut(&mut self) -> &mut Step;

    /// Properties of the method.
    fn traits(&self) -> &'static MethodTraits;

    /// Evaluates the right-hand side at the present state and discards the last step.
    fn reinitialise(&mut self, law: Law<'_>);

    /// Moves the start of the next step to the end of the last one.
    fn begin_step(&mut self);

    /// Reverts the last step.
    fn reject_step(&mut self);

    /// Attempts a step from the present start to `end_time`. It overwrites an earlier attempt, so a
    /// rejected step needs no cleanup.
    fn attempt(&mut self, law: Law<'_>, end_time: f64);

    /// Error norm of the attempted step.
    fn error(&self, sys: &dyn System) -> StateNorm;

    /// Evaluates the additional stages that the dense output needs.
    fn prepare_dense_output(&mut self, _law: Law<'_>) {}

    /// Writes the state at time `t` (s) between the ends of the last step by dense output.
    fn interpolate_inside(&mut self, t: f64, out: &mut [f64]);

    /// Writes the state at time `t` (s) within the last step.
    fn interpolate(&mut self, t: f64, out: &mut [f64]) {
        match self.step().at_end(t) {
            Some(state) => out.copy_from_slice(state),
            None => self.interpolate_inside(t, out),
        }
    }

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
    fn enable_tangents(&mut self, law: Law<'_>) -> usize;

    /// Propagates tangent vectors from the start of the step to its end, shortened or not.
    fn propagate_tangents(&mut self, law: Law<'_>, block: &mut TangentBlock);
}

/// The switching interface of a system that is known to have one.
pub(super) fn switching(sys: &dyn System) -> &dyn Switching {
    sys.switching().expect("checked at construction")
}
