//! An effect of a scene and its cost.

use std::borrow::Cow;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::bench::Measured;

/// An effect of a scene, such as lift-off or an analysis, and its cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Name of the effect.
    pub name: Cow<'static, str>,
    /// Table or key of the scene that controls the effect.
    pub key: Cow<'static, str>,
    /// Whether the effect is on in the scene.
    pub on: bool,
    /// Setting as text; empty if inactive.
    pub setting: String,
    /// CPU time per simulated second that the effect adds or would add, s/s; or why it cannot be measured.
    #[serde(flatten, with = "CostOrReason")]
    pub cost: Result<Measured, Unavailable>,
    /// Setup: CPU time before the first sample, s; `None` if it is not significant.
    #[serde(rename = "setup_s")]
    pub setup: Option<Measured>,
}

/// JSON form of the cost.
#[derive(Serialize, Deserialize)]
struct CostOrReason {
    /// CPU time per simulated second that the effect adds or would add, s/s; `null` if unavailable.
    cpu_s_per_s: Option<Measured>,
    /// Reason why the cost is unavailable; `null` if it is available.
    unavailable: Option<String>,
}

impl CostOrReason {
    fn serialize<S: Serializer>(
        cost: &Result<Measured, Unavailable>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        let record = Self {
            cpu_s_per_s: cost.ok(),
            unavailable: cost.err().map(|reason| reason.to_string()),
        };
        Serialize::serialize(&record, to)
    }

    fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Result<Measured, Unavailable>, D::Error> {
        let record = <Self as Deserialize>::deserialize(from)?;
        let is_given = |reason: &Unavailable| Some(reason.to_string()) == record.unavailable;
        let reason = Unavailable::ALL.into_iter().find(is_given);
        Ok(match (record.cpu_s_per_s, reason) {
            (_, Some(reason)) => Err(reason),
            (Some(cost), None) => Ok(cost),
            (None, None) => return Err(D::Error::missing_field("cpu_s_per_s")),
        })
    }
}

/// Why the cost of an effect is unavailable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unavailable {
    /// The run is shorter than the analysis window, so there is no result.
    #[error("the run is shorter than its window")]
    ShorterThanWindow,
    /// The setup cost of the recording is much larger than the cost of so short a run.
    #[error("the run is too short for a reliable measurement")]
    TooShort,
    /// The table of the effect cannot be added to the scene's file.
    #[error("its table cannot be added to this scene")]
    CannotAdd,
    /// Other analyses depend on the effect.
    #[error("other analyses depend on it")]
    Needed,
}

impl Unavailable {
    /// All reasons.
    const ALL: [Self; 4] = [
        Self::ShorterThanWindow,
        Self::TooShort,
        Self::CannotAdd,
        Self::Needed,
    ];
}

/// Text of an effect's setting; empty if it is inactive.
pub(super) fn setting_text(on: bool, setting: &str) -> String {
    match on {
        true => setting.to_owned(),
        false => String::new(),
    }
}
