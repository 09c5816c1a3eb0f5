//! Poincare sections: where a trajectory passes through a surface.

use super::AnalysisError;

/// Which way through the surface counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// From negative to positive.
    #[default]
    Rising,
    /// From positive to negative.
    Falling,
    /// Both.
    Both,
}

/// One passage.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// When, in samples from the first one; fractional.
    pub sample: f64,
    /// Where: the value of each channel then.
    pub point: Vec<f64>,
    /// Whether it went from negative to positive.
    pub rising: bool,
}

/// Passages of the trajectory with these `channels` through the plane `normal . x = offset`.
///
/// # Errors
/// [`AnalysisError`].
pub fn plane_section(
    _channels: &[&[f64]],
    _normal: &[f64],
    _offset: f64,
    _direction: Direction,
) -> Result<Vec<Crossing>, AnalysisError> {
    unimplemented!()
}

/// Passages of the delay trajectory of Fig. 10 through `y(t + lag) = level`; the point of each is
/// `(y(t), y(t + lag), y(t + 2 lag), ...)`, `dimension` values, the second of them the level.
///
/// # Errors
/// [`AnalysisError`].
pub fn delay_section(
    _samples: &[f64],
    _lag: usize,
    _dimension: usize,
    _level: f64,
    _direction: Direction,
) -> Result<Vec<Crossing>, AnalysisError> {
    unimplemented!()
}

/// A value at one passage and at the next.
pub fn return_map(_values: &[f64]) -> Vec<[f64; 2]> {
    unimplemented!()
}

/// Groups of passages.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    /// The group of each point, 0, 1, ... in the order of their first appearance.
    pub member: Vec<usize>,
    /// How many there are.
    pub count: usize,
    /// Whether the groups are points (each far smaller than the gaps between them); if not, the
    /// section is a curve or a cloud, and `count` means little.
    pub compact: bool,
}

/// Groups points (each a slice of equal length) that lie closer together than to the rest.
pub fn clusters(_points: &[&[f64]]) -> Clusters {
    unimplemented!()
}
