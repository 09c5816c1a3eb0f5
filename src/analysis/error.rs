//! What can be wrong with a signal.

/// The error of an analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AnalysisError {
    /// The slice is too short for what is asked of it.
    #[error(
        "{what}: {have} samples are too few; give at least {need}, or ask for a shorter window"
    )]
    TooShort {
        /// The analysis.
        what: &'static str,
        /// Samples given.
        have: usize,
        /// Samples needed.
        need: usize,
    },
    /// Delay vectors need a lag and a dimension of at least 1.
    #[error("delay vectors, Eq. (25): lag {lag} and dimension {dimension} must both be at least 1")]
    NoDelay {
        /// Lag in samples.
        lag: usize,
        /// Embedding dimension.
        dimension: usize,
    },
    /// A recurrence threshold that is out of its range.
    #[error("recurrence threshold: {what}")]
    Threshold {
        /// What it should be.
        what: &'static str,
    },
}
