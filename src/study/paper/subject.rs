//! Subjects of the claims.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::criterion::Criterion;

/// Subject of a claim.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema, strum::Display,
)]
#[serde(rename_all = "kebab-case")]
pub enum Subject {
    /// Natural frequencies, and the numbers of unstable modes of steady sliding.
    #[strum(serialize = "linear stability")]
    LinearStability,
    /// Frequencies of the spectral lines.
    #[strum(serialize = "spectral lines")]
    SpectralLines,
    /// Type of the motion: spectra, sections and exponents of periodic, quasi-periodic and chaotic motions.
    #[strum(serialize = "type of motion")]
    TypeOfMotion,
}

impl Subject {
    /// All pairs of subjects.
    pub const PAIRS: [[Self; 2]; 3] = [
        [Self::LinearStability, Self::SpectralLines],
        [Self::LinearStability, Self::TypeOfMotion],
        [Self::SpectralLines, Self::TypeOfMotion],
    ];
}

impl Criterion {
    /// What the claim is about.
    pub(super) fn subject(&self) -> Subject {
        match self {
            Self::NaturalFrequency { .. } | Self::UnstableModes { .. } => Subject::LinearStability,
            Self::StrongestLine { .. }
            | Self::Line { .. }
            | Self::IndependentLine { .. }
            | Self::Combination { .. }
            | Self::Harmonics { .. }
            | Self::SameLines { .. }
            | Self::LinearMismatch { .. }
            | Self::RecurrencePeriod { .. } => Subject::SpectralLines,
            _ => Subject::TypeOfMotion,
        }
    }
}
