//! Regimes and the evidence for them.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Type of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Regime {
    /// Amplitude below the silence threshold.
    Silent,
    /// Growing, decaying or drifting.
    Transient,
    /// Periodic motion.
    Periodic,
    /// Two (or more) frequencies without phase locking: motion on a torus.
    QuasiPeriodic,
    /// Deterministic and aperiodic; nearby trajectories diverge.
    Chaotic,
    /// No determinism is detected.
    Noise,
    /// The evidence is insufficient.
    #[serde(rename = "undetermined")]
    Undetermined,
}

impl Regime {
    /// All regimes.
    pub const ALL: [Self; 7] = [
        Self::Silent,
        Self::Transient,
        Self::Periodic,
        Self::QuasiPeriodic,
        Self::Chaotic,
        Self::Noise,
        Self::Undetermined,
    ];
}

impl fmt::Display for Regime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Silent => "silent",
            Self::Transient => "transient",
            Self::Periodic => "periodic",
            Self::QuasiPeriodic => "quasi-periodic",
            Self::Chaotic => "chaotic",
            Self::Noise => "noise",
            Self::Undetermined => "undetermined",
        })
    }
}

/// One piece of evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Measured quantity, such as `0-1 test`.
    pub criterion: String,
    /// Measured value.
    pub value: f64,
    /// The regimes that it supports, without a choice between them.
    pub supports: Vec<Regime>,
    /// Weight, 0 to 1.
    pub weight: f64,
    /// A sentence with the value.
    pub description: String,
}

impl Evidence {
    /// Creates a piece of evidence.
    pub fn new(
        criterion: &str,
        value: f64,
        supports: &[Regime],
        weight: f64,
        description: impl Into<String>,
    ) -> Self {
        Self {
            criterion: criterion.to_owned(),
            value,
            supports: supports.to_vec(),
            weight,
            description: description.into(),
        }
    }

    /// Supported regimes as text: `periodic or quasi-periodic`.
    pub fn supported_regimes(&self) -> String {
        let supported_regimes: Vec<String> = self.supports.iter().map(Regime::to_string).collect();
        supported_regimes.join(" or ")
    }
}
