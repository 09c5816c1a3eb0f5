//! Signal analysis: slices of samples in, result structs out. Independent of the joint and the scene.
//!
//! | module | subject |
//! |---|---|
//! | [`tones`] | Spectral lines. A [`SpectrumAnalyser`](tones::SpectrumAnalyser) computes the one-sided amplitude spectrum under a window. Each line is interpolated to a fraction of a bin. [`identify_lines`](tones::identify_lines) explains the lines as one fundamental with harmonics, or as two base frequencies with their combinations, and gives an upper bound of the probability that random lines fit equally well. |
//! | [`delay`] | State-space reconstruction. [`DelayVectors`](delay::DelayVectors) embed the signal, Eq. (25). [`choose_delay`](delay::choose_delay) takes the lag from the mutual information and the dimension from the false neighbours. |
//! | [`recurrence`] | [`Recurrences`](recurrence::Recurrences) are the pairs of instants with close states, Eq. (26). A periodic signal gives unbroken diagonals one period apart; chaos breaks them into short pieces. They are counted without storing the plot. |
//! | [`poincare`] | Poincaré sections of a signal and of a stream. [`section_shape`](poincare::section_shape) distinguishes points, closed curves and clouds; [`closed_curves`](poincare::closed_curves) counts the curves of a doubled torus. |
//! | [`chaos`] | [`divergence()`](chaos::divergence()) of nearest neighbours, and the 0-1 test, [`zero_one()`](chaos::zero_one()). |
//! | [`regime`] | [`classify`](regime::classify) combines all evidence of the type of motion into a verdict. |
//! | [`events`] | [`tonal_events`](events::tonal_events) of a recording: what sounds when. |
//! | [`change_point`] | Where the mean of a local quantity, such as a local exponent, changes permanently. |
//! | [`transient`] | A [`TransientDetector`](transient::TransientDetector) finds the end of a transient from the energies of the modes. |
//! | [`levels`] | [`sound_levels`](levels::sound_levels) of a calibrated sound: A-weighted, and in third octaves. |
//! | [`condition`] | Clipping, dropouts and silence of a recording. |
//! | [`sliding`] | A [`SlidingWindow`](sliding::SlidingWindow) turns a stream of samples, in blocks of any size, into windows that end at exact instants. All live analyses use it. |
//! | [`filter`], [`stats`] | A band-pass without phase shift; moments, trends and lines through a stream. |
//!
//! Samples must be finite. Distances and powers are sums of squares, which overflow or underflow outside
//! these limits: the largest magnitude is at most [`MAX_SAMPLE`], and the range (maximum minus
//! minimum) is 0 or at least [`MIN_RANGE`]. A constant signal is valid input everywhere: it gives a
//! defined result or an error, never NaN.

#![cfg_attr(
    test,
    allow(
        clippy::too_many_lines,
        reason = "a test that reads from top to bottom is easier to follow than one split into helpers"
    )
)]

pub mod change_point;
pub mod chaos;
pub mod condition;
pub mod delay;
mod error;
pub mod events;
pub mod filter;
pub mod levels;
mod logistic;
#[doc(hidden)]
pub mod memory;
mod neighbours;
mod norm;
mod number;
pub mod poincare;
pub mod recurrence;
pub mod regime;
mod simd;
pub mod sliding;
pub mod stats;
pub mod tones;
pub mod transient;

pub use error::AnalysisError;
pub use number::significant;

/// Smallest non-zero range (maximum minus minimum) of a signal that can be analysed, in any unit.
pub const MIN_RANGE: f64 = 1e-140;

/// Largest magnitude of a sample that can be analysed, in any unit.
pub const MAX_SAMPLE: f64 = 1e140;

// Tests of the program use the test signals, too, by the name of this crate.
#[cfg(test)]
extern crate self as squeakscope_analysis;
#[allow(dead_code, reason = "the generator has more than the fits need")]
#[cfg(test)]
#[path = "../../../tests/it/squeaks/generator/mod.rs"]
mod generator;
#[cfg(test)]
mod test_signals;
