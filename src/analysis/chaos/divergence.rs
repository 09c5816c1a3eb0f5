//! The largest Lyapunov exponent of a signal, from how neighbours part.

use crate::analysis::AnalysisError;

/// Whose distance is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DivergenceMethod {
    /// The nearest neighbour of each state (Rosenstein, Collins and De Luca 1993).
    Rosenstein,
    /// All neighbours within a radius, given as a share of the signal's deviation (Kantz 1994).
    Kantz {
        /// Radius over the standard deviation of the samples.
        radius: f64,
    },
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DivergenceSearch {
    /// Delay, samples.
    pub lag: usize,
    /// Embedding dimension.
    pub dimension: usize,
    /// Pairs closer in time than this many samples are no neighbours.
    pub theiler: usize,
    /// How long neighbours are followed, samples.
    pub horizon: usize,
    /// Whose distance is followed.
    pub method: DivergenceMethod,
    /// At most this many states are followed, evenly spread.
    pub most_references: usize,
}

/// The part of the curve that is a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalingRegion {
    /// First step of the region, samples.
    pub from: usize,
    /// Last step of the region, samples.
    pub to: usize,
    /// Slope, 1/sample: the largest exponent is this times the sample rate.
    pub slope: f64,
    /// Standard error of the slope, 1/sample.
    pub error: f64,
    /// Value of the line at step 0.
    pub intercept: f64,
}

/// How neighbours part.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Mean natural logarithm of the distance after 0, 1, ... samples.
    pub curve: Vec<f64>,
    /// How many pairs (Rosenstein) or states (Kantz) each value is the mean of.
    pub counted: Vec<usize>,
    /// The straight part, if there is one.
    pub region: Option<ScalingRegion>,
}

/// Follows neighbours.
///
/// # Errors
/// [`AnalysisError`].
pub fn divergence(
    _samples: &[f64],
    _search: &DivergenceSearch,
) -> Result<Divergence, AnalysisError> {
    unimplemented!()
}
