//! Storage of tangent vectors during a step.

/// Tangent vectors during a step, stored component by component: component `c` of vector `l` is at `c *
/// width + l`.
#[derive(Clone, Debug)]
pub(in crate::dynamics) struct TangentBlock {
    /// Number of vectors.
    pub width: usize,
    /// At the start of the last step.
    pub start: Vec<f64>,
    /// At the end of the last step, `tangent_dim x width`.
    pub end: Vec<f64>,
    /// At a stage.
    pub stage: Vec<f64>,
    /// Slopes at the stages, `stages x tangent_dim x width`.
    pub slopes: Vec<f64>,
}
