//! The sweep behind the paper's figures, and what is told of it.

use super::{Embedding, Evidence};
use crate::analysis::{AnalysisError, DelayChoice, DelaySearch, choose_delay};
use crate::joint::{AssemblyError, BallJoint, BodySpec, Frequencies, JointSpec};
use crate::scene::{Parameter, Scene};
use crate::study::response::{Response, ResponsePlan};
use crate::study::sweep::{Axis, Start, SweepPlan, SweepPoint};

/// The tilt at which the paper chooses delay and dimension, degrees.
pub const EMBEDDED_AT: f64 = 5.0;

/// Tilts of Fig. 4 to 7, degrees.
pub const MOTIONS: [f64; 4] = [2.0, 3.0, 3.5, 5.0];

/// Tilts of Fig. 9 and 10, degrees: from the first to the last.
pub const SUCCESSION: [f64; 2] = [2.4, 4.6];

/// The sweep behind the figures: 1 to 8 degrees by 0.2, and 3.5.
pub fn paper_plan(scene: Scene, start: Start) -> SweepPlan {
    // Decimals as they are written.
    let tilts = (5..=40).map(|k| f64::from(2 * k) / 10.0).chain(MOTIONS);
    SweepPlan {
        scene,
        axes: vec![Axis::new(Parameter::tilt(), tilts)],
        starts: vec![start],
        response: ResponsePlan {
            most: 0.6,
            measure: 0.7,
            ..ResponsePlan::default()
        },
    }
}

/// Responses over the tilt as evidence, with the natural frequencies of the scene's own
/// finite-element model.
///
/// # Errors
/// When the body's modes cannot be found.
pub fn paper_evidence(spec: &JointSpec, points: &[SweepPoint]) -> Result<Evidence, AssemblyError> {
    let responses = points.iter().filter_map(|point| {
        let response = point.outcome.as_ref().ok()?;
        Some((point.place.values[0], response.clone()))
    });
    let mut evidence = Evidence::new(responses);
    let mut own = spec.clone();
    if let BodySpec::BallOnBeam(body) = &mut own.body {
        body.frequencies = Frequencies::FiniteElement;
    }
    let ball = BallJoint::new(&own)?;
    let modes = ball.family_labels().into_iter();
    evidence.natural_frequencies = modes.zip(ball.frequencies_hz().iter().copied()).collect();
    let choice = evidence
        .at(EMBEDDED_AT)
        .and_then(|response| embedding(response)?.ok());
    evidence.delay = choice.map(|(choice, dt)| Embedding {
        lag: choice.lag as f64 * dt,
        dimension: choice.dimension,
    });
    Ok(evidence)
}

/// Delay and dimension of a response's motion, and the spacing of its samples, s; `None` where no piece
/// of it was kept.
pub fn embedding(response: &Response) -> Option<Result<(DelayChoice, f64), AnalysisError>> {
    let portrait = response.portrait.as_ref()?;
    let samples: Vec<f64> = portrait
        .displacement
        .iter()
        .map(|u| f64::from(*u))
        .collect();
    let choice = choose_delay(&samples, &DelaySearch::for_samples(samples.len()));
    Some(choice.map(|choice| (choice, portrait.dt)))
}
