//! Signals from files that somebody else made.

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
