//! Average mutual information: how much does the signal now tell of the signal a lag later?

use crate::analysis::AnalysisError;

/// Average mutual information of `x[n]` and `x[n + lag]`, by lag.
#[derive(Clone, Debug, PartialEq)]
pub struct MutualInformation {
    /// Bins along an axis of the joint histogram.
    pub bins: usize,
    /// `I(lag)` in bits for lag 0, 1, ..., the largest asked for.
    pub bits: Vec<f64>,
}

impl MutualInformation {
    /// The first lag (samples) at which it has a local minimum.
    pub fn first_minimum(&self) -> Option<usize> {
        unimplemented!()
    }
}

/// Average mutual information at the lags 0 to `largest_lag`.
///
/// # Errors
/// [`AnalysisError`].
pub fn mutual_information(
    _samples: &[f64],
    _largest_lag: usize,
    _bins: usize,
) -> Result<MutualInformation, AnalysisError> {
    unimplemented!()
}
