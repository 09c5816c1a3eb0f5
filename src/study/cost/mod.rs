//! Cost of accuracy: work-precision sets, and the advice derived from them.
//!
//! Each setting is varied with all others at their reference values. The error is plotted against the work:
//! CPU time (median of repeated runs, summed over all threads, so that parallel work does not look cheap)
//! and right-hand-side evaluations, which have no noise. Each set has the error of its own reference. A
//! failed run is kept as a point.
//!
//! Trajectories can be compared only up to a horizon set by the largest Lyapunov exponent
//! ([`CostStudy::horizon`]). Beyond it, invariants are compared, which do not depend on the trajectory.

mod advice;
mod averages;
mod baseline;
mod body;
mod budget;
mod modes;
mod samples;
mod set;
mod trajectory;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use super::OnProgress;
use super::response::{InitialState, ResponsePlan, response};
use crate::dynamics::Exponent;
use crate::scene::{FixedAt, Scene};
pub use advice::{Advice, TARGETS, advice};
use averages::{exponent_sets, invariant_sets, recurrence_sets};
use baseline::Baseline;
pub(super) use baseline::timed;
pub use baseline::{CostError, CostPlan};
use body::element_sets;
pub use budget::{
    BudgetChoice, ErrorBudget, ErrorSource, LevelCost, Quantity, QuantityValue, Source,
    SourceLevel, SourceShare, UnreachedTarget,
};
use budget::{budget_sets, error_budget};
use modes::mode_sets;
pub(super) use samples::{DIMENSION, SAMPLES_PER_LAG, displacement, recurrence_rule, samples_for};
pub use set::{CostSetting, WorkPrecisionPoint, WorkPrecisionSet};
use trajectory::{event_sets, integrator_sets, node_sets};

/// Result of a cost study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CostStudy {
    /// Name of the scene.
    pub scene: String,
    /// Values at which the scheduled parameters of the scene are fixed.
    pub fixed_at: FixedAt,
    /// Horizon over which trajectories are compared, s.
    #[serde(rename = "horizon_s")]
    pub horizon: f64,
    /// Largest Lyapunov exponent, 1/s, from which the horizon follows.
    #[serde(rename = "exponent_per_s")]
    pub exponent: Option<Exponent>,
    /// Work-precision sets, setting by setting.
    pub sets: Vec<WorkPrecisionSet>,
    /// Advice: the cheapest integrator setting for each target error.
    pub advice: Vec<Advice>,
    /// Error budget of all settings together; `None` if it was not requested.
    pub budget: Option<ErrorBudget>,
    /// Whether the study was stopped early; settings that were not completed are missing.
    pub stopped: bool,
}

/// Runs a cost study on the calling thread, so that times are comparable. If `watch` returns `false`, the
/// result contains the completed settings, or is `None` if there are none.
///
/// # Errors
/// If there is no settled motion or no reference to compare with.
pub fn cost(
    plan: &CostPlan,
    watch: OnProgress<'_, (CostSetting, f64)>,
) -> Result<Option<CostStudy>, CostError> {
    let first = plan
        .settings
        .first()
        .copied()
        .unwrap_or(CostSetting::Integrator);
    let mut ball = None;
    let look = ResponsePlan {
        exponents: 1,
        orbits: false,
        portrait: false,
        max_transient: 0.4,
        measurement_time: 0.1,
        ..ResponsePlan::default()
    };
    let should_continue = &mut |_| watch((first, 0.0));
    let Some(settled) = response(
        &plan.scene,
        InitialState::Fresh,
        &look,
        &mut ball,
        should_continue,
    )?
    else {
        return Ok(None);
    };
    if settled.state.iter().all(|x| *x == 0.0) {
        return Err(CostError::AtRest);
    }
    let exponent = settled
        .exponents
        .and_then(|spectrum| spectrum.exponents.first().copied());
    let mut baseline = Baseline {
        plan,
        state: settled.state,
        transient: settled.transient,
        horizon: horizon(plan.horizon, exponent),
        ball,
    };
    let (mut sets, mut budget, mut stopped) = (Vec::new(), None, false);
    for (done, &setting) in plan.settings.iter().enumerate() {
        let share = |part: f64| (done as f64 + part) / plan.settings.len() as f64;
        let should_continue = &mut |part: f64| watch((setting, share(part)));
        let new_sets = match setting {
            CostSetting::Integrator => integrator_sets(&mut baseline, should_continue)?,
            CostSetting::Invariants => invariant_sets(&mut baseline, should_continue)?,
            CostSetting::Events => event_sets(&mut baseline, should_continue)?,
            CostSetting::Nodes => node_sets(&mut baseline, should_continue)?,
            CostSetting::Modes => mode_sets(&mut baseline, should_continue)?,
            CostSetting::Elements => element_sets(&mut baseline, should_continue)?,
            CostSetting::Exponents => exponent_sets(&mut baseline, should_continue)?,
            CostSetting::Recurrence => recurrence_sets(&mut baseline, should_continue)?,
            CostSetting::Budget => {
                budget = error_budget(&mut baseline, should_continue)?;
                budget.as_ref().map(budget_sets)
            }
        };
        let Some(new_sets) = new_sets else {
            stopped = true;
            break;
        };
        sets.extend(new_sets);
    }
    if stopped && sets.is_empty() {
        return Ok(None);
    }
    Ok(Some(CostStudy {
        stopped,
        scene: plan.scene.name.clone(),
        fixed_at: fixed_at(&plan.scene),
        horizon: baseline.horizon,
        exponent,
        advice: advice(&sets),
        sets,
        budget,
    }))
}

/// Values at which the scheduled parameters are fixed: the initial ones.
fn fixed_at(scene: &Scene) -> FixedAt {
    let joint = scene.joint();
    joint.map_or_else(|_| FixedAt::default(), |joint| joint.fixed_at_start())
}

/// Within the inverse of a positive exponent, an error grows by at most a factor `e`.
fn horizon(longest: f64, exponent: Option<Exponent>) -> f64 {
    match exponent {
        Some(e) if e.value > 0.0 => longest.min(e.value.recip()),
        _ => longest,
    }
}
