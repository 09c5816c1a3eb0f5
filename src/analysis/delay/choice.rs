//! Lag and dimension chosen from the signal itself.

use super::{FalseNeighbours, MutualInformation};
use crate::analysis::AnalysisError;

/// How lag and dimension are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelaySearch {
    /// The largest lag tried, samples.
    pub largest_lag: usize,
    /// Bins along an axis of the joint histogram.
    pub bins: usize,
    /// The largest dimension tried.
    pub largest_dimension: usize,
    /// Share of false neighbours that is none, 0 to 1.
    pub false_share: f64,
    /// Pairs closer in time than this many samples are no neighbours; `None`: chosen.
    pub theiler: Option<usize>,
}

/// Why this lag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LagReason {
    /// First local minimum of the mutual information.
    FirstMinimum,
    /// No minimum: where it first falls below 1/e of its value at lag 0.
    FirstDecay,
    /// Neither: the largest lag tried.
    Largest,
}

/// Lag, dimension and the curves that led to them (Fig. 8).
#[derive(Clone, Debug, PartialEq)]
pub struct DelayChoice {
    /// Delay, samples.
    pub lag: usize,
    /// Why this lag.
    pub reason: LagReason,
    /// Embedding dimension.
    pub dimension: usize,
    /// Whether the share of false neighbours came down to the limit at that dimension; if not it
    /// is the one with the smallest share.
    pub unfolded: bool,
    /// Theiler window used, samples.
    pub theiler: usize,
    /// The mutual information.
    pub mutual: MutualInformation,
    /// The false neighbours at that lag.
    pub neighbours: FalseNeighbours,
}

/// Chooses lag and dimension.
///
/// # Errors
/// [`AnalysisError`].
pub fn choose_delay(_samples: &[f64], _search: &DelaySearch) -> Result<DelayChoice, AnalysisError> {
    unimplemented!()
}
