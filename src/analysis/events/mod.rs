//! Tonal events of a recording: what sounds when.
//!
//! 1. *Peaks.* Spectrograms with Hann windows of 12 to 186 ms; the noise floor of each bin from order statistics.
//! 2. *Ridges.* In each spectrogram, the paths of peaks whose likelihood ratio against noise exceeds a threshold with
//!    a given probability of a false path. Of several descriptions of one tone, the one that holds the most
//!    energy per column stays: short windows for a fast change of frequency, long ones for weak steady tones.
//! 3. *Partials.* Each ridge is brought to zero frequency. It sounds from the first to the last time at which its power,
//!    averaged over 45 ms, is a tenth (-10 dB) of its loudest 0.1 s.
//! 4. *Events.* Partials at multiples of one frequency form an event. Lines of mains hum, knocks, struck notes and
//!    speech are removed.
//!
//! A sung, bowed or blown note is a tonal event: nothing in the sound tells it from a squeak.

mod baseband;
mod decoys;
mod demodulate;
mod floor;
mod group;
mod hum;
mod modulation;
mod partial;
mod paths;
mod result;
mod ridge;
mod search;
mod spectrogram;
mod stretch;
#[cfg(test)]
mod tests;
mod wow;

pub use demodulate::demodulate;
pub use result::{Hum, Modulation, RidgePoint, Span, TonalEvent, TonalEvents, Vibrato, Wow};
pub use search::{EventOptions, tonal_events};
pub use stretch::stationary_stretch;
