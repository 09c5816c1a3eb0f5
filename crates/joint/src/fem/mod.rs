//! Finite elements for a solid of revolution. Independent of the joint model.
//!
//! A body of revolution vibrates in circumferential harmonics: each mode is a field on the meridian
//! half-plane `(r, z)` times a cosine or sine of `n theta`. A two-dimensional mesh of the section is
//! therefore sufficient. It is exact in the angle and about a hundred times smaller than a solid mesh of
//! equal accuracy. A ball on a beam needs the harmonics 0 (torsion; axial motion) and 1 (bending, in
//! pairs that differ by a rotation of 90 degrees).
//!
//! ```text
//! Geometry -> Section (mesh) -> K, M (one pair per family) -> shift-invert Lanczos -> BodyModes
//! ```
//!
//! * The section: quadrilaterals of order 1 to 8 ([`Elements`]), curved on the sphere and graded towards
//!   the re-entrant corner between ball and beam.
//! * The harmonics: strains and axis conditions of a family.
//! * [`BodyModes`]: frequencies, labels and mass-normalised mode shapes on the surface.
//!
//! Limits: linear elasticity, small displacements, no damping, no gyroscopic terms. Rounding in the
//! assembled stiffness matrix causes a relative frequency error of at most about `1e-16 (c / (h_min
//! omega))^2`, with the wave speed `c` and the smallest node distance `h_min`. Observed errors are 1e-8
//! for the paper's body on fine meshes and 1e-3 for the first mode of a beam with a length of 200
//! diameters.
//!
//! The method is that of Wilson, AIAA J. 3, 1965, 2269 (Fourier series in the angle), with spectral
//! elements.
//!
//! ```
//! use squeakscope_joint::fem::{
//!     BodyModes, Elements, Families, Geometry, LengthReading, Material,
//! };
//!
//! let geometry = Geometry {
//!     ball_diameter: 31.75e-3,
//!     beam_diameter: 20e-3,
//!     beam_length: 200e-3,
//!     reading: LengthReading::ToSphere,
//! };
//! let steel = Material { young: 207e9, poisson: 0.30, density: 7800.0 };
//! let families = Families { bending_pairs: 1, torsion: 1, axial: 0 };
//! let body = BodyModes::solve(&geometry, &steel, &Elements::default(), &families)?;
//! let labels: Vec<String> = body.modes().iter().map(|mode| mode.label()).collect();
//! assert_eq!(labels, ["1st bending x", "1st bending y", "1st torsion"]);
//!
//! let mut shapes = [[0.0; 3]; 3];
//! body.shapes_at_ball([0.0, 0.0, 1.0], &mut shapes)?;
//! assert!(shapes[0][0] > 0.0 && shapes[0][1] == 0.0);
//! # Ok::<(), squeakscope_joint::fem::FemError>(())
//! ```

mod assembly;
mod bodies;
mod body;
mod eigen;
mod element;
mod error;
mod harmonic;
mod meridian;
mod normals;
mod section;
mod spec;
mod surface;
#[cfg(test)]
mod surface_tests;
#[cfg(test)]
mod tests;

pub use body::{BodyMode, BodyModes, SurfaceMesh};
pub(crate) use element::gauss_rule;
pub use error::FemError;
use harmonic::Harmonic;
use meridian::MeridianMode;
pub use normals::vertex_normals;
use section::Section;
pub use spec::{Elements, Families, Geometry, LengthReading, Material, ModeKind};
