//! Prediction for a joint that turns to and fro: where its modes grow in each pass.

use super::{POINTS, linear_modes, sliding_speed};
use crate::joint::BallJoint;
use crate::pipeline::error::PipelineError;
use crate::pipeline::message::{
    MechanismPrediction, PredictedCurves, TiltDirection, UnstablePass, fastest,
};
use crate::scene::LoadedJoint;

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

/// Adds the passes of a run of a duration (s). The sliding speed becomes the largest of the run.
pub fn passes(
    computed: &mut MechanismPrediction,
    tilted: &LoadedJoint,
    ball: &BallJoint,
    duration: f64,
) -> Result<(), PipelineError> {
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
    let mut found: Vec<UnstablePass> = Vec::new();
    let mut curves = vec![Vec::new(), Vec::new()];
    let mut marks = Vec::new();
    for pair in course.windows(2) {
        let [before, now] = [pair[0], pair[1]];
        let way = TiltDirection::of(before.tilt, now.tilt);
        let point = |now: Instant| [now.tilt.to_degrees(), now.growth];
        if found.last().is_none_or(|pass| pass.way != way) {
            found.push(UnstablePass {
                way,
                unstable: (before.growth > 0.0).then_some([before.tilt; 2]),
                largest_growth_per_s: before.growth,
            });
        }
        let is_first = found.len() <= 2;
        let Some(pass) = found.last_mut() else {
            continue;
        };
        let curve = &mut curves[usize::from(way == TiltDirection::Down)];
        if is_first {
            if curve.is_empty() {
                curve.push(point(before));
            }
            curve.push(point(now));
        }
        pass.largest_growth_per_s = pass.largest_growth_per_s.max(now.growth);
        let changes = (before.growth > 0.0) != (now.growth > 0.0);
        let limit = if changes {
            limit_of_stability(before, now, &mut at)?
        } else {
            now
        };
        if changes && is_first {
            marks.push([limit.tilt.to_degrees(), 0.0]);
        }
        if changes || now.growth > 0.0 {
            let [first, _] = pass.unstable.unwrap_or([limit.tilt; 2]);
            let last = if now.growth > 0.0 {
                now.tilt
            } else {
                limit.tilt
            };
            pass.unstable = Some([first, last]);
        }
    }
    computed.passes = Some(found);
    computed.picture = Some(PredictedCurves {
        title: "Computed growth rate of the fastest mode over the tilt; dots: zero",
        axes: ["tilt, deg", "growth rate, 1/s"],
        names: &["rising tilt", "falling tilt"],
        curves,
        marks,
    });
    Ok(())
}

/// The instant at which the growth rate passes zero, between two instants with opposite signs.
fn limit_of_stability(
    mut before: Instant,
    mut after: Instant,
    at: &mut impl FnMut(f64) -> Result<Instant, PipelineError>,
) -> Result<Instant, PipelineError> {
    for _ in 0..BISECTIONS {
        let middle = at(0.5 * (before.time + after.time))?;
        match (middle.growth > 0.0) == (before.growth > 0.0) {
            true => before = middle,
            false => after = middle,
        }
    }
    Ok(after)
}
