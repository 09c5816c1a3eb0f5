//! A branch of periodic orbits.

use schemars::JsonSchema;
use serde::Serialize;

use super::{Bifurcation, PeriodicOrbit};
use crate::Stopped;

/// The reason why a branch ends.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "reason", rename_all = "kebab-case")]
pub enum BranchEnd {
    /// A bound of the parameter was reached; the last point is on it.
    ParameterBound,
    /// The branch returned to its first point.
    Closed,
    /// Newton's method did not converge at the minimum step.
    NotConverged {
        /// What happened at the last attempt.
        message: String,
    },
    /// The orbit touches a guard, and no orbit with another sequence of events was found beyond.
    Grazing {
        /// Value of the parameter.
        parameter: f64,
        /// Index of the guard; `None` if the sequence of events changed in another way.
        guard: Option<usize>,
    },
    /// The amplitude vanishes: the orbit was born in a Hopf bifurcation there.
    Hopf {
        /// Value of the parameter at zero amplitude, by extrapolation.
        parameter: f64,
        /// Frequency there, Hz.
        frequency_hz: f64,
    },
    /// The orbit of twice the period coincides with one of half its period: a period doubling of that orbit.
    PeriodHalved {
        /// Value of the parameter there, by interpolation.
        parameter: f64,
    },
    /// The maximum number of points was reached.
    MaxPoints,
    /// The caller stopped the computation.
    Stopped,
}

/// A branch of periodic orbits of a family.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct OrbitBranch {
    /// The orbits in their order along the branch.
    pub points: Vec<PeriodicOrbit>,
    /// The bifurcations in their order along the branch.
    pub bifurcations: Vec<Bifurcation>,
    /// Intervals of the parameter between two successive points in which the number of multipliers outside the unit circle
    /// changes without an identified bifurcation.
    pub unresolved: Vec<[f64; 2]>,
    /// Why the branch ends before its first point and after its last one. A branch that was followed in one direction
    /// has no end at its start.
    pub ends: [Option<BranchEnd>; 2],
    /// Newton iterations of all orbits, including those of the location of bifurcations.
    pub newton_iterations: u64,
}

impl OrbitBranch {
    /// Checks that the branch is complete.
    ///
    /// # Errors
    /// If the caller stopped it.
    pub fn complete(&self) -> Result<(), Stopped> {
        if self.ends.contains(&Some(BranchEnd::Stopped)) {
            return Err(Stopped);
        }
        Ok(())
    }
}
