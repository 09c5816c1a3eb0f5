//! Counts of a recurrence plot that grows or slides with the samples.

use super::RecurrenceCounts;
use crate::analysis::{AnalysisError, Norm};

/// The counts of a growing or sliding window, updated sample by sample.
pub struct RecurrenceWindow {}

impl RecurrenceWindow {
    /// A window that holds the last `length` states.
    ///
    /// # Errors
    /// [`AnalysisError::NoDelay`].
    pub fn sliding(
        _length: usize,
        _lag: usize,
        _dimension: usize,
        _norm: Norm,
        _epsilon: f64,
        _theiler: usize,
    ) -> Result<Self, AnalysisError> {
        unimplemented!()
    }

    /// A window that never forgets.
    ///
    /// # Errors
    /// [`AnalysisError::NoDelay`].
    pub fn growing(
        _lag: usize,
        _dimension: usize,
        _norm: Norm,
        _epsilon: f64,
        _theiler: usize,
    ) -> Result<Self, AnalysisError> {
        unimplemented!()
    }

    /// Takes the next samples.
    pub fn push(&mut self, _samples: &[f64]) {
        unimplemented!()
    }

    /// The counts of the states held now, exactly those of [`super::quantify`] on the same states.
    pub fn counts(&self) -> RecurrenceCounts {
        unimplemented!()
    }
}
