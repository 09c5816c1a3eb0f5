//! Regimes and the evidence for them.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Type of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
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

    /// The regime with its confidence (0 to 1), such as `chaotic, confidence 94 %`; an undetermined one without.
    pub fn with_confidence(self, confidence: f64) -> String {
        match self {
            Self::Undetermined => self.to_string(),
            decided => format!("{decided}, confidence {:.0} %", 100.0 * confidence),
        }
    }
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
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
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
    /// What the method cannot see, if it contradicts the verdict; else `null`.
    pub blind_spot: Option<BlindSpot>,
}

/// What a method cannot see or cannot tell apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BlindSpot {
    /// Chaos whose neighbours separate by a few per cent per oscillation looks regular.
    WeakChaos,
    /// A second frequency of little amplitude is missed.
    WeakSecondFrequency,
    /// Lines closer together than the record resolves look like a broadband floor.
    UnresolvedLines,
    /// A modulation slower than the record looks like a trend.
    SlowModulation,
    /// Among few states the nearest neighbour is not close; its distance looks like divergence or noise.
    SparseStates,
    /// A chaotic attractor thinner than the spacing of its crossings looks like points or a curve.
    ThinAttractor,
    /// A torus with few beats in the record looks irregular.
    SlowBeat,
}

impl fmt::Display for BlindSpot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::WeakChaos => {
                "misses weak chaos, whose neighbours separate by a few per cent per oscillation"
            }
            Self::WeakSecondFrequency => "misses a second frequency of small amplitude",
            Self::UnresolvedLines => {
                "takes lines closer together than the record resolves for a broadband floor"
            }
            Self::SlowModulation => "takes a modulation slower than the record for a trend",
            Self::SparseStates => {
                "takes distant neighbours, all there are in a short record, for divergence or noise"
            }
            Self::ThinAttractor => {
                "takes a chaotic attractor thinner than the spacing of the crossings for points or a curve"
            }
            Self::SlowBeat => "takes a torus with few beats in the record for irregular motion",
        })
    }
}

/// What the signal leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Limitation {
    /// The record contains too few periods.
    TooShort,
    /// The motion changes during the record.
    Nonstationary,
    /// The evidence contradicts itself.
    Contradictory,
    /// No method found enough evidence.
    NoEvidence,
    /// The lines are those of a modulated tone: the modulation may be imposed from outside, and is then not a
    /// second frequency of the motion itself.
    Modulation,
    /// The broadband power is that of the background of a recording, which hides chaos and looks like it.
    Background,
}

impl fmt::Display for Limitation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooShort => "the record contains too few periods",
            Self::Nonstationary => "the motion changes during the record",
            Self::Contradictory => "the evidence contradicts itself",
            Self::NoEvidence => "no method found enough evidence",
            Self::Modulation => {
                "the lines are those of a modulated tone; this signal alone does not show whether the \
                 modulation is imposed from outside or is a second frequency of the motion itself"
            }
            Self::Background => {
                "the power between the lines is that of the background of the recording, which hides chaos and \
                 looks like it"
            }
        })
    }
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
            blind_spot: None,
        }
    }

    /// The same with what the method cannot see.
    pub(super) fn blind_to(self, blind_spot: BlindSpot) -> Self {
        Self {
            blind_spot: Some(blind_spot),
            ..self
        }
    }

    /// Whether it supports only other regimes than `regime`.
    pub(super) fn contradicts(&self, regime: Regime) -> bool {
        regime != Regime::Undetermined
            && self.supports != [Regime::Undetermined]
            && !self.supports.contains(&regime)
    }

    /// The description; and, if it contradicts the verdict, what the method cannot see.
    pub fn explanation(&self) -> String {
        match self.blind_spot {
            Some(blind) => format!("{} (This method {blind}.)", self.description),
            None => self.description.clone(),
        }
    }

    /// Supported regimes as text: `periodic or quasi-periodic`.
    pub fn supported_regimes(&self) -> String {
        let supported_regimes: Vec<String> = self.supports.iter().map(Regime::to_string).collect();
        supported_regimes.join(" or ")
    }
}
