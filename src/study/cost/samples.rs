//! Samples whose recurrences are counted.

use super::CostError;
use crate::analysis::{DelayVectors, Norm, RecurrenceRule, Threshold};
use crate::pipeline::Prepared;
use crate::scene::Scene;
use crate::study::Watch;
use crate::study::pool::Heed;
use crate::study::response::section_lag;

/// Delay vectors that are compared for recurrence: their dimension, and samples a delay.
pub const DIMENSION: usize = 5;
pub const SAMPLES_A_LAG: usize = 6;

/// Samples that so many delay vectors take.
pub fn samples_for(vectors: usize) -> usize {
    DelayVectors::samples_for(vectors, SAMPLES_A_LAG, DIMENSION)
}

/// States within a distance of each other count as recurrent.
pub fn recurrence_rule(distance: f64) -> RecurrenceRule {
    RecurrenceRule {
        norm: Norm::Euclidean,
        threshold: Threshold::Distance(distance),
        theiler: SAMPLES_A_LAG,
    }
}

/// So many samples of the probe's displacement, as far apart as delay vectors of the scene want them. `None`
/// if it was told to stop.
pub fn displacement(
    scene: &Scene,
    prepared: Prepared,
    count: usize,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<f64>>, CostError> {
    let Prepared {
        system,
        probe,
        mut integrator,
        state: mut z,
    } = prepared;
    integrator.start(&*system, 0.0, &z)?;
    let step = section_lag(scene) / SAMPLES_A_LAG as f64;
    let mut heed = Heed::default();
    let mut samples = Vec::with_capacity(count);
    for k in 1..=count {
        integrator.sample(&*system, step * k as f64, &mut z)?;
        samples.push(probe.iter().zip(&z).map(|(p, q)| p * q).sum::<f64>());
        if heed.is_due() && !goes_on(k as f64 / count as f64) {
            return Ok(None);
        }
    }
    Ok(Some(samples))
}
