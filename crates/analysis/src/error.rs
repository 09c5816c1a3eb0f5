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
    /// The lag or the dimension of the delay vectors is 0.
    #[error("delay vectors, Eq. (25): lag {lag} and dimension {dimension} must both be at least 1")]
    InvalidDelay {
        /// Lag, samples.
        lag: usize,
        /// Embedding dimension.
        dimension: usize,
    },
    /// All components of the plane normal are zero.
    #[error("section: the plane normal is zero; give at least one non-zero component")]
    ZeroNormal,
    /// The delay section has no second coordinate, in which it is defined.
    #[error("delay section: dimension {dimension} is too small; give at least 2")]
    SectionDimension {
        /// Embedding dimension.
        dimension: usize,
    },
    /// The number of channels differs from the number of components of the normal.
    #[error(
        "section: {have} channels given, {need} needed; give one channel per component of the normal"
    )]
    ChannelCount {
        /// Channels given.
        have: usize,
        /// Channels needed.
        need: usize,
    },
    /// The channels of one trajectory differ in length.
    #[error("section: the channels differ in length; cut them to the same time range")]
    ChannelLength,
    /// The recurrence threshold is out of range.
    #[error("recurrence threshold: {what}")]
    Threshold {
        /// Valid range.
        what: &'static str,
    },
    /// A count that must be at least 1 is 0.
    #[error("{what} must be at least 1")]
    ZeroCount {
        /// Analysis and parameter.
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
    /// All samples are equal.
    #[error("all samples are equal, so there is nothing to analyse; choose another section")]
    Constant,
}
