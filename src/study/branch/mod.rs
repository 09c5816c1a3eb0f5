//! Branches over a parameter: equilibria with all complex eigenvalues and the points at which modes become unstable.

mod at;
#[cfg(feature = "table")]
mod coexistence;
mod curve;
mod diagram;
mod diagram_text;
mod differences;
mod equilibria;
mod hopf;
mod hopf_curve;
mod map;
mod orbits;
mod report;
mod result;
mod scene_family;
mod sensitivities;
mod steady;
#[cfg(feature = "table")]
mod table;
#[cfg(test)]
mod tests;
mod tori;
mod torus_curve;
mod tracking;

pub use at::At;
#[cfg(feature = "table")]
pub use coexistence::hysteresis_ends;
pub use diagram::{
    DiagramBifurcation, DiagramBifurcationKind, DiagramBranch, DiagramResponses, TiltDiagram,
    UnstableModes, settled_responses, shipped_diagram, tilt_diagram,
};
pub use differences::Differences;
pub use equilibria::{BranchMode, BranchPlan, EquilibriumPoint, add_equilibria};
pub use hopf::{CriticalityMethod, CycleBirth, SteadyBifurcation, SteadyBifurcationKind};
pub use hopf_curve::{HopfCurve, HopfCurvePoint};
pub use map::{MapAxis, MapPlan, MapPoint, StabilityMap, stability_map};
pub use orbits::{OnBranch, OrbitStarts, add_orbits};
pub use result::{Branch, BranchBifurcation, OrbitBifurcation, OrbitPoint};
pub use scene_family::{SubjectFamily, portraits};
pub use sensitivities::{ModeSensitivities, ParameterSensitivity, sensitivities};
pub use steady::{SteadyFamily, SteadyState};
#[cfg(feature = "table")]
pub use table::write_branch;
pub use tori::{Tongue, Torus, TorusKind, TorusPoint, add_tori};
pub use torus_curve::{TorusCurve, TorusCurvePoint};
