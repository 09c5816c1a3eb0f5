//! Counters of the work done: public data, shown live and compared in tests.

/// What an integration has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejections: u64,
    /// Calls of the right-hand side (or of the nonlinear force, for exponential methods).
    pub calls: u64,
}
