//! Spectra, spectral lines and their identification.

mod lattice;
mod lines;
mod names;
mod spectrum;
mod stft;
mod window;

pub use lines::{
    FREQUENCY_UNCERTAINTY, LineIdentification, SpectralLine, follow_lines, identify_lines,
};
pub use names::{Bases, Combination};
pub use spectrum::{Line, LineCriterion, Spectrum, SpectrumAnalyser};
pub use stft::{Column, Stft};
pub use window::Window;
