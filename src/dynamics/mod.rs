//! Numerical integration of oscillators with nonlinear, non-smooth forces. Knows no joint.

mod system;
mod tally;

pub use system::System;
pub use tally::Tally;
