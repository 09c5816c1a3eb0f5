//! What is known about the error of a run with `--accuracy`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use crate::number::error;
use crate::pipeline::message::Summary;
use crate::scene::Scene;

/// What is known about the error of a run with `--accuracy`.
#[derive(Serialize, JsonSchema)]
pub(super) struct KnownAccuracy {
    /// Requested relative error.
    requested: f64,
    /// Verified relative error of each quantity; `null` if it is not known.
    errors: Option<BTreeMap<String, f64>>,
    /// Reason why the errors are unknown; `null` if they are known.
    unknown: Option<String>,
}

impl KnownAccuracy {
    pub fn of(requested: f64, scene: &Scene, summary: &Summary) -> Self {
        let verified = match (summary.interrupted, summary.at_rest) {
            (true, _) => Err("the run was interrupted".to_owned()),
            (false, true) => Err("the motion is at rest".to_owned()),
            (false, false) => scene
                .verified_errors(requested)
                .map(|budget| budget.errors.clone()),
        };
        Self {
            requested,
            unknown: verified.as_ref().err().cloned(),
            errors: verified.ok(),
        }
    }

    pub fn text(&self) -> String {
        let reason = self.unknown.as_deref().unwrap_or_default();
        let Some(errors) = &self.errors else {
            return format!("  error not known: {reason}\n");
        };
        let parts = errors
            .iter()
            .map(|(name, bound)| format!("of {name} <= {}", error(*bound)));
        let parts: Vec<String> = parts.collect();
        format!(
            "  error of the settled motion {} (budget of `cost`)\n",
            parts.join(", ")
        )
    }
}
