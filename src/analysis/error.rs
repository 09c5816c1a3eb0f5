//! What can be wrong with a signal.

use crate::memory::MemoryShortage;

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
    /// A plane needs a normal.
    #[error("section: the normal of the plane is zero throughout; give it a direction")]
    NoPlane,
    /// A section of a delay trajectory has its level in the second coordinate.
    #[error("delay section: a dimension of {dimension} has no second coordinate; give at least 2")]
    FlatSection {
        /// Embedding dimension.
        dimension: usize,
    },
    /// Channels and what is to be done with them do not fit.
    #[error("section: {have} channels given, {need} needed, one for each component of the normal")]
    ChannelCount {
        /// Channels given.
        have: usize,
        /// Channels needed.
        need: usize,
    },
    /// Channels of one trajectory are sampled together.
    #[error("section: the channels differ in length; cut them to the same instants")]
    UnevenChannels,
    /// A recurrence threshold that is out of its range.
    #[error("recurrence threshold: {what}")]
    Threshold {
        /// What it should be.
        what: &'static str,
    },
    /// Something counted from 1 is 0.
    #[error("{what} must be at least 1")]
    Zero {
        /// The analysis and its parameter.
        what: &'static str,
    },
    /// A joint histogram needs a sensible number of bins along an axis.
    #[error("mutual information: {bins} bins along an axis; give 2 to {most}")]
    Bins {
        /// Bins asked for.
        bins: usize,
        /// The most that are possible.
        most: usize,
    },
    /// Squares of the samples would overflow or vanish.
    #[error(
        "the samples are too large or too much alike to be squared: magnitudes up to 1e140 and a \
         range from 1e-140 on can be analysed; give them in another unit"
    )]
    Size,
    /// The buffers of an analysis do not fit into the memory.
    #[error(
        "the analysis of {samples} samples does not fit into memory: {shortage}; give a shorter stretch"
    )]
    Memory {
        /// How many samples.
        samples: usize,
        /// By how much.
        shortage: MemoryShortage,
    },
    /// The signal does not move.
    #[error("all samples are the same: there is nothing to analyse; choose another stretch")]
    Constant,
}
