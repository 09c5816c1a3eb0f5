//! Regimes and the evidence for them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{Display, VariantArray};

/// Type of motion.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
    Display,
    VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
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
    #[default]
    Undetermined,
}

impl Regime {
    /// The regime with its confidence (0 to 1), such as `chaotic, confidence 94 %`; an undetermined one without.
    pub fn with_confidence(self, confidence: f64) -> String {
        match self {
            Self::Undetermined => self.to_string(),
            decided => format!("{decided}, confidence {:.0} %", 100.0 * confidence),
        }
    }
}

/// One piece of evidence: what a feature contributes to the decision between the two likeliest regimes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Evidence {
    /// Feature, such as `0-1 test`.
    pub criterion: String,
    /// The regime that it supports: one of the two likeliest.
    pub supports: Regime,
    /// Contribution to the natural logarithm of the odds of this regime against the other one, at least 0.
    pub contribution: f64,
    /// A sentence with the values.
    pub description: String,
}

impl Evidence {
    /// The factor by which the odds change, above 1 and at most 1000.
    pub fn factor(&self) -> f64 {
        self.contribution.exp().min(1000.0)
    }

    /// Whether it changes the odds by a fifth or more.
    pub fn matters(&self) -> bool {
        self.factor() >= 1.2
    }
}

/// What the signal leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, Display)]
#[serde(rename_all = "kebab-case")]
pub enum Limitation {
    /// The record contains too few periods or samples.
    #[strum(to_string = "The record contains too few periods or samples.")]
    TooShort,
    /// No regime is likely enough.
    #[strum(to_string = "No type of motion is likely enough.")]
    NoEvidence,
    /// The lines are those of a modulated tone: the modulation may be imposed from outside, and is then not a
    /// second frequency of the motion itself.
    #[strum(
        to_string = "The lines are those of a modulated tone; this signal alone does not show whether \
                     the modulation is imposed from outside or is a second frequency of the motion itself."
    )]
    Modulation,
    /// The level of a tone changes slowly; its side lines are those of this modulation.
    #[strum(
        to_string = "The level changes slowly: side lines near to the tone are no second frequency."
    )]
    Modulated,
}
