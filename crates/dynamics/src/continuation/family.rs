//! Systems that depend on a parameter.

use super::super::System;

/// Failure to build a system of a family.
pub type FamilyError = Box<dyn std::error::Error + Send + Sync>;

/// A family of systems with one real parameter.
///
/// All systems of a family have the same size, and depend smoothly on the parameter. Shooting needs their derivative
/// ([`System::differentiable`]).
pub trait Family {
    /// Builds the system at a value of the parameter.
    ///
    /// # Errors
    /// If the family has no system there.
    fn system(&self, parameter: f64) -> Result<Box<dyn System>, FamilyError>;

    /// Period of the drive at a value of the parameter, s; `None` for autonomous systems, whose period is unknown.
    fn drive_period(&self, parameter: f64) -> Option<f64>;

    /// Factors of the components of the state in the observable whose range over an orbit is its
    /// [`PeriodicOrbit::amplitude`](super::PeriodicOrbit::amplitude), at a value of the parameter. Those of the last components
    /// may be missing. The default is the first component of the state.
    fn observable(&self, _parameter: f64) -> Vec<f64> {
        vec![1.0]
    }
}
