//! Integration tests, by promise. One binary, so that it is linked once.

#[cfg(feature = "cli")]
mod analyse;
mod campaign;
#[cfg(feature = "cli")]
mod cli;
mod convergence;
#[cfg(feature = "cli")]
mod damage;
mod equations;
mod exponents;
mod export;
// Signals, limits and namespaces are those of Linux.
#[cfg(all(feature = "cli", target_os = "linux"))]
mod faults;
// With the server of the live runs.
#[cfg(all(feature = "cli", unix))]
mod fuzz;
mod hard_cases;
#[cfg(feature = "cli")]
mod json;
mod laws;
mod layering;
// Ctrl-C is sent by a program of Unix.
#[cfg(all(feature = "cli", unix))]
mod live;
#[cfg(feature = "cli")]
mod lyapunov;
mod mechanisms;
// Limits and peaks of memory as Linux has them.
#[cfg(all(feature = "cli", target_os = "linux"))]
mod memory;
#[cfg(feature = "cli")]
mod mutants;
mod own_modes;
mod pipeline;
mod scenes;
mod schedules;
#[cfg(feature = "cli")]
mod shown;
#[cfg(feature = "cli")]
mod small;
#[cfg(feature = "cli")]
mod sound;
mod stability;
mod tangent;
