//! Errors of the training of cubature rules.

use super::RuleError;
use crate::dynamics::DynamicsError;
use crate::joint::AssemblyError;

/// A rule cannot be trained.
#[derive(Debug, thiserror::Error)]
pub enum TrainingError {
    /// The joint cannot be built at a tilt.
    #[error("the training of the contact reduction cannot build the joint")]
    Assembly(#[from] AssemblyError),
    /// A simulation for training failed.
    #[error("a simulation for the training of the contact reduction failed")]
    Simulation(#[from] DynamicsError),
    /// There are no states to train on, or the force vanishes at all of them.
    #[error("the contact reduction has no states to train on")]
    NoStates,
    /// No weights were found.
    #[error("the training of the contact reduction found no valid weights")]
    Rule(#[from] RuleError),
    /// No rule with fewer nodes is accurate enough.
    #[error(
        "no contact reduction with up to {kept} of {nodes} nodes reaches a relative error of \
         {tolerance:e}, half of the tolerance; the smallest error is {error:e}"
    )]
    Tolerance {
        /// Nodes of the largest rule.
        kept: usize,
        /// Nodes of the full patch.
        nodes: usize,
        /// The required error at the held-out states, half of the tolerance.
        tolerance: f64,
        /// The smallest error found.
        error: f64,
    },
}
