//! Friction laws: exchanged slope factors, bristles, contact age, measured curves.

use std::f64::consts::TAU;
use std::iter::zip;

use super::Facts;
use super::prediction::{JointOfRun, POINTS, friction_curves, linear_modes};
use crate::analysis::stats::range;
use crate::joint::{BallJoint, Friction, FrictionLaw, NamedMode, Stribeck};
use crate::pipeline::error::PipelineError;
use crate::pipeline::message::{
    FrictionMemory, FrictionReading, MechanismPrediction, PredictedCurves, TableReading, fastest,
    unstable,
};

/// Factor on the rate of a state that follows the speed at all frequencies of the body: within `1e-3` of the slope up
/// to thirty times the frequency up to which the state of the scene follows.
const FASTER: f64 = 1e3;

/// Adds the readings of Eq. (5): as in the scene, and with the two slope factors exchanged.
pub fn predict_exchanged(
    computed: &mut MechanismPrediction,
    (_, tilted, ball): JointOfRun<'_>,
) -> Result<(), PipelineError> {
    let Friction::Stribeck { law, radial } = &tilted.spec.friction else {
        return Ok(());
    };
    let radial = *radial;
    let other = Stribeck {
        creep: law.stribeck,
        stribeck: law.creep,
        ..*law
    };
    let friction = Friction::Stribeck { law: other, radial };
    let exchanged = modes_with(computed, ball, friction)?;
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
pub fn predict_memory(
    computed: &mut MechanismPrediction,
    (_, tilted, ball): JointOfRun<'_>,
) -> Result<(), PipelineError> {
    let speed = computed.sliding_speed;
    let Friction::Dynamic { law, radial } = &tilted.spec.friction else {
        return Ok(());
    };
    if speed == 0.0 {
        return Ok(());
    }
    let faster = Friction::Dynamic {
        law: law.with_faster_state(FASTER),
        radial: *radial,
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
pub fn predict_measured(
    computed: &mut MechanismPrediction,
    (_, tilted, _): JointOfRun<'_>,
) -> Result<(), PipelineError> {
    let Friction::Table { law, .. } = &tilted.spec.friction else {
        return Ok(());
    };
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
    Ok(())
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

/// Slope factors as in the scene and exchanged.
pub fn exchanged(facts: &mut Facts<'_>) {
    let readings = facts.computed.readings.iter().flatten();
    for (case, reading) in zip(["this run", "exchanged"], readings) {
        let name = |quantity| format!("{quantity}, {case}");
        let unstable = unstable(&reading.modes);
        facts.given(&name("slope factor d"), reading.creep, "s/m");
        facts.given(&name("slope factor f"), reading.stribeck, "s/m");
        facts.predicted(&name("µ at the sliding speed"), reading.mu, "");
        facts.predicted(&name("slope of µ"), reading.slope, "s/m");
        facts.predicted(&name("unstable modes"), unstable.len() as f64, "");
        if let Some(mode) = unstable.first() {
            facts.predicted(&name("largest growth rate"), mode.growth, "1/s");
        }
    }
    let first = facts.measured.first_level;
    facts.growth();
    facts.found("initial velocity level", first, "m/s");
    let level = first.map(|_| facts.measured.level);
    facts.found("current velocity level", level, "m/s");
    facts.strongest_line();
}

/// Bristles that bend before the contact slides.
pub fn bristles(facts: &mut Facts<'_>) {
    with_memory(facts, "corner frequency of the bristles");
}

/// Contact whose age follows the speed after a slip distance.
pub fn contact_age(facts: &mut Facts<'_>) {
    with_memory(facts, "corner frequency of the contact age");
    let memory = facts.computed.memory.as_ref();
    if let Some(critical) = memory.and_then(|memory| memory.damping_above_hz) {
        facts.predicted("critical frequency", critical, "Hz");
        let small = facts.measured.small_frequency;
        let small = small.filter(|_| facts.measured.grows() == Some(true));
        let above = small.map(|frequency| frequency.value > critical);
        let cases = ["above the critical one", "below the critical one"];
        facts.claim("frequency of the growth", cases, false, above);
    }
}

/// Friction with a state, whose corner frequency has a name, compared with friction of the speed alone.
fn with_memory(facts: &mut Facts<'_>, corner: &str) {
    let unstable_modes = facts.computed.unstable();
    facts.growth();
    facts.predicted("unstable modes", unstable_modes.len() as f64, "");
    if let Some(memory) = &facts.computed.memory {
        let alone = &memory.modes_of_speed_alone;
        let name = |quantity| format!("{quantity}, friction without memory");
        facts.growth_rate(&name("growth rate"), fastest(alone));
        facts.predicted(&name("unstable modes"), unstable(alone).len() as f64, "");
        facts.predicted("slope of µ in steady sliding", memory.steady_slope, "s/m");
        facts.predicted(corner, memory.follows_up_to_hz, "Hz");
        if let Some(slope) = memory.fastest_slope {
            facts.predicted("slope of µ for the fastest mode", slope, "s/m");
        }
    }
    if let Some(mode) = unstable_modes.first() {
        facts.predicted("fastest mode", &*mode.label, "");
        facts.predicted("frequency of the fastest mode", mode.frequency_hz, "Hz");
    }
    let frequency = facts.measured.small_frequency;
    facts.estimate("frequency, while small", frequency, "Hz");
    facts.strongest_line();
}

/// A measured friction curve: its slope between the points.
pub fn measured(facts: &mut Facts<'_>) {
    let (computed, measured) = (facts.computed, facts.measured);
    facts.growth();
    let unstable = computed.unstable().len();
    facts.predicted("unstable modes", unstable as f64, "");
    let reached = measured.peak_speed.filter(|_| measured.growth_ended);
    let reached = reached.map(|peak| computed.sliding_speed + peak);
    if let Some(table) = &computed.table {
        let [first, last] = table.speeds;
        facts.given("points of the curve", table.points as f64, "");
        facts.given("speed at the first point", first, "m/s");
        facts.given("speed at the last point", last, "m/s");
        facts.given("sliding speed", computed.sliding_speed, "m/s");
        facts.predicted("µ at the sliding speed", table.mu, "");
        facts.predicted("slope of µ", table.slope, "s/m");
        let secants = table.secants.into_iter().flatten();
        for (which, secant) in zip(["smallest", "largest"], secants) {
            facts.predicted(&format!("{which} slope between points"), secant, "s/m");
            let rate = computed.fastest().map(|rate| rate * secant / table.slope);
            if let Some(rate) = rate.filter(|rate| unstable > 0 && rate.is_finite()) {
                facts.predicted(&format!("growth rate with the {which} slope"), rate, "1/s");
            }
        }
        if table.secants.is_none() {
            facts.predicted("slopes between points", "none, outside the points", "");
        }
        let sides = ["below the last point", "above the last point"];
        let side = reached.map(|reached| sides[usize::from(reached > last)]);
        facts.found("slip speeds", side, "");
    }
    facts.strongest_line();
    let peak = measured.peak_speed;
    facts.found("largest velocity of the vibration", peak, "m/s");
    facts.found("largest slip speed", reached, "m/s");
}
