//! One step of any method, and what the others have to know of a method.

use super::control::{Rule, Size};
use super::tangents::Bundle;
use super::{Differentiable, Switching, System, Tally};

/// The last step: its two ends.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// Start of the last step, s.
    pub start_time: f64,
    /// State at the start of the last step.
    pub start: Vec<f64>,
    /// End of the last step, s.
    pub end_time: f64,
    /// Where the last step ended before it was cut at an event, s.
    pub reach_time: f64,
    /// State at the end of the last step.
    pub end: Vec<f64>,
    /// Slope of the state at the end of the last step, without what the method takes exactly.
    pub end_slope: Vec<f64>,
    /// Estimated error of `end`; zero without an embedded method.
    pub error: Vec<f64>,
}

impl Step {
    /// Ends for states of length `dim`.
    pub fn new(dim: usize) -> Self {
        let zeros = vec![0.0; dim];
        Self {
            start_time: 0.0,
            start: zeros.clone(),
            end_time: 0.0,
            reach_time: 0.0,
            end: zeros.clone(),
            end_slope: zeros.clone(),
            error: zeros,
        }
    }

    /// The length of the state.
    pub fn dim(&self) -> usize {
        self.start.len()
    }

    /// The length of the step before it was cut, s.
    pub fn length(&self) -> f64 {
        self.reach_time - self.start_time
    }

    /// Whether the last step was cut at an event.
    pub fn is_cut(&self) -> bool {
        self.end_time < self.reach_time
    }

    /// Puts the start of the step at its end.
    pub fn anchor(&mut self) {
        self.start_time = self.end_time;
        self.start.copy_from_slice(&self.end);
    }

    /// Puts the end of the step at its start.
    pub fn undo(&mut self) {
        self.end_time = self.start_time;
        self.reach_time = self.start_time;
        self.end.copy_from_slice(&self.start);
    }

    /// The state at time `t` (s) where it is that of an end.
    pub fn at_end(&self, t: f64) -> Option<&[f64]> {
        match t {
            _ if t == self.end_time => Some(&self.end),
            _ if t == self.start_time => Some(&self.start),
            _ => None,
        }
    }
}

/// One method at work. Its workspace is made once; nothing is allocated by a step.
///
/// Work that it does is counted in the tally given.
pub(super) trait Stepper {
    /// The last step.
    fn step(&self) -> &Step;

    /// The last step, to be changed.
    fn step_mut(&mut self) -> &mut Step;

    /// What is to be known of the method.
    fn rule(&self) -> &'static Rule;

    /// Takes over the linear part of a changed system with as many modes.
    fn reread<Y: System + ?Sized>(&mut self, _sys: &Y) {}

    /// The longest step that the linear part allows, s.
    fn longest_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Evaluates the system afresh at the present state, and forgets the step that led to it.
    fn refresh<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally);

    /// Lets the next step start where the last one ended.
    fn follow<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally);

    /// Takes the last step back.
    fn rewind(&mut self);

    /// Tries the step from its start to `end_time`. It overwrites any step tried from there before,
    /// so that a rejected step needs no undoing.
    fn attempt<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        end_time: f64,
        tally: &mut Tally,
    );

    /// The size of the error of the step tried.
    fn error(&self, omega: &[f64]) -> Size;

    /// Makes ready for states between the ends of the step.
    fn densify<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally);

    /// Writes the state at time `t` (s) within the last step, made ready for it.
    fn interpolate(&mut self, t: f64, out: &mut [f64]);

    /// Ends the last step at time `t` (s) within it, at the state of the dense output there.
    fn cut(&mut self, t: f64) {
        // An event at the very end cuts nothing.
        if t == self.step().end_time {
            return;
        }
        let mut end = std::mem::take(&mut self.step_mut().end);
        self.interpolate(t, &mut end);
        self.step_mut().end = end;
        self.step_mut().end_time = t;
    }

    /// Makes ready for tangent vectors of the system to follow the steps; returns how many slopes each
    /// of them needs.
    fn record<Y: System + ?Sized>(&mut self, sys: &Y) -> usize;

    /// Gives up following tangent vectors.
    fn forget_records(&mut self);

    /// Takes tangent vectors from the start of the step to where it ends or was cut.
    fn carry<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        bundle: &mut Bundle,
        tally: &mut Tally,
    );
}

/// Writes `[f | g]` of a system, under a status where one is held.
pub(super) fn force<Y: System + ?Sized>(
    sys: &Y,
    status: Option<&[u8]>,
    t: f64,
    z: &[f64],
    out: &mut [f64],
) {
    match status {
        None => sys.force(t, z, out),
        Some(status) => switching(sys).force_in(status, t, z, out),
    }
}

/// The switching of a system that is known to have it.
pub(super) fn switching<Y: System + ?Sized>(sys: &Y) -> &dyn Switching {
    sys.switching().expect("checked when the system came in")
}

/// The derivative of a system that is known to have it.
pub(super) fn differentiable<Y: System + ?Sized>(sys: &Y) -> &dyn Differentiable {
    sys.differentiable()
        .expect("checked when the system came in")
}
