//! Tonal events of a recording: what sounds when.
//!
//! 1. *Peaks.* Spectrograms with Hann windows of 12 to 200 ms; the noise floor of each bin from order statistics.
//! 2. *Ridges.* In each spectrogram, the paths of peaks whose likelihood ratio against noise exceeds a threshold with
//!    a given number of false paths: short windows for a fast change of frequency, long ones for weak steady tones.
//! 3. *Partials.* Each ridge is brought to zero frequency. It sounds while its power, averaged over 45 ms, is above
//!    a tenth (-10 dB) of that of its loudest 0.1 s and above noise. Lines of mains hum are removed. Of several
//!    descriptions of one partial, that of the greatest energy and coherence stays, without the sidebands of its
//!    modulation.
//! 4. *Events.* Partials at multiples of one frequency form a tone. A logistic model tells tones from narrow-band noise and
//!    bursts, and all of them from noise, struck notes and speech. Sidebands of a fast modulation, which sound with their
//!    tone, are joined with it.
//!
//! A sung, bowed or blown note is a tonal event: nothing in the sound tells it from a squeak.

mod baseband;
mod demodulate;
#[cfg(test)]
mod fit_tests;
mod floor;
mod group;
mod hum;
mod kind;
#[cfg(test)]
mod kind_tests;
mod modulation;
mod partial;
mod paths;
mod result;
mod ridge;
mod search;
mod sidebands;
mod spectrogram;
mod stretch;
#[cfg(test)]
mod tests;

pub use demodulate::demodulate;
pub use result::{EventKind, Hum, Modulation, RidgePoint, Span, TonalEvent, TonalEvents, Vibrato};
pub use search::{EventOptions, tonal_events};
pub use stretch::stationary_stretch;
