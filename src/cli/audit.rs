//! What a command does about the energy audit of a run.

use super::console;
use super::error::CliError;
use crate::pipeline::Audit;
use crate::pipeline::message::Summary;
use crate::scene::Scene;

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
