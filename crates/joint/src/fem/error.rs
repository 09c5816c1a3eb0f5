//! Errors of the finite-element model.

use super::{Elements, Harmonic};

/// An error of the finite-element model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FemError {
    /// An invalid dimension or material constant: which, and the requirement.
    #[error("{0}")]
    Input(String),
    /// An element order that is not implemented.
    #[error(
        "element order = {order}: must be a whole number from {} to {}",
        Elements::ORDERS.start(),
        Elements::ORDERS.end()
    )]
    Order {
        /// Order given.
        order: usize,
    },
    /// The mesh would be too large for a reasonable computing time.
    #[error(
        "element size {size} m would give about {elements:.0} elements, the limit at order {order} \
         is {limit}: use a size above {smallest:.2e} m"
    )]
    TooFine {
        /// Element size given, m.
        size: f64,
        /// Polynomial order of the elements.
        order: usize,
        /// Approximate number of elements.
        elements: f64,
        /// Maximum number of elements at this order.
        limit: usize,
        /// Minimum element size at this order, m.
        smallest: f64,
    },
    /// The matrices do not fit into memory.
    #[error(
        "the finite elements need about {megabytes} MB of memory, which is not available: use larger \
         elements or fewer modes, or raise the memory limit"
    )]
    Memory {
        /// Memory required, MB.
        megabytes: usize,
    },
    /// More modes requested than the mesh has degrees of freedom.
    #[error(
        "{wanted} {harmonic} modes requested, but the mesh resolves only {available}: \
         request fewer, or use smaller elements or a higher order"
    )]
    TooManyModes {
        /// Family of the modes.
        harmonic: Harmonic,
        /// Number requested.
        wanted: usize,
        /// Number of elastic modes of the mesh.
        available: usize,
    },
    /// The shifted stiffness matrix is not positive definite or too large.
    #[error(
        "{harmonic}: the factorisation of K - sigma M failed ({reason}): \
         use a larger element size or less extreme proportions of the body"
    )]
    Factorisation {
        /// Family of the modes.
        harmonic: Harmonic,
        /// Message of the factorisation.
        reason: String,
    },
    /// The Lanczos iteration did not reach its tolerance.
    #[error(
        "{harmonic}: {converged} of {wanted} modes converged in {steps} Lanczos steps: \
         request fewer modes, or use less extreme proportions of the body"
    )]
    NoConvergence {
        /// Family of the modes.
        harmonic: Harmonic,
        /// Number requested.
        wanted: usize,
        /// Number that reached the tolerance.
        converged: usize,
        /// Number of Lanczos steps.
        steps: usize,
    },
    /// An eigenvalue that is not resolved in floating point, as of a very long and thin beam.
    #[error(
        "{harmonic}: the frequency of mode {mode} is lost in rounding errors: \
         use less extreme proportions of the body, or larger elements"
    )]
    Rounding {
        /// Family of the modes.
        harmonic: Harmonic,
        /// Number of the mode within the family, from 1.
        mode: usize,
    },
    /// A direction that does not point to the free surface of the ball.
    #[error(
        "direction {direction:?} (polar angle {polar_deg:.3} deg) does not point to the ball's free \
         surface, which extends from 0 to {limit_deg:.3} deg: choose a smaller tilt or patch"
    )]
    OutsideBall {
        /// Direction given.
        direction: [f64; 3],
        /// Its polar angle from the +z axis, degrees; NaN for an invalid direction.
        polar_deg: f64,
        /// Polar angle at which the beam begins, degrees.
        limit_deg: f64,
    },
}
