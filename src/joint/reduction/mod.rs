//! Hyper-reduction of the contact: a few nodes with weights reproduce the generalised force of all nodes.
//!
//! Contact and friction act on few modal coordinates, through mode shapes that vary smoothly over the patch.
//! The contributions of the nodes to the generalised force are therefore nearly dependent, and a weighted sum
//! over a few nodes replaces that over all of them:
//!
//! ```text
//! f(z) = sum over all nodes k of f_k(z)  ~  sum over kept nodes k of w_k f_k(z),     w_k > 0
//! ```
//!
//! Nodes and weights solve a non-negative least-squares problem over states of the motion. The method is
//! empirical cubature (J. A. Hernandez et al., Comput. Methods Appl. Mech. Engrg. 313 (2017) 687) or
//! energy-conserving sampling and weighting (C. Farhat et al., Int. J. Numer. Meth. Engng 102 (2015) 1077).
//! [`reduce`] returns a [`CubatureRule`] for a joint; with
//! [`BallJoint::with_reduction`](super::BallJoint::with_reduction) its models contain the kept nodes only.
//!
//! * A weight multiplies area and load of a node, so that pre-stress, stiffness per area and slip velocity are
//!   those of the full patch. Separation, friction laws, derivatives, events and energies need no changes.
//!   Positive weights keep springs elastic and friction dissipative: the energy balance is exact.
//! * The state is the perturbation from steady sliding, so that the equilibrium is exact for any rule. The
//!   equations contain its force, the load, the area and the linearised stiffness and damping.
//! * Nodes are fixed in the coordinates of the patch: one rule serves all tilts, loads and rotations. How well
//!   is measured with [`errors_of`] on states that were not trained on, and with [`ForceChecker`] during a
//!   simulation.
//! * Where nodes separate or slip reverses, the force has kinks within the patch. The error then decreases
//!   slowly with the number of kept nodes, as does that of the full patch.

mod certificate;
mod error;
mod nnls;
mod request;
mod rule;
mod selection;
mod shipped;
mod snapshots;
mod states;
mod training;

#[cfg(test)]
mod tests;

pub use certificate::{ForceCheck, ForceChecker, ReductionErrors};
pub use error::TrainingError;
pub use request::replacement;
pub use rule::{CubatureRule, KeptNode, RuleError};
pub use selection::{RuleSource, TrainingPlan, reduce, train};
pub use shipped::shipped_rules;
pub use states::Excitation;
pub use training::{RuleErrors, TrainedRule, Trainer, TrainingCase, errors_of};
