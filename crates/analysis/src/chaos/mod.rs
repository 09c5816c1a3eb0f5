//! Tests for chaos on a signal: the 0-1 test and the divergence of nearest neighbours.
//!
//! [`zero_one()`] returns a number between 0 (regular) and 1 (chaotic) and needs no state-space
//! reconstruction. [`divergence()`] estimates the largest Lyapunov exponent from delay vectors. Neither
//! test alone distinguishes chaos from noise: noise gives 1 in the 0-1 test and no scaling region in the
//! divergence.
//!
//! ```
//! use squeakscope_analysis::chaos::{DivergenceSearch, ZeroOneTest, divergence, zero_one};
//!
//! // The logistic map at 4: its exponent is ln 2.
//! let step = |x: &f64| Some(4.0 * x * (1.0 - x));
//! let signal: Vec<f64> = std::iter::successors(Some(0.3), step).take(2000).collect();
//!
//! assert!(zero_one(&signal, &ZeroOneTest::with_stride(1))?.k > 0.95);
//!
//! let search = DivergenceSearch::for_delay(1, 2, 1, signal.len());
//! let line = divergence(&signal, &search)?.region.expect("a scaling region");
//! assert!((line.slope / 2f64.ln() - 1.0).abs() < 0.05);
//! # Ok::<(), squeakscope_analysis::AnalysisError>(())
//! ```

mod divergence;
mod scaling;
mod zero_one;

pub use divergence::{Divergence, DivergenceMethod, DivergenceSearch, divergence};
pub use scaling::ScalingRegion;
pub use zero_one::{ZeroOne, ZeroOneTest, zero_one};

/// Differences below this share of the largest sample are rounding errors.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Largest absolute value.
fn largest(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |largest, x| largest.max(x.abs()))
}
