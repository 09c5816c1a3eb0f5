//! Chaos from data alone: do neighbours part exponentially?

mod divergence;
mod zero_one;

pub use divergence::{Divergence, DivergenceMethod, DivergenceSearch, ScalingRegion, divergence};
pub use zero_one::{ZeroOne, ZeroOneTest, zero_one};
