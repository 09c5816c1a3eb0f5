//! Many answers from one scene.

pub mod lyapunov;
pub mod signal;
mod stability;

pub use stability::{StabilityAt, StabilityMode, StudyError, stability};
