//! The energy audit of a run: whether energy and work agree.

use serde::Serialize;

use super::error::CliError;
use super::report;
use crate::pipeline::message::Summary;
use crate::scene::Scene;

/// Relative residual of the energy audit beyond which a result may be wrong.
const LIMIT: f64 = 0.05;

/// Whether energy and work agree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Audit {
    /// Energy that is not accounted for, over the energy turned over.
    residual: f64,
    /// The largest residual of a result that can be trusted.
    limit: f64,
    /// Whether the residual is within the limit.
    holds: bool,
}

impl Audit {
    /// The audit of a run, if there was one.
    pub fn of(summary: &Summary) -> Option<Self> {
        summary.audit.map(|residual| Self {
            residual,
            limit: LIMIT,
            holds: residual <= LIMIT,
        })
    }

    /// What is wrong, if it does not hold, and what to do.
    fn fault(&self) -> Option<String> {
        (!self.holds).then(|| {
            format!(
                "energy and work do not agree (residual {:.2}, at most {} passes), so the motion may be wrong; \
                 choose a smaller time.max_step_us or time.tolerance",
                self.residual, self.limit
            )
        })
    }
}

/// Whether the energy of a scene is audited while it runs.
pub(super) fn is_audited(scene: &Scene) -> bool {
    scene.joint().is_ok() && scene.record.energy_rate > 0.0
}

/// Says on the standard error where the energy audit of a run does not hold.
///
/// # Errors
/// Where `strict`: if it does not hold, or there was none.
pub(super) fn judge(summary: &Summary, strict: bool) -> Result<(), CliError> {
    match (Audit::of(summary), strict) {
        (None, true) => Err(CliError::NotAudited),
        (None, false) => Ok(()),
        (Some(audit), _) => match (audit.fault(), strict) {
            (None, _) => Ok(()),
            (Some(reason), true) => Err(CliError::Audit { reason }),
            (Some(reason), false) => {
                report::print_warning(&reason);
                Ok(())
            }
        },
    }
}
