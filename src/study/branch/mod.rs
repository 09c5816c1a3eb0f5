//! Branches over a parameter: equilibria with all complex eigenvalues and the points at which modes become unstable.

mod diagram;
mod equilibria;
mod family;
mod map;
mod orbits;
mod result;
mod sensitivities;
#[cfg(feature = "table")]
mod table;
#[cfg(test)]
mod tests;
mod tori;

pub use diagram::{
    DiagramBifurcation, DiagramBifurcationKind, DiagramBranch, DiagramResponses, TiltDiagram,
    UnstableModes, shipped_diagram, tilt_diagram,
};
pub use equilibria::{
    BranchMode, BranchPlan, CriticalityMethod, CycleBirth, EquilibriumPoint, SteadyBifurcation,
    SteadyBifurcationKind,
};
pub use family::{SteadyState, SubjectFamily};
pub use map::{Curve, CurvePoint, MapAxis, MapPlan, MapPoint, StabilityMap, stability_map};
pub use orbits::OrbitStarts;
#[cfg(feature = "table")]
pub use orbits::hysteresis_ends;
pub use result::{At, Branch, BranchBifurcation, OrbitBifurcation, OrbitPoint, by_stability};
pub use sensitivities::{ModeSensitivities, ParameterSensitivity, sensitivities};
#[cfg(feature = "table")]
pub use table::write_branch;
pub use tori::{Tongue, Torus, TorusKind, TorusPoint, add_tori};
