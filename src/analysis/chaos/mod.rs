//! Chaos from data alone: does the signal drive a point adrift, do neighbours part exponentially?
//!
//! [`zero_one()`] answers the first with a number between 0 and 1 and needs no state space;
//! [`divergence()`] the second, with a rate in a state space of delay vectors. Neither tells chaos
//! from noise by itself: noise gives 1 to the first, and to the second no rate at all.
//!
//! ```
//! use squeakscope::analysis::{DivergenceSearch, ZeroOneTest, divergence, zero_one};
//!
//! // The logistic map at 4: its exponent is ln 2.
//! let step = |x: &f64| Some(4.0 * x * (1.0 - x));
//! let signal: Vec<f64> = std::iter::successors(Some(0.3), step).take(2000).collect();
//!
//! assert!(zero_one(&signal, &ZeroOneTest::with_stride(1))?.k > 0.95);
//!
//! let search = DivergenceSearch::for_delay(1, 2, 1, signal.len());
//! let line = divergence(&signal, &search)?.region.expect("neighbours part exponentially");
//! assert!((line.slope / 2f64.ln() - 1.0).abs() < 0.05);
//! # Ok::<(), squeakscope::analysis::AnalysisError>(())
//! ```

mod divergence;
mod scaling;
mod zero_one;

pub use divergence::{Divergence, DivergenceMethod, DivergenceSearch, divergence};
pub use scaling::ScalingRegion;
pub use zero_one::{ZeroOne, ZeroOneTest, zero_one};

/// A difference below this share of the largest sample is rounding, not motion.
const ROUNDING: f64 = 1e-12;

/// The largest absolute value.
fn largest(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |largest, x| largest.max(x.abs()))
}
