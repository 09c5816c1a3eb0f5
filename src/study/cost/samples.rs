//! Samples for recurrence quantification.

use super::CostError;
use crate::analysis::{DelayVectors, Norm, RecurrenceCriterion, Threshold};
use crate::pipeline::Prepared;
use crate::scene::Scene;
use crate::study::OnProgress;
use crate::study::pool::PollTimer;
use crate::study::response::section_lag;

/// Embedding dimension, and samples per delay.
pub const DIMENSION: usize = 5;
pub const SAMPLES_PER_LAG: usize = 6;

/// Number of samples for `vectors` delay vectors.
pub fn samples_for(vectors: usize) -> usize {
    DelayVectors::samples_for(vectors, SAMPLES_PER_LAG, DIMENSION)
}

/// Recurrence rule with a fixed threshold distance.
pub fn recurrence_rule(distance: f64) -> RecurrenceCriterion {
    RecurrenceCriterion {
        norm: Norm::Euclidean,
        threshold: Threshold::Distance(distance),
        theiler: SAMPLES_PER_LAG,
    }
}

/// `count` samples of the probe's displacement at [`SAMPLES_PER_LAG`] per delay of the scene; `None` if
/// stopped.
pub fn displacement(
    scene: &Scene,
    prepared: Prepared,
    count: usize,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<f64>>, CostError> {
    let Prepared {
        system,
        probe,
        mut integrator,
        state: mut z,
    } = prepared;
    integrator.start(&*system, 0.0, &z)?;
    let step = section_lag(scene) / SAMPLES_PER_LAG as f64;
    let mut timer = PollTimer::default();
    let mut samples = Vec::with_capacity(count);
    for k in 1..=count {
        integrator.sample(&*system, step * k as f64, &mut z)?;
        samples.push(probe.iter().zip(&z).map(|(p, q)| p * q).sum::<f64>());
        if timer.is_due() && !should_continue(k as f64 / count as f64) {
            return Ok(None);
        }
    }
    Ok(Some(samples))
}
