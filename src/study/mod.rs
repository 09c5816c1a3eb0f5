//! Many answers from one scene.

mod stability;

pub use stability::{StabilityAt, StabilityMode, StudyError, stability};
