//! Recurrence quantification: measures from counts.

use super::RecurrenceCounts;

/// Which pairs the recurrence rate is a share of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RateBase {
    /// Those outside the Theiler window: the ones that are counted.
    #[default]
    Counted,
    /// All `N^2`.
    All,
}

/// Measures of recurrence quantification analysis. `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// RR, 0 to 1.
    pub recurrence_rate: f64,
    /// DET, 0 to 1.
    pub determinism: Option<f64>,
    /// L, samples.
    pub mean_diagonal: Option<f64>,
    /// Lmax, samples.
    pub longest_diagonal: usize,
    /// DIV = 1 / Lmax.
    pub divergence: Option<f64>,
    /// ENTR, nats.
    pub entropy: Option<f64>,
    /// TREND, per thousand samples.
    pub trend: Option<f64>,
    /// LAM, 0 to 1.
    pub laminarity: Option<f64>,
    /// TT, samples.
    pub trapping_time: Option<f64>,
    /// Vmax, samples.
    pub longest_vertical: usize,
    /// Mean recurrence time of the first type, samples.
    pub recurrence_time_1: Option<f64>,
    /// Mean recurrence time of the second type, samples.
    pub recurrence_time_2: Option<f64>,
}

impl RecurrenceCounts {
    /// The measures, from diagonal lines of at least `least_diagonal` and vertical ones of at
    /// least `least_vertical` points.
    pub fn measures(
        &self,
        _least_diagonal: usize,
        _least_vertical: usize,
        _base: RateBase,
    ) -> Measures {
        unimplemented!()
    }

    /// The most frequent spacing of diagonals, in samples: a period of the motion.
    pub fn period(&self) -> Option<f64> {
        unimplemented!()
    }
}
