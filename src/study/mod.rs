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

/// Is told how far a study is, and answers whether to go on.
pub type Watch<'a, P> = &'a mut dyn FnMut(P) -> bool;

pub use pool::{NoThread, threads, wait_for};
pub use stability::{StabilityAt, StudyError, growth_causes, stability};
