//! An effect in a scene, and what it costs.

use serde::{Serialize, Serializer};

use super::bench::Measured;

/// An effect in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// What it is called.
    pub name: &'static str,
    /// The table or key of a scene that calls for it.
    pub key: &'static str,
    /// Whether the scene does.
    pub on: bool,
    /// How, in words; empty where it is off.
    pub setting: String,
    /// CPU time that it takes, or would take, of a simulated second, s; or why that cannot be told.
    #[serde(flatten, serialize_with = "cost_or_reason")]
    pub cost: Result<Measured, Untold>,
    /// CPU time that it takes once, before the first sample, s; `None` where it takes none worth telling.
    #[serde(rename = "setup_s")]
    pub setup: Option<Measured>,
}

/// The cost, or why it cannot be told, as JSON has it.
fn cost_or_reason<S: Serializer>(
    cost: &Result<Measured, Untold>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Record {
        /// CPU time that it takes, or would take, of a simulated second, s; `null` where that cannot be told.
        cpu_s_per_s: Option<Measured>,
        /// Why no cost can be told; `null` where one is.
        untold: Option<String>,
    }
    let record = Record {
        cpu_s_per_s: cost.ok(),
        untold: cost.err().map(|why| why.to_string()),
    };
    record.serialize(serializer)
}

/// Why the cost of an effect cannot be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Untold {
    /// Nothing comes of it in a run this short.
    #[error("the run is shorter than its window")]
    ShorterThanWindow,
    /// What a recording takes once is far more than what so short a run takes.
    #[error("the run is too short to tell")]
    TooShort,
    /// The scene's file leaves no room for its table.
    #[error("its table cannot be added to this scene")]
    NoRoom,
    /// Others take their choices from it.
    #[error("others take their choices from it")]
    Needed,
}

/// The setting of an effect, where it is on.
pub(super) fn words(on: bool, setting: &str) -> String {
    match on {
        true => setting.to_owned(),
        false => String::new(),
    }
}
