//! False nearest neighbours (Kennel, Brown and Abarbanel 1992).

use crate::analysis::AnalysisError;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseNeighbourSearch {
    /// Delay, samples.
    pub lag: usize,
    /// The largest dimension tried; all from 1 on are.
    pub largest_dimension: usize,
    /// Pairs closer in time than this many samples are no neighbours.
    pub theiler: usize,
    /// First criterion: growth of the distance over the distance (Kennel's R_tol, 15).
    pub distance_ratio: f64,
    /// Second criterion: new distance over the deviation of the signal (Kennel's A_tol, 2).
    pub size_ratio: f64,
}

/// The share of nearest neighbours that the next dimension parts.
#[derive(Clone, Debug, PartialEq)]
pub struct FalseNeighbours {
    /// Delay, samples.
    pub lag: usize,
    /// Share of false neighbours (either criterion), 0 to 1, for dimension 1, 2, ...
    pub share: Vec<f64>,
    /// How many points had a neighbour to judge, for dimension 1, 2, ...
    pub judged: Vec<usize>,
}

impl FalseNeighbours {
    /// The smallest dimension with a share of at most `limit`.
    pub fn dimension(&self, limit: f64) -> Option<usize> {
        let place = self.share.iter().position(|&share| share <= limit);
        place.map(|index| index + 1)
    }
}

/// Counts false nearest neighbours.
///
/// # Errors
/// [`AnalysisError`].
pub fn false_neighbours(
    _samples: &[f64],
    _search: &FalseNeighbourSearch,
) -> Result<FalseNeighbours, AnalysisError> {
    unimplemented!()
}
