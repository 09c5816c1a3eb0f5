//! Which tones is a signal made of?

mod lines;
mod spectrum;
mod stft;
mod window;

pub use lines::{Bases, Combination, Naming, name_lines};
pub use spectrum::{Line, LineCriterion, Spectrum, SpectrumAnalyser};
pub use stft::{Column, Stft};
pub use window::Window;
