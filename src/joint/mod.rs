//! The physics of the ball joint, Eq. (1) to (8).

mod assembly;
mod causes;
mod contact;
mod damping;
mod differentiable;
mod energy;
mod exponential;
mod extras;
mod friction;
mod hertz;
mod jacobian;
mod lanes;
mod law;
mod lift_off;
mod model;
mod nodes;
mod own_modes;
mod patch;
mod record;
mod spec;
mod stability;
mod switching;
mod system;
mod traction;
mod vector;

#[cfg(test)]
mod tests;

pub use assembly::{AssemblyError, BallJoint, PUBLISHED};
pub use causes::{Cause, CauseOfGrowth, ExplainedMode};
pub use contact::NodeAction;
pub use damping::ContactDamping;
pub use energy::{Energy, Power};
pub use friction::{Constant, Friction, FrictionLaw, Ratio, Stribeck};
pub use hertz::Hertz;
pub use lanes::LANES;
pub use model::{MOST_MODES, Model};
pub use own_modes::{MOST_NODES, OwnModes, OwnModesError};
pub use patch::{PatchPoint, patch_direction, patch_points};
pub use spec::{
    BallOnBeam, BodySpec, Contact, Frequencies, JointSpec, Quadrature, Socket, StiffnessLaw,
};
pub use stability::{LinearMode, NamedMode, StabilityError};
pub use system::{Equilibrium, Joint};
