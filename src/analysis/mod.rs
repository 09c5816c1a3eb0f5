//! Signals: slices of samples in, values out. Knows neither joint nor scene.
//!
//! Five questions are put to a signal here.
//!
//! *Which tones is it made of?* A [`SpectrumAnalyser`] gives the one-sided amplitude
//! [`Spectrum`] under a [`Window`]; its [`Line`]s are refined below a bin; [`name_lines`] reads
//! them as one fundamental with harmonics or as two base frequencies with their combinations,
//! and says how likely it is that chance did the same. [`Stft`] does it column by column.
//!
//! *In which space does it move?* [`DelayVectors`] unfold it, Eq. (25); [`choose_delay`] takes
//! the lag from the [`mutual_information`] and the dimension from the [`false_neighbours`].
//!
//! *When does it come back to where it was?* A [`RecurrencePlot`] shows which instants lie close
//! to one another, Eq. (26): a periodic signal gives unbroken diagonals a period apart; chaos
//! tears them. [`quantify`] counts its points and lines without ever storing it, a
//! [`RecurrenceWindow`] as samples come and go; [`Measures`] follow from the counts.
//!
//! *How does it pass through a surface?* [`delay_section`] and [`plane_section`] give Poincare
//! sections, [`section_shape`] tells points from loops and clouds.
//!
//! *Is it chaos?* [`divergence()`] follows neighbours that part, [`zero_one()`] applies the 0-1
//! test, and [`classify`] weighs all evidence into a [`Verdict`].
//!
//! [`SlidingWindow`] turns a stream of samples, in pieces of any size, into windows at exact
//! instants; all live analyses stand on it.
//!
//! Sample values must be finite, and of a size that can be squared: the largest magnitude at
//! most [`LARGEST_SAMPLE`], the range (largest less smallest) at least [`SMALLEST_RANGE`] unless
//! it is 0. Distances and powers are sums of squares; beyond that they overflow or vanish, and
//! states seem infinitely far apart, or the same. A signal that is the same throughout is legal
//! everywhere and gives a defined result or an error, never NaN.

mod chaos;
mod delay;
mod error;
mod line_fit;
mod moments;
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
pub use line_fit::{Fit, LineFit};
pub use moments::{deviation, range};
pub use neighbours::{Neighbour, NeighbourTree};
pub use norm::Norm;
pub use poincare::{
    Clusters, Crossing, Direction, SectionFinder, SectionPoint, SectionShape, clusters,
    delay_section, plane_section, return_map, section_shape,
};
pub use recurrence::*;
pub use regime::{Evidence, Regime, RegimeSearch, Verdict, classify};
pub use sliding::{History, SlidingWindow, View};
pub use tones::*;

/// The smallest range (largest less smallest sample) of a signal that moves, in any unit.
pub const SMALLEST_RANGE: f64 = 1e-140;

/// The largest magnitude of a sample, in any unit.
pub const LARGEST_SAMPLE: f64 = 1e140;

#[cfg(test)]
pub(crate) mod test_signals;
