//! Distances between vectors.

/// How the distance of two vectors is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Norm {
    /// `sqrt(sum_c d_c^2)`.
    #[default]
    Euclidean,
    /// `max_c |d_c|`.
    Maximum,
    /// `sum_c |d_c|`.
    Manhattan,
}
