//! What accuracy costs: work-precision sets, and the advice that follows.
//!
//! Each knob of a scene is turned with all others at their reference, and the error is set against the
//! work: CPU time (medians of repeated runs; all threads together, so that what runs on many cores is not
//! told as cheap) and calls of the right-hand side, which are free of noise. The error of the reference
//! itself is the floor of a set. What fails is a point, too.
//!
//! Errors of a trajectory make sense only up to a horizon that the largest Lyapunov exponent allows
//! ([`CostStudy::horizon`]); beyond it, what does not depend on the trajectory is compared.

mod advice;
mod averages;
mod body;
mod ground;
mod modes;
mod samples;
mod set;
mod trajectory;

#[cfg(test)]
mod tests;

use serde::Serialize;

use super::Watch;
use super::response::{From, ResponsePlan, response};
use crate::dynamics::Exponent;
use crate::scene::{Held, Scene};
pub use advice::{Advice, TARGETS, advice};
use averages::{exponent_sets, invariant_sets, recurrence_sets};
use body::element_sets;
use ground::Ground;
pub(super) use ground::timed;
pub use ground::{CostError, CostPlan};
use modes::mode_sets;
pub(super) use samples::{DIMENSION, SAMPLES_A_LAG, displacement, recurrence_rule, samples_for};
pub use set::{CostPoint, CostSet, Knob};
use trajectory::{event_sets, integrator_sets, node_sets};

/// What it came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostStudy {
    /// Name of the scene.
    pub scene: String,
    /// Where it was held, of what varies in the scene.
    pub held: Held,
    /// Time over which trajectories are compared, s.
    #[serde(rename = "horizon_s")]
    pub horizon: f64,
    /// The largest Lyapunov exponent, 1/s, by which the horizon was chosen.
    #[serde(rename = "exponent_per_s")]
    pub exponent: Option<Exponent>,
    /// The sets, knob by knob.
    pub sets: Vec<CostSet>,
    /// The cheapest setting of the integrator for each error.
    pub advice: Vec<Advice>,
    /// Whether it was told to stop: then the knobs that were not done are missing.
    pub stopped: bool,
}

/// Turns all knobs of a plan, on the caller's thread alone, so that times can be compared. If `watch` says
/// no, what is done by then; `None` if that is nothing.
///
/// # Errors
/// If there is no settled motion or no reference to compare with.
pub fn cost(
    plan: &CostPlan,
    watch: Watch<'_, (Knob, f64)>,
) -> Result<Option<CostStudy>, CostError> {
    let first = plan.knobs.first().copied().unwrap_or(Knob::Integrator);
    let mut ball = None;
    let look = ResponsePlan {
        exponents: 1,
        portrait: false,
        most: 0.4,
        measure: 0.1,
        ..ResponsePlan::default()
    };
    let goes_on = &mut |_| watch((first, 0.0));
    let Some(settled) = response(&plan.scene, From::Cold, &look, &mut ball, goes_on)? else {
        return Ok(None);
    };
    if settled.state.iter().all(|x| *x == 0.0) {
        return Err(CostError::AtRest);
    }
    let exponent = settled
        .exponents
        .and_then(|spectrum| spectrum.exponents.first().copied());
    let mut ground = Ground {
        plan,
        state: settled.state,
        horizon: horizon(plan.horizon, exponent),
        ball,
    };
    let (mut sets, mut stopped) = (Vec::new(), false);
    for (done, &knob) in plan.knobs.iter().enumerate() {
        let share = |part: f64| (done as f64 + part) / plan.knobs.len() as f64;
        let goes_on = &mut |part: f64| watch((knob, share(part)));
        let turned = match knob {
            Knob::Integrator => integrator_sets(&mut ground, goes_on)?,
            Knob::Invariants => invariant_sets(&mut ground, goes_on)?,
            Knob::Events => event_sets(&mut ground, goes_on)?,
            Knob::Nodes => node_sets(&mut ground, goes_on)?,
            Knob::Modes => mode_sets(&mut ground, goes_on)?,
            Knob::Elements => element_sets(&mut ground, goes_on)?,
            Knob::Exponents => exponent_sets(&mut ground, goes_on)?,
            Knob::Recurrence => recurrence_sets(&mut ground, goes_on)?,
        };
        let Some(turned) = turned else {
            stopped = true;
            break;
        };
        sets.extend(turned);
    }
    if stopped && sets.is_empty() {
        return Ok(None);
    }
    Ok(Some(CostStudy {
        stopped,
        scene: plan.scene.name.clone(),
        held: held(&plan.scene),
        horizon: ground.horizon,
        exponent,
        advice: advice(&sets),
        sets,
    }))
}

/// Where a study of one state of the joint holds what varies.
fn held(scene: &Scene) -> Held {
    let joint = scene.joint();
    joint.map_or_else(|_| Held::default(), |joint| joint.held_at_first())
}

/// Within this many times the inverse of the exponent an error grows by no more than `e`.
fn horizon(longest: f64, exponent: Option<Exponent>) -> f64 {
    match exponent {
        Some(e) if e.value > 0.0 => longest.min(e.value.recip()),
        _ => longest,
    }
}
