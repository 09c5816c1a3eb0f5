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

    /// The message if the audit fails.
    fn failure(&self) -> Option<String> {
        (!self.holds).then(|| {
            format!(
                "the energy audit failed: the relative residual {:.2} exceeds the limit {}, so the motion may \
                 be wrong; reduce time.max_step_us or time.tolerance",
                self.residual, self.limit
            )
        })
    }
}

/// Whether a run of the scene has an energy audit.
pub(super) fn is_audited(scene: &Scene) -> bool {
    scene.joint().is_ok() && scene.record.energy_rate > 0.0
}

/// Warns if the energy audit of a run failed.
///
/// # Errors
/// With `strict`: if the audit failed, or there was none.
pub(super) fn check(summary: &Summary, strict: bool) -> Result<(), CliError> {
    match (Audit::of(summary), strict) {
        (None, true) => Err(CliError::NotAudited),
        (None, false) => Ok(()),
        (Some(audit), _) => match (audit.failure(), strict) {
            (None, _) => Ok(()),
            (Some(reason), true) => Err(CliError::Failed(format!("{reason} (--strict)"))),
            (Some(reason), false) => {
                console::print_warning(&reason);
                Ok(())
            }
        },
    }
}
