//! A joint that turns to and fro: where its modes grow in each pass, and where it squeaks.

use super::Facts;
use super::prediction::{JointOfRun, POINTS, linear_modes, sliding_speed};
use crate::pipeline::error::PipelineError;
use crate::pipeline::message::{
    MechanismPrediction, PredictedCurves, SqueakPass, TiltDirection, UnstablePass, fastest,
};

/// Bisections of an interval that contains a limit of stability.
const BISECTIONS: usize = 8;

/// Tilt (rad), growth rate of the fastest mode (1/s) and sliding speed (m/s) at a time (s).
#[derive(Clone, Copy)]
struct Instant {
    time: f64,
    tilt: f64,
    growth: f64,
    speed: f64,
}

/// Adds the passes of the run. The sliding speed becomes the largest of the run.
pub fn predict(
    computed: &mut MechanismPrediction,
    (scene, tilted, ball): JointOfRun<'_>,
) -> Result<(), PipelineError> {
    let duration = scene.duration;
    let mut ball = ball.clone();
    let mut at = |time: f64| -> Result<Instant, PipelineError> {
        let now = tilted.loading(time);
        ball.set_loading(&now);
        let modes = linear_modes(&ball, &ball.joint(now.tilt)?)?;
        Ok(Instant {
            time,
            tilt: now.tilt,
            growth: fastest(&modes).unwrap_or(f64::MIN),
            speed: sliding_speed(&ball, now.tilt),
        })
    };
    let times = (0..=POINTS).map(|k| duration * k as f64 / POINTS as f64);
    let course: Vec<Instant> = times.map(&mut at).collect::<Result<_, _>>()?;
    computed.sliding_speed = course.iter().map(|now| now.speed).fold(0.0, f64::max);
    let steps: Vec<[Instant; 2]> = course.windows(2).map(|step| [step[0], step[1]]).collect();
    let way = |[before, now]: &[Instant; 2]| TiltDirection::of(before.tilt, now.tilt);
    let mut passes: Vec<UnstablePass> = Vec::new();
    let mut curves = vec![Vec::new(), Vec::new()];
    let mut marks = Vec::new();
    for steps in steps.chunk_by(|a, b| way(a) == way(b)) {
        let (way, start) = (way(&steps[0]), steps[0][0]);
        let mut unstable = Vec::from_iter((start.growth > 0.0).then_some(start.tilt));
        let mut limits = Vec::new();
        for &[before, now] in steps {
            if (before.growth > 0.0) != (now.growth > 0.0) {
                let limit = limit_of_stability(before, now, &mut at)?;
                unstable.push(limit);
                limits.push([limit.to_degrees(), 0.0]);
            }
            unstable.extend((now.growth > 0.0).then_some(now.tilt));
        }
        let pass = || std::iter::once(start).chain(steps.iter().map(|step| step[1]));
        if passes.len() < 2 {
            let points = pass().map(|now| [now.tilt.to_degrees(), now.growth]);
            curves[usize::from(way == TiltDirection::Down)] = points.collect();
            marks.append(&mut limits);
        }
        let ends = unstable.first().zip(unstable.last());
        passes.push(UnstablePass {
            way,
            unstable: ends.map(|(&first, &last)| [first, last]),
            largest_growth_per_s: pass().map(|now| now.growth).fold(f64::MIN, f64::max),
        });
    }
    computed.passes = Some(passes);
    computed.picture = Some(PredictedCurves {
        title: "Computed growth rate of the fastest mode over the tilt; dots: zero",
        axes: ["tilt, deg", "growth rate, 1/s"],
        names: &["rising tilt", "falling tilt"],
        curves,
        marks,
    });
    Ok(())
}

/// Tilt (rad) at which the growth rate passes zero, between two instants with opposite signs.
fn limit_of_stability(
    mut before: Instant,
    mut after: Instant,
    at: &mut impl FnMut(f64) -> Result<Instant, PipelineError>,
) -> Result<f64, PipelineError> {
    for _ in 0..BISECTIONS {
        let middle = at(0.5 * (before.time + after.time))?;
        if (middle.growth > 0.0) == (before.growth > 0.0) {
            before = middle;
        } else {
            after = middle;
        }
    }
    Ok(after.tilt)
}

/// The last two passes, and the strongest line over the tilt.
pub fn facts(facts: &mut Facts<'_>) {
    let predicted = facts.computed.passes.as_deref().unwrap_or_default();
    let found = &facts.measured.passes;
    let end = found.len().max(2);
    for k in end - 2..end {
        pass(facts, predicted.get(k), found.get(k));
    }
    facts.strongest_line();
    facts.jumps();
}

/// Growth and squeak of a pass.
fn pass(facts: &mut Facts<'_>, predicted: Option<&UnstablePass>, found: Option<&SqueakPass>) {
    let ways = [found.map(|pass| pass.way), predicted.map(|pass| pass.way)];
    let Some(way) = ways.into_iter().flatten().next() else {
        return;
    };
    let name = |quantity| match way {
        TiltDirection::Up => format!("{quantity}, rising tilt"),
        TiltDirection::Down => format!("{quantity}, falling tilt"),
    };
    // Commands can change the course of the tilt.
    let predicted = predicted.filter(|pass| pass.way == way);
    let growth = predicted.and_then(|pass| pass.unstable);
    let squeak = found.and_then(|pass| pass.squeak);
    if let Some(pass) = predicted {
        let squeaks = found.map(|_| squeak.is_some());
        let cases = ["squeak", "no squeak"];
        facts.claim(&name("joint"), cases, growth.is_some(), squeaks);
        let rate = pass.largest_growth_per_s;
        facts.predicted(&name("largest growth rate"), rate, "1/s");
    }
    let is_over = found.is_some_and(|pass| pass.has_ended);
    for (end, k) in [("start of squeak", 0), ("end of squeak", 1)] {
        let squeak = squeak.filter(|_| k == 0 || is_over);
        let fact = facts.found(&name(end), squeak.map(|tilts| tilts[k]), "rad");
        fact.predicted = growth.map(|tilts| tilts[k].into());
    }
}
