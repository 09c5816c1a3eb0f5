//! Audio of a vibration: from samples at the rate of the simulation to audio at [`RATE`].
//!
//! [`Source`] selects quantity and point, and [`SurfaceProbe`] evaluates them. Playback slower than real time
//! lowers the pitch by the same factor. The resampling filter is a windowed sinc, which removes frequencies
//! above the Nyquist frequency of the output instead of aliasing them.

mod probe;
mod resample;
mod wav;

pub use probe::{NoSurface, Quantity, Source, SurfaceProbe};
pub use resample::Resampler;
pub use wav::WavSink;

/// Sample rate of the audio, Hz.
pub const RATE: u32 = 48_000;
