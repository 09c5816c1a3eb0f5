//! When two states count as the same: thresholds as types.

use crate::analysis::{AnalysisError, DelayVectors, Norm};

/// How near is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// A distance, in the signal's unit.
    Distance(f64),
    /// This many times the standard deviation of the samples that the vectors are made of.
    Spread(f64),
    /// The distance at which this share of the counted pairs is recurrent, 0 to 1.
    Rate(f64),
    /// A distance for each state, such that this many others (outside the Theiler window) are
    /// near it (fixed amount of neighbours; the plot is not symmetric).
    Neighbours(usize),
}

/// Which pairs of states are recurrent, and which count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecurrenceRule {
    /// How distances are measured.
    pub norm: Norm,
    /// How near is the same.
    pub threshold: Threshold,
    /// Pairs with `|i - j| < theiler` are left out of every count: 0 keeps all, 1 (the usual)
    /// leaves out the line of identity.
    pub theiler: usize,
}

/// The distance (signal's unit) that a threshold comes to. For
/// [`Threshold::Neighbours`] use the quantification itself.
///
/// # Errors
/// [`AnalysisError`].
pub fn find_threshold(
    _vectors: &DelayVectors<'_>,
    _rule: &RecurrenceRule,
) -> Result<f64, AnalysisError> {
    unimplemented!()
}
