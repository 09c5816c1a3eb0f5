//! Spectra, spectral lines and their identification.

mod identification;
mod lattice;
mod lines;
mod names;
mod spectrum;
mod stft;
mod window;

pub use identification::{LineIdentification, SpectralLine};
pub use lines::{FREQUENCY_UNCERTAINTY, follow_lines, identify_lines};
pub use names::{Bases, Combination};
pub use spectrum::{Line, LineCriterion, Spectrum, SpectrumAnalyser};
pub use stft::{Column, Stft};
pub use window::{Window, line_amplitude};
