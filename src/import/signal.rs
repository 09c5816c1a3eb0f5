//! A signal, and which part of a file it is.

/// The most samples that are read unless [`Selection::max_samples`] says otherwise: 34 minutes at 48 kHz.
pub const MAX_SAMPLES: usize = 100_000_000;

/// A signal: uniform samples with a name and a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Name of the column or channel, or of the file.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// Samples a second, Hz.
    pub rate: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// The samples, finite.
    pub samples: Vec<f64>,
}

impl Signal {
    /// Time of a sample, s.
    pub fn time(&self, index: usize) -> f64 {
        self.start + index as f64 / self.rate
    }

    /// How long it lasts: samples over rate, s.
    pub fn duration(&self) -> f64 {
        self.samples.len() as f64 / self.rate
    }
}

/// Which part of a file to read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Column or channel, by name or by place from 0; may be left out where there is only one.
    pub column: Option<String>,
    /// Samples a second, Hz, for a file without a clock.
    pub rate: Option<f64>,
    /// Samples before this time of the file (s) are left out.
    pub from: Option<f64>,
    /// Samples at this time of the file (s) and after it are left out.
    pub to: Option<f64>,
    /// The most samples that are read, [`MAX_SAMPLES`] if not given.
    pub max_samples: Option<usize>,
}
