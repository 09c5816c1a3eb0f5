//! From work and precision to a setting.

use serde::Serialize;

use super::{CostSet, Knob};

/// Errors for which a setting is advised.
pub const TARGETS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-6];

/// Times nearer to each other than this are the same.
const NOTABLY: f64 = 0.95;

/// The cheapest setting for an error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// The error allowed.
    pub target: f64,
    /// Its error.
    pub error: f64,
    /// The method, as a scene names it.
    pub method: String,
    /// Its tolerance, or its step in s where it is fixed.
    pub value: f64,
    /// CPU time over the horizon, s.
    #[serde(rename = "cpu_s")]
    pub seconds: f64,
    /// Calls of the right-hand side.
    pub calls: u64,
}

/// The cheapest setting of the integrator for each of [`TARGETS`] that one reaches. An error near the
/// floor of the reference is not trusted.
pub fn advice(sets: &[CostSet]) -> Vec<Advice> {
    let of_integrator = || sets.iter().filter(|set| set.knob == Knob::Integrator);
    let cheapest = |target: f64| {
        let families: Vec<_> = of_integrator()
            .filter_map(|set| {
                let floor = set.floor.unwrap_or(0.0);
                let points = set.points.iter().filter_map(|point| {
                    let error = *point.error.as_ref().ok()?;
                    (error <= target && floor <= target).then_some((set, point, error))
                });
                // Within a family calls tell the cost without noise; of as many the first, the looser,
                // counts.
                points.min_by_key(|(_, point, _)| point.calls)
            })
            .collect();
        // Between families times do. Of times that differ by less than they scatter the method named
        // first counts, and of the same calls, too.
        let cheaper = |a: f64, b: f64| a < NOTABLY * b;
        let (_, winner, _) = families.iter().copied().reduce(|best, next| {
            match cheaper(next.1.seconds, best.1.seconds) {
                true => next,
                false => best,
            }
        })?;
        families
            .into_iter()
            .find(|(_, point, _)| point.calls == winner.calls)
    };
    let advised = TARGETS.into_iter().filter_map(|target| {
        let (set, point, error) = cheapest(target)?;
        Some(Advice {
            target,
            error,
            method: set.family.clone(),
            value: point.value,
            seconds: point.seconds,
            calls: point.calls,
        })
    });
    advised.collect()
}
