//! The energy audit of a run: the balance of energy and work.

use schemars::JsonSchema;
use serde::Serialize;

use super::console;
use super::error::CliError;
use crate::pipeline::message::Summary;
use crate::scene::Scene;

/// Limit of the relative residual above which a warning is printed.
const LIMIT: f64 = 0.05;

/// Result of the energy audit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub(super) struct Audit {
    /// Residual of the energy balance over the largest energy or work.
    residual: f64,
    /// Limit of the residual above which a warning is printed.
    limit: f64,
    /// Whether the residual is at most the limit.
    holds: bool,
}

impl Audit {
    /// The audit of a run; `None` if there was none.
    pub fn of(summary: &Summary) -> Option<Self> {
        summary.energy_residual.map(|residual| Self {
            residual,
            limit: LIMIT,
            holds: residual <= LIMIT,
        })
    }
}

/// Checks that a run of the scene has an energy audit, if this is required.
///
/// # Errors
/// With `strict`: if it has none.
pub(super) fn check_scene(scene: &Scene, strict: bool) -> Result<(), CliError> {
    let is_audited = scene.joint().is_ok() && scene.record.energy_rate > 0.0;
    if strict && !is_audited {
        return Err(CliError::NotAudited);
    }
    Ok(())
}

/// Warns if the energy audit of a run failed.
///
/// # Errors
/// With `strict`: if the audit failed, or there was none.
pub(super) fn check(summary: &Summary, strict: bool) -> Result<(), CliError> {
    let audit = match Audit::of(summary) {
        Some(audit) if !audit.holds => audit,
        None if strict => return Err(CliError::NotAudited),
        _ => return Ok(()),
    };
    let reason = format!(
        "the energy audit failed: the relative residual {:.2} exceeds the limit {}, so the motion may be wrong; reduce \
         time.max_step_us or time.tolerance",
        audit.residual, audit.limit
    );
    if strict {
        return Err(CliError::Failed(format!("{reason} (--strict)")));
    }
    console::print_warning(&reason);
    Ok(())
}
