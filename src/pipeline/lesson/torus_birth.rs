//! A torus that is born while the tilt changes: the growth of its second tone, predicted by the Floquet multipliers of the
//! periodic motion.

use std::f64::consts::TAU;
use std::iter::zip;
use std::sync::Arc;

use super::Facts;
use super::prediction::JointOfRun;
use crate::dynamics::continuation::{
    Bifurcation, BifurcationKind, ContinuationOptions, Family, FamilyError, FamilyMember,
    Multiplier, OrbitBranch, PeriodicOrbit, ReturnSearch, continue_orbits, settled_orbit,
};
use crate::joint::BallJoint;
use crate::pipeline::error::PipelineError;
use crate::pipeline::message::{
    MechanismPrediction, PredictedCurves, SecondToneGrowth, TorusBirth,
};
use crate::pipeline::prepare::joint_integrator;

/// Time for which the motion settles at the first tilt of the run, s.
const SETTLE: f64 = 0.2;
/// Largest period of the settled motion, in lowest natural periods.
const MAX_PERIOD: f64 = 20.0;
/// Distance from its start below which the settled motion has returned, relative to its size.
const RETURN: f64 = 0.02;

/// A joint over the tilt, rad.
struct OverTilt<'a>(&'a BallJoint);

impl Family for OverTilt<'_> {
    fn member(&self, tilt: f64) -> Result<FamilyMember, FamilyError> {
        Ok(FamilyMember {
            system: Box::new(self.0.joint(tilt)?),
            drive_period: None,
            observable: vec![1.0],
        })
    }
}

/// Adds the torus, if a branch of periodic motions leads from the settled motion at the first tilt to a Neimark-Sacker
/// point within the tilts of the run.
pub fn predict(
    computed: &mut MechanismPrediction,
    (scene, tilted, ball): JointOfRun<'_>,
) -> Result<(), PipelineError> {
    let tilt = tilted.tilt.at(0.0);
    let joint = Arc::new(ball.joint(tilt)?);
    let (mut integrator, state) = joint_integrator(scene, &joint)?;
    integrator.start(0.0, &state)?;
    integrator.integrate_to(SETTLE)?;
    let search = ReturnSearch {
        settle_s: 0.0,
        max_period_s: MAX_PERIOD / computed.natural_hz,
        tolerance: RETURN,
    };
    let bounds = [tilted.tilt.min(), tilted.tilt.max()];
    let options = ContinuationOptions::new(bounds, scene.integrator.max_step);
    let family = OverTilt(ball);
    // A motion that is not periodic has no branch to predict from.
    let Ok(orbit) = settled_orbit(&family, tilt, integrator.state(), &search, &options) else {
        return Ok(());
    };
    let Ok(branch) = continue_orbits(&family, &orbit.into(), &options, &mut |_| Ok(())) else {
        return Ok(());
    };
    let points = branch
        .bifurcations
        .iter()
        .filter(|found| found.kind == BifurcationKind::NeimarkSacker && found.has_stable_side());
    let away = |found: &&Bifurcation| (found.parameter - tilt).abs();
    let Some(point) = points.min_by(|a, b| away(a).total_cmp(&away(b))) else {
        return Ok(());
    };
    let course = course(&branch, point);
    computed.picture = Some(PredictedCurves {
        title: "Computed growth rate of the second tone over the tilt; dot: Neimark-Sacker point",
        axes: ["tilt, deg", "growth rate, 1/s"],
        names: &["by Floquet multipliers"],
        curves: vec![
            course
                .iter()
                .map(|at| [at.tilt.to_degrees(), at.growth_per_s])
                .collect(),
        ],
        marks: vec![[point.parameter.to_degrees(), 0.0]],
    });
    computed.torus = Some(TorusBirth {
        tilt: point.parameter,
        course,
    });
    Ok(())
}

/// The second tone along the part of a branch around a Neimark-Sacker point on which the tilt does not turn, in ascending
/// order of the tilt.
fn course(branch: &OrbitBranch, point: &Bifurcation) -> Vec<SecondToneGrowth> {
    let orbits = &branch.points;
    let passes = |pair: &[PeriodicOrbit]| {
        let ends = [0, 1].map(|k| pair[k].parameter - point.parameter);
        ends[0] * ends[1] <= 0.0 && pair[0].unstable_multipliers != pair[1].unstable_multipliers
    };
    let before = orbits.windows(2).position(passes).map_or(0, |at| at + 1);
    let (before, after) = orbits.split_at(before);
    let angle = TAU * point.rotation_number.unwrap_or(0.0);
    let critical = Multiplier {
        ln_magnitude: 0.0,
        angle,
    };
    let mut course = followed(before.iter().rev(), &point.orbit, critical);
    course.extend(tone(&point.orbit, critical).map(|(tone, _)| tone));
    course.extend(followed(after.iter(), &point.orbit, critical));
    course.sort_by(|a, b| a.tilt.total_cmp(&b.tilt));
    course
}

/// The second tone of the orbits that follow one with a critical multiplier, as long as the tilt does not turn.
fn followed<'a>(
    orbits: impl Iterator<Item = &'a PeriodicOrbit>,
    from: &PeriodicOrbit,
    critical: Multiplier,
) -> Vec<SecondToneGrowth> {
    let (mut last, mut multiplier) = (from.parameter, critical);
    let mut along = 0.0;
    let mut course = Vec::new();
    for orbit in orbits {
        let step = orbit.parameter - last;
        if step * along < 0.0 {
            break;
        }
        let Some((tone, next)) = tone(orbit, multiplier) else {
            break;
        };
        course.push(tone);
        (last, multiplier, along) = (orbit.parameter, next, step);
    }
    course
}

/// The second tone of an orbit by the complex multiplier closest to that of a neighbouring orbit, which is returned, too.
fn tone(orbit: &PeriodicOrbit, near: Multiplier) -> Option<(SecondToneGrowth, Multiplier)> {
    let off =
        |m: &Multiplier| (m.ln_magnitude - near.ln_magnitude).abs() + (m.angle - near.angle).abs();
    let pairs = orbit.multipliers.iter().filter(|m| !m.is_real());
    let multiplier = *pairs.min_by(|a, b| off(a).total_cmp(&off(b)))?;
    let tone = SecondToneGrowth {
        tilt: orbit.parameter,
        frequency_hz: orbit.frequency_hz(),
        second_hz: multiplier.rotation_number() / orbit.period_s,
        growth_per_s: multiplier.growth_per_s(orbit.period_s),
    };
    Some((tone, multiplier))
}

/// Decay and growth of the second tone.
pub fn facts(facts: &mut Facts<'_>) {
    let point = "tilt of the Neimark-Sacker point";
    let torus = facts.computed.torus.as_ref();
    if let Some((torus, birth)) = torus.and_then(|torus| Some((torus, torus.birth()?))) {
        facts.predicted(point, torus.tilt, "rad");
        facts.predicted("first tone there", birth.frequency_hz, "Hz");
        facts.predicted("distance of the second tone from it", birth.second_hz, "Hz");
        let ends = [torus.course.first(), torus.course.last()];
        for (end, at) in zip(["lower", "upper"], ends.into_iter().flatten()) {
            facts.predicted(&format!("{end} end of the branch"), at.tilt, "rad");
            let name = format!("growth rate at the {end} end");
            facts.predicted(&name, at.growth_per_s, "1/s");
        }
    } else {
        facts.predicted(point, "none on the branch of the first motion", "");
    }
    let second = facts.measured.second_tone;
    let ratio = second.map(|second| second.ratio);
    facts.found("relative amplitude of the second tone", ratio, "share");
    let decay = second.and_then(|second| second.decay);
    let growth = second.and_then(|second| second.growth);
    let names = ["decay of the second tone", "growth of the second tone"];
    for (name, found) in zip(names, [decay, growth]) {
        let rate = facts.estimate(name, found.map(|found| found.growth), "1/s");
        rate.against(found.map(|found| found.computed_per_s));
        let tilts = found.into_iter().flat_map(|found| found.tilts);
        for (end, tilt) in zip(["from tilt", "to tilt"], tilts) {
            facts.found(&format!("{name}, {end}"), Some(tilt), "rad");
        }
    }
    facts.strongest_line();
    facts.motion(None);
}
