//! Advice derived from work-precision sets: the cheapest integrator setting for an error.

use serde::{Deserialize, Serialize};

use super::{CostSetting, WorkPrecisionSet};

/// Target errors of the advice.
pub const TARGETS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-6];

/// Times whose ratio exceeds this are equal within their scatter.
const EQUAL_TIMES: f64 = 0.95;

/// Advice: the cheapest integrator setting for a target error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// Target error, relative.
    pub target: f64,
    /// Error of the setting, relative.
    pub error: f64,
    /// Name of the method, as in a scene.
    pub method: String,
    /// Tolerance of the method, or its step in s if the step is fixed.
    pub value: f64,
    /// CPU time over the horizon, s.
    #[serde(rename = "cpu_s")]
    pub seconds: f64,
    /// Right-hand-side evaluations over the horizon.
    pub rhs_evals: u64,
}

/// The cheapest integrator setting for each of [`TARGETS`] that is reached. Targets below the error of the
/// reference are not trusted.
pub fn advice(sets: &[WorkPrecisionSet]) -> Vec<Advice> {
    let of_integrator = || {
        sets.iter()
            .filter(|set| set.setting == CostSetting::Integrator)
    };
    let cheapest = |target: f64| {
        let families: Vec<_> = of_integrator()
            .filter_map(|set| {
                let floor = set.floor.unwrap_or(0.0);
                let points = set.points.iter().filter_map(|point| {
                    let error = *point.error.as_ref().ok()?;
                    (error <= target && floor <= target).then_some((set, point, error))
                });
                // Within a family, evaluations measure the cost without noise; among equals the first, the
                // loosest, wins.
                points.min_by_key(|(_, point, _)| point.rhs_evals)
            })
            .collect();
        // Between families, CPU time decides. If times agree within their scatter, or evaluations are equal,
        // the method listed first wins.
        let cheaper = |a: f64, b: f64| a < EQUAL_TIMES * b;
        let (_, winner, _) = families.iter().copied().reduce(|best, next| {
            match cheaper(next.1.seconds, best.1.seconds) {
                true => next,
                false => best,
            }
        })?;
        families
            .into_iter()
            .find(|(_, point, _)| point.rhs_evals == winner.rhs_evals)
    };
    let advised = TARGETS.into_iter().filter_map(|target| {
        let (set, point, error) = cheapest(target)?;
        Some(Advice {
            target,
            error,
            method: set.family.clone(),
            value: point.value,
            seconds: point.seconds,
            rhs_evals: point.rhs_evals,
        })
    });
    advised.collect()
}
