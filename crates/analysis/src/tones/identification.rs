//! Names of a list of spectral lines.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Bases, Combination, Line};

/// A spectral line with its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpectralLine {
    /// Frequency, interpolated between bins, Hz.
    #[serde(rename = "frequency_hz")]
    pub frequency: f64,
    /// Amplitude in the signal's unit (one-sided: a sine of amplitude A gives A).
    pub amplitude: f64,
    /// Name such as `f1`, `3 f1`, `f2 - 3 f1`, `(f1 + f2)/2`; empty for an unidentified line.
    pub label: String,
}

impl SpectralLine {
    /// Whether it is at a half or a quarter of a combination: a line of a doubled motion.
    pub fn is_half(&self) -> bool {
        self.label.contains('/')
    }

    /// Whether it is an integer combination of both base frequencies.
    pub fn is_mixed(&self) -> bool {
        !self.is_half() && ["f1", "f2"].iter().all(|base| self.label.contains(base))
    }

    /// Whether it is a harmonic of the first base frequency.
    pub fn is_harmonic(&self) -> bool {
        self.label.ends_with(" f1") && !self.label.contains("f2")
    }
}

/// Identification of lines: base frequencies and names of a list of lines.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LineIdentification {
    /// Base frequencies.
    #[serde(flatten)]
    pub bases: Bases,
    /// Name of each line, in the given order; `None` for an unidentified line.
    pub names: Vec<Option<Combination>>,
    /// Upper bound of the probability that random lines would be explained as well by bases chosen among
    /// them. 1 if the bases explain only themselves.
    pub p_value: f64,
    /// Doubling order: 0; 1 if there are lines at halves of the combinations, such as `f1/2` of a motion
    /// whose period has doubled or `(f1 + f2)/2` of a doubled torus; 2 if there are quarters.
    pub doubling: u32,
}

impl LineIdentification {
    /// No pattern among `count` lines.
    pub(super) fn none(count: usize) -> Self {
        Self {
            bases: Bases::None,
            names: vec![None; count],
            p_value: 1.0,
            doubling: 0,
        }
    }

    /// Deviation of `line`, the `i`-th identified line, from its name: its frequency minus that of the
    /// combination, Hz. `None` for an unidentified line.
    pub fn misfit(&self, i: usize, line: Line) -> Option<f64> {
        self.names[i].map(|name| line.frequency - self.bases.frequency(name))
    }

    /// The identified lines with their names.
    pub fn label(&self, lines: &[Line]) -> Vec<SpectralLine> {
        let named = lines.iter().zip(&self.names);
        let labelled = named.map(|(line, name)| SpectralLine {
            frequency: line.frequency,
            amplitude: line.amplitude,
            label: name.map_or_else(String::new, |name| name.text(self.bases.symbols())),
        });
        labelled.collect()
    }
}
