//! Studies: many simulations of one scene.

pub mod basins;
pub mod branch;
pub mod cost;
mod error;
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

pub use crate::dynamics::Stopped;
pub use error::StudyError;
pub use pool::threads;
pub use stability::{ModesAt, StabilityAt, StabilityResult, stability};
pub use subject::{Subject, Trial};

/// Receives the progress of a study: the share of the work that is done, 0 to 1, and the task. It stops the study with an
/// error.
pub type OnProgress<'a> = &'a mut dyn FnMut(f64, &str) -> Result<(), Stopped>;

/// Samples of a run between two calls of its progress.
const POLL: u64 = 16;
