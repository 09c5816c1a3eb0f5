//! Physics of the ball joint, Eq. (1) to (8).

mod assembly;
mod contact;
mod contact_force;
mod damping;
mod differentiable;
mod energy;
mod exponential;
mod friction;
mod friction_kernel;
mod growth;
mod hertz;
mod imported_modes;
mod jacobian;
mod model;
mod node_forces;
mod node_slopes;
mod nodes;
mod optional_terms;
mod patch;
pub mod reduction;
mod separation;
mod simd;
mod spec;
mod stability;
mod switching;
mod system;
mod vector;

#[cfg(test)]
mod tests;

pub use assembly::{AssemblyError, BallJoint, PUBLISHED};
pub use contact::NodeAction;
pub use damping::ContactDamping;
pub use energy::{Energy, Power};
pub use friction::{Constant, Friction, FrictionLaw, Ratio, Stribeck};
pub use growth::{Cause, CauseOfGrowth, ExplainedMode};
pub use hertz::Hertz;
pub use imported_modes::{ImportedModes, ImportedModesError, MAX_NODES};
pub use model::{MAX_MODES, Model};
pub use node_forces::NodeForces;
pub use patch::{PatchPoint, patch_direction, patch_points};
pub use simd::LANES;
pub use spec::{
    BallOnBeam, BodySpec, Contact, Frequencies, JointSpec, Quadrature, Socket, StiffnessLaw,
};
pub use stability::{LinearMode, NamedMode, StabilityError};
pub use system::{Equilibrium, Joint};
