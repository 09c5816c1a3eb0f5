//! All counts of a recurrence plot without ever storing it.

use super::{RecurrenceCounts, RecurrenceRule};
use crate::analysis::{AnalysisError, DelayVectors};

/// Counts the recurrence plot of these vectors.
///
/// # Errors
/// [`AnalysisError`].
pub fn quantify(
    _vectors: &DelayVectors<'_>,
    _rule: &RecurrenceRule,
) -> Result<RecurrenceCounts, AnalysisError> {
    unimplemented!()
}
