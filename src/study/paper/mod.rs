//! Comparison with the paper: the tilt sweep of its figures, and every claim of its text against the simulation results.

mod claims;
mod criterion;

#[cfg(test)]
mod tests;

use crate::analysis::delay::{DelayChoice, DelaySearch, choose_delay};
use crate::joint::{AssemblyError, BallJoint, BodySpec, Frequencies, JointSpec};
use crate::scene::{Parameter, Scene};
use crate::study::response::{ResponsePlan, SettledResponse};
use crate::study::sweep::{Axis, Start, SweepPlan, SweepPoint};
pub use claims::{
    CLAIMS, Claim, ClaimEntry, Comparison, Evidence, Finding, Score, ShortAverage, Verdict,
    add_short_averages, claims, compare,
};

/// Tilt at which the paper chooses delay and embedding dimension, degrees.
pub const EMBEDDING_TILT_DEG: f64 = 5.0;

/// Tilts of Fig. 4 to 7, degrees.
pub const FIGURE_TILTS_DEG: [f64; 4] = [2.0, 3.0, 3.5, 5.0];

/// First and last tilt of Fig. 9 and 10, degrees.
pub const RECURRENCE_TILTS_DEG: [f64; 2] = [2.4, 4.6];

/// The sweep of the figures: tilts from 1 to 8 degrees in steps of 0.2, and 3.5 degrees.
pub fn paper_plan(scene: Scene, start: Start) -> SweepPlan {
    // Computed from integers, so that each value equals its decimal.
    let tilts = (5..=40)
        .map(|k| f64::from(2 * k) / 10.0)
        .chain(FIGURE_TILTS_DEG);
    SweepPlan {
        subject: scene,
        axes: vec![Axis::new(Parameter::tilt(), tilts)],
        starts: vec![start],
        response: ResponsePlan {
            max_transient_s: 0.6,
            measurement_s: 0.7,
            orbits: false,
            ..ResponsePlan::default()
        },
    }
}

/// Longest transient that a short average discards, s.
const SHORT_TRANSIENT: f64 = 0.05;

/// Length of a short average, s.
const SHORT_AVERAGE: f64 = 0.1;

/// The sweep of a plan with averages over 0.1 s that begin 0.05 s after the start, settled or not. The paper states
/// neither the length of its simulations nor that of its averages; its figures show at most some hundredths of a
/// second.
pub fn short_average_plan(plan: &SweepPlan) -> SweepPlan {
    let long = &plan.response;
    let transient = long.min_transient_s.min(SHORT_TRANSIENT);
    SweepPlan {
        response: ResponsePlan {
            min_transient_s: transient,
            max_transient_s: transient,
            measurement_s: long.measurement_s.min(SHORT_AVERAGE),
            ..*long
        },
        ..plan.clone()
    }
}

/// Collects the evidence: the responses over the tilt, and the natural frequencies of the scene's
/// finite-element model.
///
/// # Errors
/// If the body's modes cannot be computed.
pub fn paper_evidence(spec: &JointSpec, points: &[SweepPoint]) -> Result<Evidence, AssemblyError> {
    let responses = points.iter();
    let responses =
        responses.filter_map(|point| Some((point.place.values[0], point.found()?.clone())));
    let mut evidence = Evidence::new(responses);
    let mut own = spec.clone();
    if let BodySpec::BallOnBeam(body) = &mut own.body {
        body.frequencies = Frequencies::FiniteElement;
    }
    let ball = BallJoint::new(&own)?;
    let modes = ball.family_labels().into_iter();
    evidence.natural_frequencies = modes.zip(ball.frequencies_hz().iter().copied()).collect();
    evidence.embedding = evidence.at(EMBEDDING_TILT_DEG).and_then(embedding);
    Ok(evidence)
}

/// Embedding delay and dimension of a response's motion, and its sampling interval, s. `None` if the response
/// has no portrait, or one that is too short for the delays.
pub fn embedding(response: &SettledResponse) -> Option<(DelayChoice, f64)> {
    let portrait = response.portrait.as_ref()?;
    let samples = portrait.u_m.iter().map(|u| f64::from(*u));
    let samples: Vec<f64> = samples.collect();
    let choice = choose_delay(&samples, &DelaySearch::for_samples(samples.len()));
    Some((choice.ok()?, portrait.dt_s))
}
