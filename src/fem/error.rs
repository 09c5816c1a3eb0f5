//! What can go wrong between dimensions and mode shapes.

use super::{Elements, Harmonic};

/// An error of the finite-element model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FemError {
    /// A dimension that no body can have.
    #[error("{name} = {value} m: {requirement}")]
    Dimension {
        /// Which dimension.
        name: &'static str,
        /// Its value, m.
        value: f64,
        /// What is required of it.
        requirement: &'static str,
    },
    /// A constant that no stable elastic material has.
    #[error("material: {name} = {value}: {requirement}")]
    Material {
        /// Which constant.
        name: &'static str,
        /// Its value, in SI units.
        value: f64,
        /// What is required of it.
        requirement: &'static str,
    },
    /// An order that no elements are made of.
    #[error(
        "element order = {order}: must be a whole number from {} to {}",
        Elements::ORDERS.start(),
        Elements::ORDERS.end()
    )]
    Order {
        /// The order asked for.
        order: usize,
    },
    /// The mesh would not fit a reasonable computation.
    #[error(
        "element size {size} m asks for about {elements:.0} elements, the limit at order {order} \
         is {limit}: use a size above {smallest:.2e} m"
    )]
    TooFine {
        /// The element size asked for, m.
        size: f64,
        /// Their polynomial order.
        order: usize,
        /// About how many elements it gives.
        elements: f64,
        /// The largest number allowed at this order.
        limit: usize,
        /// The smallest size allowed at this order, m.
        smallest: f64,
    },
    /// The matrices would not fit into memory.
    #[error(
        "the finite elements take about {megabytes} MB, which the system refuses: use larger elements or fewer \
         modes, or raise the limit of memory"
    )]
    Memory {
        /// What they take, MB.
        megabytes: usize,
    },
    /// More modes asked for than the mesh has degrees of freedom.
    #[error(
        "{wanted} {harmonic} modes asked for, but the mesh resolves {available}: \
         ask for fewer, or use smaller elements or a higher order"
    )]
    TooManyModes {
        /// The family.
        harmonic: Harmonic,
        /// Number asked for.
        wanted: usize,
        /// Number of elastic modes of the mesh.
        available: usize,
    },
    /// The shifted stiffness matrix was not positive definite, or too large.
    #[error(
        "{harmonic}: the factorisation of K - sigma M failed ({reason}): \
         use a larger element size, or less extreme proportions of the body"
    )]
    Factorisation {
        /// The family.
        harmonic: Harmonic,
        /// What the factorisation reported.
        reason: String,
    },
    /// The Lanczos iteration did not reach its tolerance.
    #[error(
        "{harmonic}: {converged} of {wanted} modes converged in {steps} Lanczos steps: \
         ask for fewer modes, or use less extreme proportions of the body"
    )]
    NoConvergence {
        /// The family.
        harmonic: Harmonic,
        /// Number asked for.
        wanted: usize,
        /// Number that reached the tolerance.
        converged: usize,
        /// Lanczos steps taken.
        steps: usize,
    },
    /// A direction that does not point at the free surface of the ball.
    #[error(
        "direction {direction:?} (polar angle {polar_deg:.3} deg) does not meet the ball's free \
         surface, which reaches from 0 to {limit_deg:.3} deg: choose a smaller tilt or patch"
    )]
    OutsideBall {
        /// The direction given.
        direction: [f64; 3],
        /// Its angle from the +z axis, degrees; NaN if it is no direction at all.
        polar_deg: f64,
        /// Where the beam begins, degrees.
        limit_deg: f64,
    },
}
