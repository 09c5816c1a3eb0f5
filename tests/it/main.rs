//! Integration tests, by promise. One binary, so that it is linked once.

#[cfg(feature = "cli")]
mod analyse;
#[cfg(feature = "cli")]
mod cli;
mod convergence;
mod equations;
mod exponents;
mod export;
mod laws;
mod layering;
#[cfg(feature = "cli")]
mod lyapunov;
mod pipeline;
mod scenes;
mod schedules;
#[cfg(feature = "cli")]
mod small;
mod stability;
mod tangent;
