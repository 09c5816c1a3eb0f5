//! Which tones is a signal made of?

mod lines;
mod names;
mod spectrum;
mod stft;
mod window;

pub use lines::{FREQUENCY_UNCERTAINTY, Naming, SpectralLine, name_lines};
pub use names::{Bases, Combination};
pub use spectrum::{Line, LineCriterion, Spectrum, SpectrumAnalyser};
pub use stft::{Column, Stft};
pub use window::Window;
