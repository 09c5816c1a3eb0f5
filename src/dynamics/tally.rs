//! Counters of the work done, and the error made: public data, shown live and compared in tests.

/// What an integration has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Tally {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejections: u64,
    /// Calls of the right-hand side (or of the nonlinear force, for exponential methods).
    pub calls: u64,
    /// Jacobians of the force taken, by implicit methods.
    pub jacobians: u64,
    /// Changes between explicit and implicit steps, where the method switches by itself.
    pub switches: u64,
    /// Guards crossed, each by itself, where events are located.
    pub crossings: u64,
    /// Instants at which guards were crossed: several at once count once.
    pub events: u64,
    /// Guards that came down to zero within a step without falling through it.
    pub grazings: u64,
    /// Steps that ran over their guards, since these were crossed too often to stop at each.
    pub overrun: u64,
}

/// The largest estimate of the local error among some accepted steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// The estimate over the error allowed, 0 to 1.
    pub ratio: f64,
    /// The error allowed in a step, relative to the size of the state.
    pub tolerance: f64,
}

impl ErrorEstimate {
    /// The estimate, relative to the size of the state.
    pub fn relative(self) -> f64 {
        self.ratio * self.tolerance
    }
}
