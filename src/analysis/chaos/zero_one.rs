//! The 0-1 test for chaos (Gottwald and Melbourne).

use crate::analysis::AnalysisError;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroOneTest {
    /// Every so many samples one is taken: samples that follow too closely hide chaos.
    pub stride: usize,
    /// How many frequencies are tried.
    pub frequencies: usize,
    /// Seed of the random frequencies.
    pub seed: u64,
}

/// Its result.
#[derive(Clone, Debug, PartialEq)]
pub struct ZeroOne {
    /// Median over the frequencies: near 0 regular, near 1 chaotic.
    pub k: f64,
    /// Frequency `c` (rad) and `K_c` of each.
    pub by_frequency: Vec<[f64; 2]>,
    /// Path `(p, q)` of the translation variables at the frequency of the median.
    pub path: Vec<[f64; 2]>,
    /// Samples used.
    pub samples: usize,
}

/// Applies the test.
///
/// # Errors
/// [`AnalysisError`].
pub fn zero_one(_samples: &[f64], _test: &ZeroOneTest) -> Result<ZeroOne, AnalysisError> {
    unimplemented!()
}
