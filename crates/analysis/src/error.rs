//! Errors of the analyses.

use crate::memory::MemoryShortage;

/// Error of an analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AnalysisError {
    /// The slice is too short for the analysis.
    #[error("{what}: {have} samples are too few; give at least {need} or choose a shorter window")]
    TooShort {
        /// Name of the analysis.
        what: &'static str,
        /// Samples given.
        have: usize,
        /// Samples needed.
        need: usize,
    },
    /// The lag or the dimension of the delay vectors is 0, or the dimension of a section below 2.
    #[error(
        "delay vectors, Eq. (25): lag {lag} and dimension {dimension} must both be at least 1, the dimension of a \
         section at least 2"
    )]
    InvalidDelay {
        /// Lag, samples.
        lag: usize,
        /// Embedding dimension.
        dimension: usize,
    },
    /// The recurrence threshold is out of range.
    #[error("recurrence threshold: {what}")]
    Threshold {
        /// Valid range.
        what: &'static str,
    },
    /// The number of histogram bins per axis is out of range.
    #[error("mutual information: {bins} bins per axis is out of range; give 2 to {most}")]
    Bins {
        /// Bins given.
        bins: usize,
        /// Maximum number of bins.
        most: usize,
    },
    /// Squares of the samples overflow or underflow.
    #[error(
        "the sample magnitude exceeds 1e140 or the range is below 1e-140, so squares overflow or \
         underflow; scale the signal to another unit"
    )]
    SampleRange,
    /// The buffers of an analysis exceed the available memory.
    #[error(
        "the analysis of {samples} samples does not fit into memory: {shortage}; choose a shorter section"
    )]
    Memory {
        /// Number of samples.
        samples: usize,
        /// Memory needed and available.
        shortage: MemoryShortage,
    },
}

impl AnalysisError {
    /// Checks that an analysis has the samples that it needs.
    pub(crate) fn check_length(what: &'static str, have: usize, need: usize) -> Result<(), Self> {
        if have < need {
            return Err(Self::TooShort { what, have, need });
        }
        Ok(())
    }
}
