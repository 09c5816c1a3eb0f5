//! Continuation of periodic orbits in one parameter, with Floquet multipliers and bifurcations.
//!
//! A sweep of simulations shows attractors. A branch shows periodic orbits whether they attract or not, and
//! therefore where and why an attractor is lost. [`continue_orbits`] follows a family of orbits of a [`Family`] of
//! systems through folds and reports its [`Bifurcation`]s.
//!
//! # Method
//!
//! * *Multiple shooting.* The period is divided into segments. The unknowns are the states at their starts, the
//!   period (of an autonomous system) and the parameter. Newton's method uses the tangent flow of each segment,
//!   which passes events with their saltation correction. The number of segments follows the growth and contraction
//!   of the flow, and the linear systems of all segments are solved by a sparse QR factorisation: neither needs the
//!   product of the segments (U. Ascher, R. Mattheij, R. Russell, Numerical Solution of Boundary Value
//!   Problems for Ordinary Differential Equations, SIAM 1995; S. J. Wright, SIAM J. Sci. Stat. Comput. 13 (1992)
//!   742-764).
//! * *Phase.* The phase of an autonomous orbit is fixed by the integral condition relative to the preceding orbit,
//!   summed over the segment starts (E. J. Doedel, H. B. Keller, J. P. Kernévez, Int. J. Bifurcation Chaos 1 (1991)
//!   745-772). A forced system has the period of its drive, or a multiple of it, and no free phase.
//! * *Pseudo-arclength.* Steps follow the tangent of the branch, and the correction is orthogonal to it (H. B.
//!   Keller, in: Applications of Bifurcation Theory, Academic Press 1977, 359-384). The step length follows the
//!   number of Newton iterations and the angle between successive tangents.
//! * *Multipliers.* The Floquet multipliers are the generalized eigenvalues of the two matrices that are left of the
//!   segments when all states but the first are eliminated (T. F. Fairgrieve, A. D. Jepson, SIAM J. Numer. Anal. 28 (1991)
//!   1446-1462). Those below about 1e-15 of the largest or of 1 are lost in rounding errors, and zero. The multiplier of an
//!   autonomous orbit that should equal 1 measures the error.
//! * *Bifurcations* are zeros of test functions along the branch, located by a bracketing secant method.
//!
//! # Limits
//!
//! The flow must be differentiable along the orbit. At a grazing impact it is not: the branch is split there, or
//! ends. Through kinks of a continuous system ([`Switching::is_continuous`](super::Switching::is_continuous)) the
//! flow is differentiable once, which Newton's method needs.

mod bifurcation;
mod branch;
mod cyclic;
#[cfg(test)]
mod cyclic_tests;
mod detect;
mod ends;
mod error;
mod family;
mod flow;
mod follow;
mod locate;
mod mesh;
#[cfg(test)]
mod multipliers_tests;
mod newton;
mod normal_form;
mod options;
mod orbit;
mod point;
mod shape;
mod shooting;
mod start;
mod step;

pub use bifurcation::{Bifurcation, BifurcationKind, Criticality, MotionBirth, Resonance};
pub use branch::{BranchEnd, OrbitBranch};
pub use error::ContinuationError;
pub use family::{Family, FamilyError, FamilyMember};
pub use follow::{OnOrbit, continue_orbits};
pub use options::{ContinuationOptions, StepLimits};
pub use orbit::{Multiplier, OrbitSegment, PeriodicOrbit};
pub use start::{BranchStart, ReturnSearch, doubled_orbit, hopf_orbit, settled_orbit};
