//! Studies: many simulations of one scene.

pub mod basins;
pub mod branch;
pub mod cost;
pub mod friction_fit;
pub mod lyapunov;
pub mod paper;
mod pool;
pub mod response;
pub mod signal;
mod stability;
mod subject;
pub mod sweep;
#[cfg(feature = "table")]
mod table;

/// The caller of a study has stopped it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped")]
pub struct Stopped;

/// Callback on the progress of a study, which stops the study with an error.
pub type OnProgress<'a, P> = &'a mut dyn FnMut(P) -> Result<(), Stopped>;

pub use pool::{ThreadSpawnError, threads};
pub use stability::{ModesAt, StabilityAt, StabilityResult, StudyError, growth_causes, stability};
pub use subject::{Subject, Trial};
