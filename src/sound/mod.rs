//! Motions to listen to: from samples at a simulation's rate to sound at [`RATE`].
//!
//! What is heard is stated by [`Source`], and picked up by a [`Pickup`]. Played slower than life, a motion
//! sounds lower by as much. The filter of the resampler is a windowed sinc: what a loudspeaker could not play
//! is taken away, not folded back.

mod pickup;
mod resample;
mod wav;

pub use pickup::{NoSurface, Pickup, Place, Quantity, Source};
pub use resample::Resampler;
pub use wav::WavSink;

/// Samples of sound a second, Hz.
pub const RATE: u32 = 48_000;
