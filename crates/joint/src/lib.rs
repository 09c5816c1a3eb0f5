//! Physics of the ball joint, Eq. (1) to (8).

#![cfg_attr(
    test,
    allow(
        clippy::too_many_lines,
        reason = "a test that reads from top to bottom is easier to follow than one split into helpers"
    )
)]

mod assembly;
mod contact;
mod contact_force;
mod dual;
mod dynamic_friction;
mod energy;
pub mod fem;
mod friction;
mod friction_table;
mod growth;
mod hertz;
mod imported_modes;
mod model;
mod nodes;
mod normal;
mod patch;
mod published;
mod simd;
mod spec;
mod stability;
mod switching;
mod system;
pub mod systems;
mod tangent;
mod vector;

#[cfg(test)]
mod tests;

pub use assembly::{AssemblyError, BallJoint, Loading};
pub use contact::{NodeAction, NodeForces};
pub use dynamic_friction::{
    DynamicFriction, LuGre, MAX_NODES_WITH_STATES, OscillatingFriction, RateAndState,
};
pub use energy::Energy;
pub use friction::{Friction, FrictionLaw, Ratio, Stribeck};
pub use friction_table::FrictionTable;
pub use growth::{Cause, CauseOfGrowth, ExplainedMode};
pub use hertz::Hertz;
pub use imported_modes::{ArrayError, ImportedModes, ImportedModesError, MAX_NODES, NamedArrays};
pub use model::{MAX_MODES, Model};
pub use normal::ContactDamping;
pub use patch::{PatchFrame, PatchPoint, PressureTable, patch_direction, patch_points};
pub use published::PUBLISHED;
pub use spec::{
    BallOnBeam, BodySpec, Contact, Frequencies, JointSpec, Quadrature, Socket, StiffnessLaw,
};
pub use stability::{LinearMode, MIN_GROWTH, NamedMode, is_unstable};
pub use system::{Equilibrium, Joint};
