//! Branches over a parameter: equilibria with all complex eigenvalues and the points at which modes become unstable.

#[cfg(feature = "table")]
mod coexistence;
mod diagram;
mod equilibria;
mod family;
mod hopf;
mod map;
mod orbits;
mod report;
mod result;
mod sensitivities;
#[cfg(feature = "table")]
mod table;
#[cfg(test)]
mod tests;
mod tori;

#[cfg(feature = "table")]
pub use coexistence::hysteresis_ends;
#[cfg(feature = "live")]
pub use diagram::shipped_diagram;
pub use diagram::{
    DiagramBifurcation, DiagramBifurcationKind, DiagramBranch, DiagramResponses, TiltDiagram,
    UnstableModes, tilt_diagram,
};
pub use equilibria::{BranchMode, BranchPlan, EquilibriumPoint};
pub use family::{SteadyState, SubjectFamily, portraits};
pub use hopf::{CriticalityMethod, CycleBirth, SteadyBifurcation, SteadyBifurcationKind};
pub use map::{Curve, CurvePoint, MapAxis, MapPlan, MapPoint, StabilityMap, stability_map};
pub use orbits::OrbitStarts;
pub use result::{At, Branch, BranchBifurcation, OrbitBifurcation, OrbitPoint, by_stability};
pub use sensitivities::{ModeSensitivities, ParameterSensitivity, sensitivities};
#[cfg(feature = "table")]
pub use table::write_branch;
pub use tori::{Tongue, Torus, TorusKind, TorusPoint, add_tori};
