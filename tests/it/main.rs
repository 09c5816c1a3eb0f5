//! Integration tests by feature, in one binary to save link time.

#[cfg(feature = "cli")]
mod analyse;
#[cfg(feature = "cli")]
mod branch;
mod campaign;
#[cfg(feature = "cli")]
mod cli;
mod continuation;
mod convergence;
#[cfg(feature = "cli")]
mod damage;
#[cfg(feature = "cli")]
mod docs;
mod equations;
mod exponents;
mod export;
// Uses signals, limits and namespaces of Linux.
#[cfg(all(feature = "cli", target_os = "linux"))]
mod faults;
// Needs the server of live runs.
#[cfg(all(feature = "cli", unix))]
mod fuzz;
mod hard_cases;
mod laws;
// Ctrl-C is sent by a Unix program.
#[cfg(all(feature = "cli", unix))]
mod live;
#[cfg(feature = "cli")]
mod lyapunov;
mod mechanisms;
mod nodes;
// Uses the memory limits and peak memory of Linux.
mod imported_modes;
#[cfg(all(feature = "cli", target_os = "linux"))]
mod memory;
#[cfg(feature = "cli")]
mod mutants;
mod pipeline;
mod scenes;
mod schedules;
#[cfg(feature = "cli")]
mod schema;
#[cfg(feature = "cli")]
mod shown;
#[cfg(feature = "cli")]
mod small;
#[cfg(feature = "cli")]
mod sound;
mod squeaks;
mod stability;
mod tangent;
