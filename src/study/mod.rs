//! Many answers from one scene.

pub mod basins;
pub mod calibrate;
pub mod cost;
pub mod effects;
pub mod growth;
pub mod lyapunov;
pub mod paper;
mod pool;
pub mod response;
pub mod signal;
mod stability;
pub mod sweep;

pub use pool::{NoThread, threads, wait_for};
pub use stability::{StabilityAt, StabilityMode, StudyError, growth_causes, stability};
