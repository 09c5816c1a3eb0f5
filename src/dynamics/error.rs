//! What can go wrong in an integration.

use thiserror::Error;

/// An integration that cannot be set up, or cannot go on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DynamicsError {
    /// The state, or the right-hand side at it, is infinite or not a number, however short the
    /// step. The integrator still holds the last good state.
    #[error(
        "{} is not finite at t = {time} s (the state was good up to t = {last_good_time} s): check the \
         force and the initial state; with a fixed step, make it shorter",
        place(*.component, *.modes, .part)
    )]
    NonFinite {
        /// End of the step that failed, s.
        time: f64,
        /// Time of the last good state, s.
        last_good_time: f64,
        /// Index of the first offending component of `[q | q' | w]`. A force on a mode spoils both
        /// `q` and `q'` of it.
        component: usize,
        /// The number of modes, which says what the component is.
        modes: usize,
        /// The part of the system whose force is not finite next to the last good state, where the
        /// system knows of one ([`System::part_at_fault`](super::System::part_at_fault)).
        part: Option<String>,
        /// The last good state, at `last_good_time`; empty where there never was one.
        last_good_state: Vec<f64>,
    },
    /// The error stays above the tolerance down to the shortest step worth taking.
    /// The integrator still holds the last good state.
    #[error(
        "at t = {time} s the error is {error_ratio:.1e} times the tolerance even with a step of \
         {step:e} s, about the shortest worth taking: either the force changes within that step ({}; a \
         jump; a state so fast that it crosses the contact in it: start with less, or take a shorter longest \
         step), or its rounding noise is above the tolerance (loosen that, or raise its floor)",
        too_stiff(*.implicit)
    )]
    StepUnderflow {
        /// Time of the last good state, s.
        time: f64,
        /// The last step tried, s.
        step: f64,
        /// Estimated error of that step over what the tolerance allows.
        error_ratio: f64,
        /// Whether the method takes implicit steps.
        implicit: bool,
    },
    /// The steps have become so short, and stay so, that the end will not be seen.
    /// The integrator still holds the last good state.
    #[error(
        "at t = {time} s the last {steps} steps have been {step:.1e} s long on the average, and the time \
         hardly goes on: {}, loosen the tolerance, or choose a shorter longest step to go on all the same",
        too_stiff(*.implicit)
    )]
    Stalled {
        /// Time reached, s.
        time: f64,
        /// Their mean length, s.
        step: f64,
        /// How many there were.
        steps: u64,
        /// Whether the method takes implicit steps.
        implicit: bool,
    },
    /// It was told to stop ([`Integrator::heed`](super::Integrator::heed)). The integrator still holds
    /// the last good state, and what is up to it can be sampled.
    #[error("told to stop at t = {time} s")]
    Stopped {
        /// Time reached, s.
        time: f64,
    },
    /// A parameter of the method is out of its range.
    #[error("{name} of the integrator is {value:e}: choose it {allowed}")]
    Parameter {
        /// What the parameter is called.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range it must lie in.
        allowed: &'static str,
    },
    /// A mode is not an oscillation.
    #[error(
        "mode {mode} has natural frequency {omega:e} rad/s and damping ratio {damping:e}: the \
         frequency must be finite and not negative, the ratio between -1 and 1 (write an \
         overdamped mode as first-order components)"
    )]
    Mode {
        /// Index of the mode.
        mode: usize,
        /// Its natural circular frequency, rad/s.
        omega: f64,
        /// Its damping ratio.
        damping: f64,
    },
    /// A slice or a system has another size than the integrator was made for.
    #[error("{what} has length {found} where {expected} is needed: make a new integrator")]
    Size {
        /// Which slice.
        what: &'static str,
        /// The length needed.
        expected: usize,
        /// The length found.
        found: usize,
    },
    /// A time before the last step was asked for, or one that is not finite.
    #[error(
        "time {asked} s was asked for, but only finite times from {earliest} s on are within \
         reach: ask in rising order, or start again"
    )]
    Time {
        /// The time asked for, s.
        asked: f64,
        /// Start of the last step, s.
        earliest: f64,
    },
    /// Guards are crossed without end and without time going on.
    #[error(
        "at t = {time} s guard {guard} is crossed without end ({crossings} crossings within the \
         longest step): give the system a status for what the chatter comes to (rest on the wall, \
         sticking), or step through its kinks instead of stopping at each"
    )]
    Chatter {
        /// When, s.
        time: f64,
        /// The guard crossed last.
        guard: usize,
        /// How many crossings there were.
        crossings: usize,
    },
    /// The system lacks what is asked of it.
    #[error("the system has no {what}: implement it, or do without {wish}")]
    Lacks {
        /// What it lacks.
        what: &'static str,
        /// What that would be needed for.
        wish: &'static str,
    },
    /// More tangent vectors were asked for than there are dimensions, or none.
    #[error("{asked} exponents were asked for: the system has 1 to {dimension}")]
    Width {
        /// How many were asked for.
        asked: usize,
        /// Dimension of the tangent space.
        dimension: usize,
    },
    /// A tangent vector is infinite or not a number, though the state is finite.
    #[error(
        "tangent vector {vector} is not finite at t = {time} s: check the derivative of the force \
         and the gradients of the guards there"
    )]
    Tangent {
        /// When, s.
        time: f64,
        /// Which vector.
        vector: usize,
    },
}

/// A law that holds the steps down, and the remedy, which is never the method in use.
fn too_stiff(implicit: bool) -> &'static str {
    match implicit {
        true => "a law too stiff for implicit steps, too: make it less steep",
        false => "a law too stiff for an explicit method: take rodas5p or auto",
    }
}

/// What is not finite, in words. Modes are counted from 1, as scenes do.
fn place(component: usize, modes: usize, part: &Option<String>) -> String {
    let of = match part {
        Some(part) => format!(" by the force of {part}"),
        None => String::new(),
    };
    match component {
        q if q < modes => format!("coordinate q{} of the state{of}", q + 1),
        v if v < 2 * modes => format!("velocity qdot{} of the state{of}", v - modes + 1),
        w => format!("component {w} of the state, of first order,{of}"),
    }
}
