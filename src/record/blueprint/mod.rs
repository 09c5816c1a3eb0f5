//! The layout of the viewer: views, their positions, ranges and cameras.
//!
//! `layout.txt` has the tabs; `run` and `record::series` give the views. Rerun's Rust interface has views and containers, but
//! no setters for most properties of a view (time range, axis range, legend, bounds, camera). The module `tree` therefore
//! writes blueprints itself.

pub mod layout;
pub mod run;
pub mod tree;

pub use run::send;
