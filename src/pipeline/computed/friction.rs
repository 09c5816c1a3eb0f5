//! Predictions for mechanisms that a friction law causes.

use std::f64::consts::TAU;

use super::{POINTS, friction_curves, linear_modes};
use crate::analysis::stats::range;
use crate::joint::{
    BallJoint, DynamicFriction, Friction, FrictionLaw, FrictionTable, NamedMode, Stribeck,
};
use crate::pipeline::error::PipelineError;
use crate::pipeline::message::{
    FrictionMemory, FrictionReading, MechanismPrediction, PredictedCurves, TableReading,
};

/// Factor on the rate of a state that follows the speed at all frequencies of the body: within `1e-3` of the slope up
/// to thirty times the frequency up to which the state of the scene follows.
const FASTER: f64 = 1e3;

/// Adds the readings of Eq. (5): as in the scene, and with the two slope factors exchanged.
pub fn exchanged(
    computed: &mut MechanismPrediction,
    ball: &BallJoint,
    (law, radial): (&Stribeck, bool),
) -> Result<(), PipelineError> {
    let other = Stribeck {
        creep: law.stribeck,
        stribeck: law.creep,
        ..*law
    };
    let exchanged = modes_with(computed, ball, Friction::Stribeck { law: other, radial })?;
    let sliding_speed = computed.sliding_speed;
    let reading = |law: Stribeck, modes| FrictionReading {
        creep: law.creep,
        stribeck: law.stribeck,
        mu: law.coefficient(sliding_speed),
        slope: law.slope(sliding_speed),
        modes,
    };
    let both = [(*law, computed.modes.clone()), (other, exchanged)];
    computed.readings = Some(both.map(|(law, modes)| reading(law, modes)));
    let laws: [&dyn Fn(f64) -> f64; 2] = [&|v| law.coefficient(v), &|v| other.coefficient(v)];
    let names = &["as in the scene", "exchanged"];
    computed.picture = Some(friction_curves(sliding_speed, &laws, names));
    Ok(())
}

/// Adds what an oscillation meets of a law with a state.
pub fn with_memory(
    computed: &mut MechanismPrediction,
    ball: &BallJoint,
    (law, radial): (&DynamicFriction, bool),
) -> Result<(), PipelineError> {
    let speed = computed.sliding_speed;
    if speed == 0.0 {
        return Ok(());
    }
    let faster = Friction::Dynamic {
        law: law.with_faster_state(FASTER),
        radial,
    };
    let seen = law.oscillating(speed);
    let by_growth = computed.modes.iter();
    let fastest = by_growth.max_by(|a, b| a.growth.total_cmp(&b.growth));
    computed.memory = Some(FrictionMemory {
        steady_slope: seen.slope(0.0),
        follows_up_to_hz: seen.relaxation / TAU,
        damping_above_hz: seen.damping_above().map(|omega| omega / TAU),
        fastest_slope: fastest.map(|mode| seen.slope(TAU * mode.frequency_hz)),
        modes_of_speed_alone: modes_with(computed, ball, faster)?,
    });
    let of_modes: Vec<f64> = computed.modes.iter().map(|m| m.frequency_hz).collect();
    let highest = 1.1 * of_modes.iter().copied().fold(0.0, f64::max);
    let point = |hz: f64| [hz, seen.slope(TAU * hz)];
    let along = (0..=POINTS).map(|k| highest * k as f64 / POINTS as f64);
    computed.picture = Some(PredictedCurves {
        title: "Computed slope of friction for an oscillation of the speed; dots: the modes",
        axes: ["frequency, Hz", "slope, s/m"],
        names: &["with the state", "in steady sliding"],
        curves: vec![
            along.clone().map(point).collect(),
            along.map(|hz| [hz, seen.slope(0.0)]).collect(),
        ],
        marks: of_modes.into_iter().map(point).collect(),
    });
    Ok(())
}

/// Adds the measured curve at the sliding speed.
pub fn measured(computed: &mut MechanismPrediction, law: &FrictionTable) {
    let speed = computed.sliding_speed;
    let points = law.points();
    let mu = |v: f64| v * law.ratio(v).value;
    let ratio = law.ratio(speed);
    let after = points.partition_point(|[v, _]| *v <= speed);
    let secant = |k: usize| {
        let [[v, mu], [next, mu_next]] = [points[k - 1], points[k]];
        (mu_next - mu) / (next - v)
    };
    let within = (1..points.len()).contains(&after);
    let near = after.saturating_sub(1).max(1)..=(after + 1).min(points.len() - 1);
    computed.table = Some(TableReading {
        points: points.len(),
        speeds: [points[0][0], points[points.len() - 1][0]],
        mu: mu(speed),
        slope: ratio.value + speed * ratio.slope,
        secants: within.then(|| range(near.map(secant))),
    });
    let mut picture = friction_curves(speed, &[&mu], &["curve through the points"]);
    picture.title = "Friction curve; dots: measured points and steady sliding";
    let shown = points.iter().filter(|[v, _]| *v <= 3.0 * speed);
    picture.marks.extend(shown.map(|[v, mu]| [1e3 * v, *mu]));
    computed.picture = Some(picture);
}

/// The modes of the joint with another friction law.
fn modes_with(
    computed: &MechanismPrediction,
    ball: &BallJoint,
    friction: Friction,
) -> Result<Vec<NamedMode>, PipelineError> {
    let mut spec = ball.spec().clone();
    spec.friction = friction;
    let other = BallJoint::new(&spec)?;
    linear_modes(ball, &other.joint(computed.tilt.unwrap_or(0.0))?)
}
