//! Kinds of motion, and what speaks for them.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Kinds of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Regime {
    /// Hardly anything moves.
    Silent,
    /// It still changes: grows, fades or wanders.
    Transient,
    /// It repeats.
    Periodic,
    /// Two (or more) tones that never come into step.
    QuasiPeriodic,
    /// It never repeats, neighbours part, yet it obeys a law.
    Chaotic,
    /// No law is found in it.
    Noise,
    /// The evidence does not suffice.
    #[serde(rename = "not sure")]
    Unsure,
}

impl Regime {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Silent,
        Self::Transient,
        Self::Periodic,
        Self::QuasiPeriodic,
        Self::Chaotic,
        Self::Noise,
        Self::Unsure,
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
            Self::Unsure => "not sure",
        })
    }
}

/// One piece of evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// What was measured, such as `0-1 test`.
    pub what: String,
    /// The number.
    pub value: f64,
    /// The kinds it speaks for: one of them, without saying which.
    pub says: Vec<Regime>,
    /// How strongly, 0 to 1.
    pub weight: f64,
    /// A sentence with the number in it.
    pub words: String,
}

impl Evidence {
    /// A piece of evidence from its parts.
    pub fn new(
        what: &str,
        value: f64,
        says: &[Regime],
        weight: f64,
        words: impl Into<String>,
    ) -> Self {
        Self {
            what: what.to_owned(),
            value,
            says: says.to_vec(),
            weight,
            words: words.into(),
        }
    }

    /// The kinds it speaks for, in words: `periodic or quasi-periodic`.
    pub fn kinds(&self) -> String {
        let kinds: Vec<String> = self.says.iter().map(Regime::to_string).collect();
        kinds.join(" or ")
    }
}
