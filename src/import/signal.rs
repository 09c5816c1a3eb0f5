//! A signal, and the selection of a part of a file.

use crate::analysis::filter::{HALF_TAPS, upsampled};

/// Default of [`Selection::max_samples`]: 34 minutes at 48 kHz.
pub const MAX_SAMPLES: usize = 100_000_000;

/// A signal: uniform samples with a name and a unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// Name of the column or channel, or of the file.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// Sample rate, Hz.
    pub rate: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// The samples, finite.
    pub samples: Vec<f64>,
}

impl Signal {
    /// Time of a sample, s; its index may be fractional.
    pub fn time(&self, index: f64) -> f64 {
        self.start + index / self.rate
    }

    /// The signal with `factor` samples per sample, interpolated band-limited.
    pub fn interpolated(&self, factor: usize) -> Self {
        Self {
            name: self.name.clone(),
            unit: self.unit.clone(),
            rate: factor as f64 * self.rate,
            start: self.time((HALF_TAPS - 1) as f64),
            samples: upsampled(&self.samples, factor),
        }
    }

    /// Duration: number of samples divided by the rate, s.
    pub fn duration(&self) -> f64 {
        self.samples.len() as f64 / self.rate
    }
}

/// Selection of a part of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Column or channel, by name or by index from 0; optional for a single column.
    pub column: Option<String>,
    /// Sample rate, Hz, for a file without a clock, or instead of that in its header.
    pub rate: Option<f64>,
    /// Number of lines to skip at the start of a text.
    pub skip_lines: u64,
    /// Start time, s of the file's time.
    pub from: Option<f64>,
    /// End time, s of the file's time; a sample at this time is excluded.
    pub to: Option<f64>,
    /// Maximum number of samples; the default is [`MAX_SAMPLES`].
    pub max_samples: Option<usize>,
}
