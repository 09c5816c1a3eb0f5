//! An effect of a scene and its cost.

use serde::{Serialize, Serializer};

use super::bench::Measured;

/// An effect of a scene, such as lift-off or an analysis, and its cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// Name of the effect.
    pub name: &'static str,
    /// Table or key of the scene that controls the effect.
    pub key: &'static str,
    /// Whether the effect is on in the scene.
    pub on: bool,
    /// Setting as text; empty if inactive.
    pub setting: String,
    /// CPU time per simulated second that the effect adds or would add, s/s; or why it cannot be measured.
    #[serde(flatten, serialize_with = "cost_or_reason")]
    pub cost: Result<Measured, Unavailable>,
    /// Setup: CPU time before the first sample, s; `None` if it is not significant.
    #[serde(rename = "setup_s")]
    pub setup: Option<Measured>,
}

/// JSON form of the cost.
fn cost_or_reason<S: Serializer>(
    cost: &Result<Measured, Unavailable>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Record {
        /// CPU time per simulated second that the effect adds or would add, s/s; `null` if unavailable.
        cpu_s_per_s: Option<Measured>,
        /// Reason why the cost is unavailable; `null` if it is available.
        unavailable: Option<String>,
    }
    let record = Record {
        cpu_s_per_s: cost.ok(),
        unavailable: cost.err().map(|why| why.to_string()),
    };
    record.serialize(serializer)
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

/// Text of an effect's setting; empty if it is inactive.
pub(super) fn setting_text(on: bool, setting: &str) -> String {
    match on {
        true => setting.to_owned(),
        false => String::new(),
    }
}
