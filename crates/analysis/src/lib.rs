//! Signal analysis: slices of samples in, result structs out. Independent of the joint and the scene.
//!
//! The module covers seven tasks.
//!
//! *Spectral lines.* [`SpectrumAnalyser`] computes the one-sided amplitude [`Spectrum`] under a
//! [`Window`]. Each [`Line`] is interpolated to a fraction of a bin. [`identify_lines`] explains the lines
//! as one fundamental with harmonics, or as two base frequencies with their combinations, and gives an
//! upper bound of the probability that random lines fit equally well. [`Stft`] computes the spectrum column by column.
//!
//! *State-space reconstruction.* [`DelayVectors`] embed the signal, Eq. (25). [`choose_delay`] takes the
//! lag from the [`mutual_information`] and the dimension from the [`false_neighbours`].
//!
//! *Recurrence.* [`Recurrences`] are the pairs of instants with close states, Eq. (26). A
//! periodic signal gives unbroken diagonals one period apart; chaos breaks them into short pieces.
//! [`RecurrenceCounts`] count points and lines without storing the plot; [`Measures`] follow. A [`RecurrenceImage`] shows them.
//!
//! *Poincaré sections.* [`delay_section`] computes the section of a signal, [`SectionFinder`] that of a stream. [`section_shape`]
//! distinguishes points, closed curves and clouds; [`closed_curves`] counts the curves of a doubled torus.
//!
//! *Chaos.* [`divergence()`] computes the divergence of nearest neighbours. [`zero_one()`] applies the
//! 0-1 test. [`classify`] combines all evidence into a [`Verdict`].
//!
//! *Changes of the motion.* [`change_points`] finds where the mean of a local quantity, such as a local
//! exponent, changes permanently.
//!
//! *Sound levels.* [`sound_levels`] computes the levels of a calibrated sound: A-weighted, and in third octaves.
//!
//! [`SlidingWindow`] turns a stream of samples, in blocks of any size, into windows that end at exact
//! instants. All live analyses use it.
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

mod change_point;
mod chaos;
mod condition;
mod delay;
mod error;
mod events;
mod filter;
mod levels;
mod line_fit;
mod logistic;
pub mod memory;
mod moments;
mod neighbours;
mod norm;
mod number;
mod poincare;
mod recurrence;
mod regime;
mod simd;
mod sliding;
mod tones;

pub use change_point::{BlockMeans, Channel, MAX_CHANNELS, change_points};
pub use chaos::*;
pub use condition::{RecordingCondition, recording_condition};
pub use delay::*;
pub use error::AnalysisError;
pub use events::*;
pub use filter::{Filtered, band_pass};
pub use levels::*;
pub use line_fit::{Fit, LineFit};
pub use moments::{deviation, mean, range};
pub use neighbours::{Neighbour, NeighbourTree};
pub use norm::Norm;
pub use number::significant;
pub use poincare::{
    ClosedCurves, Crossing, Direction, SectionFinder, SectionPoint, SectionShape, closed_curves,
    delay_section, return_map, section_shape,
};
pub use recurrence::*;
pub use regime::{Evidence, Limitation, Regime, RegimeSearch, Verdict, classify};
pub use sliding::{History, SlidingWindow, View};
pub use tones::*;

/// Smallest non-zero range (maximum minus minimum) of a signal that can be analysed, in any unit.
pub const MIN_RANGE: f64 = 1e-140;

/// Largest magnitude of a sample that can be analysed, in any unit.
pub const MAX_SAMPLE: f64 = 1e140;

// Tests of the program use the test signals, too, by the name of this crate.
#[cfg(test)]
extern crate self as squeakscope_analysis;
#[cfg(test)]
mod test_signals;
