//! The exponents of a scene as a result: what they say, how far they can be trusted, and their report.

use schemars::JsonSchema;
use serde::Serialize;

use super::{Ending, FULL_SPECTRUM_TOLERANCE, Goal, LyapunovStudy};
use crate::number::{degrees, fixed, short, trimmed};
use crate::pipeline::message::{Classification, MotionSegment, listed};
use crate::report::{Block, Measured, Report, Table};
use crate::scene::FixedAt;
use crate::text::earlier_motion;

/// The exponents of a scene.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct LyapunovResult {
    /// The Lyapunov study: exponents, running estimates, solver statistics and conclusions.
    #[serde(flatten)]
    pub study: LyapunovStudy,
    /// Tilt of the load during the study, rad; `None` for a scene without a load.
    pub tilt_rad: Option<f64>,
    /// Final values at which the scheduled parameters are fixed during the study.
    pub fixed_at: FixedAt,
    /// Transient time: the length of the scene's run before the study, s.
    pub transient_s: f64,
    /// Relative error tolerance of a time step during the study; `None` for a fixed step.
    pub tolerance: Option<f64>,
    /// Angular frequency `omega_1` of the slowest mode, rad/s. Exponents divided by it can be compared with
    /// those in the dimensionless time `tau` of Eq. (23).
    pub omega_1_rad_per_s: f64,
}

impl LyapunovStudy {
    /// The study with its conclusions. It was averaged to this goal; `omega_1` is in rad/s.
    pub(super) fn concluded(self, goal: Goal, tolerance: Option<f64>, omega_1: f64) -> Self {
        let earlier = earlier_motion(&self.segments, self.chaotic_transient_s);
        Self {
            goal: match goal {
                Goal::Time(_) => "time",
                Goal::HalfWidth(_) => "half_width",
                Goal::Classification => "verdict",
            },
            goal_reached: self.ending == Ending::Reached,
            interrupted: self.ending == Ending::Stopped,
            classification: Classification::new(&self.spectrum, self.motion, omega_1, earlier),
            sum_per_s: self.sum(),
            unsettled: self.unsettled(),
            real_time_factor: (self.simulated_s > 0.0)
                .then(|| self.simulated_s / self.busy_seconds),
            warnings: warnings(&self, tolerance),
            ..self
        }
    }
}

/// Tolerated difference of the sum of all exponents and the mean trace, relative to the sum of the absolute
/// values. The trace is only averaged over samples.
const MAX_IMBALANCE: f64 = 0.01;
/// Largest contraction of the last tangent vector in a mean step, as a natural logarithm. At 1.3 the exponent
/// of the fastest contraction of a joint was a fifth too small, at 0.4 it was accurate to 1 %.
const MAX_CONTRACTION: f64 = 0.7;

/// Reasons to distrust the result, each with its remedy.
fn warnings(study: &LyapunovStudy, tolerance: Option<f64>) -> Vec<String> {
    let advice = match tolerance {
        Some(tolerance) => {
            let tighter = (0.01 * tolerance).clamp(1e-13, FULL_SPECTRUM_TOLERANCE);
            format!("set --tolerance {tighter:.0e}")
        }
        None => "reduce time.max_step_us".to_owned(),
    };
    let mut warnings = Vec::new();
    let contraction = study.contraction_per_step();
    match study.imbalance() {
        Some(off) if off > MAX_IMBALANCE => warnings.push(format!(
            "the sum of the exponents differs from the mean trace by {:.1} % of the sum of their absolute values: the \
             steps are too long for the fastest contraction; {advice}",
            100.0 * off
        )),
        None if contraction > MAX_CONTRACTION => warnings.push(format!(
            "the last exponent is not resolved: its tangent vector shrinks by a factor of e^{contraction:.1} per step on \
             average; {advice}"
        )),
        _ => {}
    }
    let unsettled: Vec<String> = study.unsettled().iter().map(usize::to_string).collect();
    if !unsettled.is_empty() {
        warnings.push(format!(
            "the tangent vectors are not aligned (out-of-order exponents: {}); raise --settle",
            unsettled.join(", ")
        ));
    }
    let stats = &study.stats;
    if stats.steps_without_event_location > 0 {
        warnings.push(format!(
            "{} of {} steps passed events without locating them, because the events were too frequent",
            stats.steps_without_event_location, stats.steps
        ));
    }
    if study.ending == Ending::MaxTimeReached {
        let reached =
            "the maximum averaging time was reached before the target; raise --average-time";
        warnings.push(reached.to_owned());
    }
    warnings
}

/// The name of a scene and its tilt (rad), for a title.
pub fn title(scene: &str, tilt: Option<f64>) -> String {
    match tilt {
        Some(tilt) => format!("{scene} at {} deg", degrees(tilt)),
        None => scene.to_owned(),
    }
}

impl Report for LyapunovResult {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let study = &self.study;
        // The title has the tilt.
        let held = FixedAt {
            tilt_rad: None,
            ..self.fixed_at
        };
        let held = held
            .description()
            .map_or(String::new(), |held| format!(", {held}"));
        let rest = format!("{held}: {}", study.classification.description);
        let mut blocks = vec![Block::heading(title(scene, self.tilt_rad), rest)];
        if !study.spectrum.exponents.is_empty() {
            blocks.push(study.classification.table(&study.spectrum.exponents));
        }
        if study.segments.len() > 1 {
            blocks.push(segments(&study.segments));
        }
        if let Some(dimension) = &study.spectrum.kaplan_yorke {
            let dimension = Measured::from(dimension);
            blocks.push(Block::text(format!("Kaplan-Yorke dimension {dimension}")));
        }
        if let Some(sum) = study.sum_per_s {
            let trace = study.mean_trace_per_s;
            let trace = trace.map_or(String::new(), |trace| {
                format!(", mean trace {} 1/s", trimmed(trace, 5))
            });
            blocks.push(Block::text(format!("sum {} 1/s{trace}", trimmed(sum, 5))));
        }
        blocks.extend(study.warnings.iter().cloned().map(Block::Warning));
        blocks.push(Block::text(format!(
            "averaged over {:.3} s, after {:.3} s of the scene and {:.3} s of tangent alignment",
            study.spectrum.time, self.transient_s, study.settle_s
        )));
        if !study.spectrum.exponents.is_empty() {
            blocks.push(Block::text(format!(
                "resolution: an exponent within ± {} 1/s cannot be distinguished from zero",
                short(study.spectrum.resolution)
            )));
        }
        let tolerance = self.tolerance;
        let tolerance = tolerance.map_or(String::new(), |tolerance| {
            format!(" (tolerance {tolerance:.0e})")
        });
        let factor = study.real_time_factor;
        let factor = factor.map_or(String::new(), |factor| {
            format!(" ({factor:.2} x real time)")
        });
        blocks.push(Block::text(format!(
            "{} steps{tolerance}, {} rejected, {} right-hand-side evaluations in {:.2} s{factor}",
            study.stats.steps, study.stats.rejections, study.stats.rhs_evals, study.busy_seconds,
        )));
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.study.interrupted
    }
}

/// Number of exponents of each motion in the table.
const SEGMENT_EXPONENTS: usize = 3;

/// The successive motions, one per row.
fn segments(segments: &[MotionSegment]) -> Block {
    Table::of(segments)
        .right("start, s", |segment| fixed(segment.start_s, 3))
        .right("end, s", |segment| fixed(segment.end_s, 3))
        .left("attractor", |segment| segment.attractor.to_string())
        .left("largest exponents, 1/s", |segment| {
            if segment.spectrum.time == 0.0 {
                return "too short to average".to_owned();
            }
            listed(&segment.spectrum.exponents, SEGMENT_EXPONENTS)
        })
        .into()
}

#[cfg(test)]
#[path = "report_tests.rs"]
mod tests;
