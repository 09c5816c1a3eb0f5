//! Signals: slices of samples in, values out. Knows neither joint nor scene.
//!
//! Two questions are put to a signal here.
//!
//! *Which tones is it made of?* A [`SpectrumAnalyser`] gives the one-sided amplitude
//! [`Spectrum`] under a [`Window`]; its [`Line`]s are refined below a bin; [`name_lines`] reads
//! them as one fundamental with harmonics or as two base frequencies with their combinations,
//! and says how likely it is that chance did the same. [`Stft`] does it column by column.
//!
//! *When does it come back to where it was?* [`DelayVectors`] unfolds the signal, Eq. (25); a
//! [`RecurrencePlot`] shows which instants lie close to one another, Eq. (26). A periodic signal
//! gives unbroken diagonals a period apart; chaos tears them.
//!
//! [`SlidingWindow`] turns a stream of samples, in pieces of any size, into windows at exact
//! instants; all live analyses stand on it.
//!
//! Sample values must be finite; a signal that is zero throughout is legal everywhere and gives
//! zeros, never NaN.

mod chaos;
mod delay;
mod error;
mod neighbours;
mod norm;
mod poincare;
mod recurrence;
mod regime;
mod sliding;
mod tones;

pub use chaos::*;
pub use delay::*;
pub use error::AnalysisError;
pub use neighbours::{Neighbour, NeighbourTree};
pub use norm::Norm;
pub use poincare::{
    Clusters, Crossing, Direction, SectionFinder, SectionShape, clusters, delay_section,
    plane_section, return_map, section_shape,
};
pub use recurrence::*;
pub use regime::{Evidence, Regime, RegimeSearch, Verdict, classify};
pub use sliding::{History, SlidingWindow, View};
pub use tones::*;

#[cfg(test)]
pub(crate) mod test_signals {
    //! Signals known in closed form, for the tests of this room and of the stages.

    use std::f64::consts::TAU;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Sum of sines, each (frequency in Hz, amplitude, phase in rad).
    pub fn sines(sample_rate: f64, n: usize, tones: &[(f64, f64, f64)]) -> Vec<f64> {
        let at = |i: usize| {
            let t = i as f64 / sample_rate;
            tones
                .iter()
                .map(|(f, a, phase)| a * (TAU * f * t + phase).sin())
                .sum()
        };
        (0..n).map(at).collect()
    }

    /// Gaussian white noise of the given standard deviation (Box-Muller).
    pub fn noise(seed: u64, n: usize, deviation: f64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || {
            let (u, v): (f64, f64) = (rng.random(), rng.random());
            (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
        };
        (0..n).map(|_| deviation * normal()).collect()
    }
}
