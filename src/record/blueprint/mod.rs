//! The layout of the viewer: views, their positions, ranges and cameras.
//!
//! `layout.txt` has the tabs, `run` and `sweep` the views. Rerun's Rust interface has views and containers, but no setters
//! for most properties of a view (time range, axis range, legend, bounds, camera). The module `tree` therefore writes
//! blueprints itself.

mod branch;
pub mod layout;
pub mod run;
mod sweep;
pub mod tree;

pub use branch::send as send_branch;
pub use run::send;
pub use sweep::send as send_sweep;
