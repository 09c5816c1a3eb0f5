//! Systems that depend on a parameter.

use super::super::System;

/// Failure to build a system of a family.
pub type FamilyError = Box<dyn std::error::Error + Send + Sync>;

/// A system of a family.
pub struct FamilyMember {
    /// The system.
    pub system: Box<dyn System>,
    /// Period of the drive, s; `None` for an autonomous system, whose period is unknown.
    pub drive_period: Option<f64>,
    /// Factors of the components of the state in the observable whose range over an orbit is its
    /// [`PeriodicOrbit::amplitude`](super::PeriodicOrbit::amplitude). Those of the last components may be missing.
    pub observable: Vec<f64>,
}

/// A family of systems with one real parameter.
///
/// All systems of a family have the same size, and depend smoothly on the parameter. Shooting needs their derivative
/// ([`System::differentiable`]).
pub trait Family {
    /// Builds the system at a value of the parameter.
    ///
    /// # Errors
    /// If the family has no system there.
    fn member(&self, parameter: f64) -> Result<FamilyMember, FamilyError>;
}
