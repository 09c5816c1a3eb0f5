//! Errors of an integration.

use thiserror::Error;

/// The caller has stopped a computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("stopped")]
pub struct Stopped;

/// An integration that cannot be set up or continued.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DynamicsError {
    /// The state or the right-hand side is infinite or NaN, however short the step. The integrator keeps
    /// the last finite state.
    #[error(
        "{} is not finite at t = {time} s (last finite state at t = {last_good_time} s): check the \
         force and the initial state; with a fixed step, make it shorter",
        describe_component(*.component, *.modes, .part)
    )]
    NonFinite {
        /// End of the step that failed, s.
        time: f64,
        /// Time of the last finite state, s.
        last_good_time: f64,
        /// Index of the first non-finite component of `[q | q' | w]`. A non-finite force on a mode
        /// affects both `q` and `q'` of that mode.
        component: usize,
        /// Number of modes, which determines the meaning of `component`.
        modes: usize,
        /// The part of the system whose force is not finite near the last finite state, if the system
        /// can name it ([`System::non_finite_part`](super::System::non_finite_part)).
        part: Option<String>,
        /// The last finite state, at `last_good_time`; empty if there was none.
        last_good_state: Vec<f64>,
    },
    /// The error exceeds the tolerance even at the minimum step. The integrator keeps the last accepted
    /// state.
    #[error(
        "at t = {time} s the estimated error is {error_ratio:.1e} times the tolerance even at the minimum step \
         of about {step:e} s. Possible causes: {}; a jump of the force: integrate with event location; a step \
         that crosses the whole contact: reduce the initial velocity or the maximum step; rounding errors above \
         the tolerance: loosen it, or raise its floor",
        too_stiff(*.implicit)
    )]
    StepUnderflow {
        /// Time of the last accepted state, s.
        time: f64,
        /// The last attempted step, s.
        step: f64,
        /// Estimated error of that step, relative to the tolerance.
        error_ratio: f64,
        /// Whether the method takes implicit steps.
        implicit: bool,
    },
    /// The steps stay so short that the integration does not reach its end in a reasonable time. The
    /// integrator keeps the last accepted state.
    #[error(
        "at t = {time} s the last {steps} steps had a mean length of {step:.1e} s, and the integration has \
         stalled: {}, loosen the tolerance, or reduce the maximum step to continue regardless",
        too_stiff(*.implicit)
    )]
    Stalled {
        /// Time reached, s.
        time: f64,
        /// Mean length of these steps, s.
        step: f64,
        /// Number of these steps.
        steps: u64,
        /// Whether the method takes implicit steps.
        implicit: bool,
    },
    /// The stop flag was set ([`Integrator::set_stop_flag`](super::Integrator::set_stop_flag)). The integrator keeps the
    /// last accepted state, and times up to it can still be sampled.
    #[error("stopped")]
    Stopped(#[from] Stopped),
    /// A parameter of the method is out of its range.
    #[error("{name} of the integrator is {value:e}: it must be {allowed}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value given.
        value: f64,
        /// Permitted range.
        allowed: &'static str,
    },
    /// A mode is not an oscillator.
    #[error(
        "mode {mode} has natural frequency {omega:e} rad/s and damping ratio {damping:e}: the \
         frequency must be finite and not negative, the ratio between -1 and 1 (write an \
         overdamped mode as first-order components)"
    )]
    Mode {
        /// Index of the mode, from 0.
        mode: usize,
        /// Natural circular frequency given, rad/s.
        omega: f64,
        /// Damping ratio given.
        damping: f64,
    },
    /// The length of a slice or the size of a system differs from that of the integrator.
    #[error(
        "{what} has length {found}, expected {expected}: create a new integrator for this system"
    )]
    Size {
        /// Name of the slice.
        what: &'static str,
        /// Expected length.
        expected: usize,
        /// Actual length.
        found: usize,
    },
    /// The requested time is before the last step or not finite.
    #[error(
        "time {asked} s is not available: request finite times from {earliest} s on in ascending order, or \
         start again"
    )]
    Time {
        /// Requested time, s.
        asked: f64,
        /// Start of the last step, s.
        earliest: f64,
    },
    /// Guards are crossed repeatedly while time does not advance.
    #[error(
        "at t = {time} s guard {guard} chatters ({crossings} crossings within the limit of time): give the \
         system a status for the limit of the chattering (rest on the wall, sticking), or integrate through \
         the kinks without event location"
    )]
    Chatter {
        /// Time, s.
        time: f64,
        /// Index of the guard crossed last.
        guard: usize,
        /// Number of crossings within the limit of time: by default the maximum step.
        crossings: usize,
    },
    /// The system lacks a required capability.
    #[error(
        "missing {what}, required for {purpose}: implement it for the system, or disable {purpose}"
    )]
    MissingCapability {
        /// Missing capability.
        what: &'static str,
        /// Feature that requires it.
        purpose: &'static str,
    },
    /// The requested number of tangent vectors is zero or exceeds the dimension.
    #[error("{asked} exponents requested: the number must be from 1 to {dimension}")]
    TangentCount {
        /// Requested number.
        asked: usize,
        /// Dimension of the tangent space.
        dimension: usize,
    },
    /// A tangent vector is infinite or NaN although the state is finite.
    #[error(
        "tangent vector {vector} is not finite at t = {time} s: check the derivative of the force \
         and the gradients of the guards there"
    )]
    Tangent {
        /// Time, s.
        time: f64,
        /// Index of the vector.
        vector: usize,
    },
}

/// Cause and remedy for short steps; the remedy is never the method in use.
fn too_stiff(implicit: bool) -> &'static str {
    if implicit {
        "a law too stiff even for implicit steps: make it less steep"
    } else {
        "a law too stiff for an explicit method: use rodas5p or auto"
    }
}

/// Describes the non-finite component. Modes are counted from 1, as in scene files.
fn describe_component(component: usize, modes: usize, part: &Option<String>) -> String {
    let of = match part {
        Some(part) => format!(" (force of {part})"),
        None => String::new(),
    };
    match component {
        q if q < modes => format!("coordinate q{} of the state{of}", q + 1),
        v if v < 2 * modes => format!("velocity qdot{} of the state{of}", v - modes + 1),
        w => format!("first-order component {w} of the state{of}"),
    }
}
