//! The report of `squeakscope lyapunov`: the attractor, a table of exponents, and warnings.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::Serialize;

use super::report::{BAD, HEADING, WARNING};
use crate::dynamics::{Attractor, Motion, Sign, Stability};
use crate::escape;
use crate::number::{degrees, uncertain, value_and_error};
use crate::pipeline::message::MotionSegment;
use crate::scene::FixedAt;
use crate::study::lyapunov::{
    Classification, Ending, FULL_SPECTRUM_TOLERANCE, Goal, LyapunovStudy, RunningExponents,
    SceneLyapunov,
};
use crate::table::Table;
use crate::text::earlier_motion;

/// The exponents of a scene and their classification.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct LyapunovResult<'a> {
    /// Criterion that ends the averaging: `time`, `half_width` or `verdict`.
    goal: &'static str,
    /// Whether the criterion was met.
    goal_reached: bool,
    /// Whether the study was interrupted.
    interrupted: bool,
    #[serde(flatten)]
    pub classification: Classification,
    /// Sum of all exponents, 1/s; `null` if not all are computed.
    pub sum_per_s: Option<f64>,
    /// Numbers, from 1, of exponents that are significantly below the next one: their tangent vectors are not
    /// aligned.
    pub unsettled: Vec<usize>,
    /// Simulated time over wall time; `null` if nothing was averaged.
    pub real_time_factor: Option<f64>,
    #[serde(flatten)]
    pub found: &'a SceneLyapunov,
}

impl<'a> LyapunovResult<'a> {
    pub fn new(goal: Goal, found: &'a SceneLyapunov) -> Self {
        let study = &found.study;
        Self {
            goal: match goal {
                Goal::Time(_) => "time",
                Goal::HalfWidth(_) => "half_width",
                Goal::Classification => "verdict",
            },
            goal_reached: study.ending == Ending::Reached,
            interrupted: study.ending == Ending::Stopped,
            classification: Classification {
                description: history(found) + &description(study),
                ..study.classification(found.omega_1)
            },
            sum_per_s: study.sum(),
            unsettled: study.unsettled().into_iter().map(|k| k + 1).collect(),
            real_time_factor: (study.simulated > 0.0).then(|| study.simulated / study.busy_seconds),
            found,
        }
    }
}

/// The scene and its tilt, for a heading.
pub(super) fn title(scene: &str, tilt: Option<f64>) -> String {
    match tilt {
        Some(tilt) => format!("{scene} at {} deg", degrees(tilt)),
        None => scene.to_owned(),
    }
}

/// What preceded the last motion, as the start of a sentence; empty for one motion.
fn history(found: &SceneLyapunov) -> String {
    let earlier = earlier_motion(&found.study.segments, found.chaotic_transient);
    earlier.map_or(String::new(), |earlier| format!("{earlier}, then "))
}

/// The attractor, and the reason for the classification.
pub(super) fn description(study: &LyapunovStudy) -> String {
    let attractor = study.attractor();
    let spectrum = &study.spectrum;
    if spectrum.exponents.is_empty() {
        return "undecided: the averaging has not started".to_owned();
    }
    let zeros = spectrum.count(Sign::Zero);
    let others = match spectrum.dimension > zeros {
        true => ", the others are negative",
        false => "",
    };
    let reason = match attractor {
        Attractor::Equilibrium(Stability::Stable) => {
            "the state is constant, and all exponents are negative".to_owned()
        }
        Attractor::Equilibrium(Stability::Unstable) => {
            "the state is constant, but small perturbations grow".to_owned()
        }
        Attractor::Equilibrium(Stability::Undecided) => {
            "the state is constant, and no exponent is significantly positive".to_owned()
        }
        Attractor::FixedPoint | Attractor::PhaseLocked => "all exponents are negative".to_owned(),
        Attractor::Cycle => format!("one exponent is zero{others}"),
        Attractor::Torus(_) => {
            let driven = match study.motion {
                Motion::Driven => "one frequency is that of the drive; ",
                Motion::Free | Motion::Still => "",
            };
            match zeros {
                1 => format!("{driven}one exponent is zero{others}"),
                zeros => format!("{driven}{zeros} exponents are zero{others}"),
            }
        }
        Attractor::Chaos => "one exponent is positive".to_owned(),
        Attractor::Hyperchaos(count) => format!("{count} exponents are positive"),
        Attractor::Undecided => {
            "the sign of a decisive exponent is uncertain, or too few exponents are computed"
                .to_owned()
        }
    };
    format!("{attractor}: {reason}")
}

/// Tolerated difference of the sum of all exponents and the mean trace, relative to the sum of the absolute
/// values. The trace is only averaged over samples.
const MAX_IMBALANCE: f64 = 0.01;
/// Largest contraction of the last tangent vector in a mean step, as a natural logarithm. At 1.3 the exponent
/// of the fastest contraction of a joint was a fifth too small, at 0.4 it was accurate to 1 %.
const MAX_CONTRACTION: f64 = 0.7;

/// A warning if the steps are too long for the fastest contraction.
fn step_warning(found: &SceneLyapunov) -> Option<String> {
    let study = &found.study;
    let advice = match found.tolerance {
        Some(tolerance) => {
            let tighter = (0.01 * tolerance).clamp(1e-13, FULL_SPECTRUM_TOLERANCE);
            format!("set --tolerance {tighter:.0e}")
        }
        None => "reduce time.max_step_us".to_owned(),
    };
    let off = study.imbalance().filter(|&off| off > MAX_IMBALANCE);
    if let Some(off) = off {
        return Some(format!(
            "the sum of the exponents differs from the mean trace by {:.1} % of the sum of their absolute \
             values: the steps are too long for the fastest contraction; {advice}",
            100.0 * off
        ));
    }
    let is_coarse = study.imbalance().is_none() && study.contraction_per_step() > MAX_CONTRACTION;
    is_coarse.then(|| {
        format!(
            "the last exponent is not resolved: its tangent vector shrinks by a factor of e^{:.1} per \
             step on average; {advice}",
            study.contraction_per_step()
        )
    })
}

/// The running averages as CSV.
pub(super) fn csv(running: &[RunningExponents]) -> String {
    let count = running.first().map_or(0, |at| at.exponents.len());
    let mut text = "time_s".to_owned();
    for k in 1..=count {
        let _ = write!(text, ",exponent_{k}_per_s,half_width_{k}_per_s");
    }
    text.push('\n');
    for at in running {
        let _ = write!(text, "{}", at.time);
        for e in &at.exponents {
            let _ = write!(text, ",{},{}", e.value, e.half_width);
        }
        text.push('\n');
    }
    text
}

/// The report for the terminal.
pub(super) fn text(scene: &str, result: &LyapunovResult<'_>) -> String {
    let found = result.found;
    let study = &found.study;
    let name = format!("{HEADING}{}{HEADING:#}", escape::line(scene));
    // The title has the tilt.
    let held = FixedAt {
        tilt: None,
        ..found.fixed_at
    };
    let held = held.description().map(|words| format!(", {words}"));
    let mut text = format!(
        "{}{}: {}\n",
        title(&name, found.tilt),
        held.unwrap_or_default(),
        result.classification.description
    );
    if !study.spectrum.exponents.is_empty() {
        text += &table(result);
    }
    if study.segments.len() > 1 {
        text += &segments(&study.segments);
    }
    if let Some(dimension) = result.classification.kaplan_yorke {
        let dimension = uncertain(dimension.value, dimension.half_width);
        let _ = writeln!(text, "  Kaplan-Yorke dimension {dimension}");
    }
    if let Some(sum) = result.sum_per_s {
        let trace = study.mean_trace;
        let trace = trace.map(|trace| format!(", mean trace {trace:.3} 1/s"));
        let _ = writeln!(text, "  sum {sum:.3} 1/s{}", trace.unwrap_or_default());
    }
    for warning in warnings(found) {
        let _ = writeln!(text, "  {WARNING}warning:{WARNING:#} {warning}");
    }
    text + &work(result)
}

/// The table of exponents.
fn table(result: &LyapunovResult<'_>) -> String {
    let titles = ["", "exponent, 1/s", "95 % +-", "/ omega_1"];
    let table = titles.into_iter().fold(Table::default(), Table::right);
    let mut table = table.left("sign");
    let classification = &result.classification;
    let exponents = result.found.study.spectrum.exponents.iter();
    let scaled = classification.exponents_over_omega_1.iter();
    let scaled = scaled.zip(&classification.signs);
    for (k, (exponent, (scaled, sign))) in exponents.zip(scaled).enumerate() {
        let [value, error] = value_and_error(exponent.value, exponent.half_width);
        let number = (k + 1).to_string();
        let sign = match sign {
            Sign::Positive => format!("{BAD}{sign}{BAD:#}"),
            Sign::Undetermined => format!("{WARNING}{sign}{WARNING:#}"),
            Sign::Zero | Sign::Negative => sign.to_string(),
        };
        table.row([number, value, error, format!("{:.3e}", scaled.value), sign]);
    }
    table.text()
}

/// Number of exponents of each motion in the table.
const SEGMENT_EXPONENTS: usize = 3;

/// The table of successive motions.
fn segments(segments: &[MotionSegment]) -> String {
    let titles = ["start, s", "end, s"];
    let table = titles.into_iter().fold(Table::default(), Table::right);
    let mut table = table.left("attractor").left("largest exponents, 1/s");
    for segment in segments {
        let largest = segment.spectrum.exponents.iter().take(SEGMENT_EXPONENTS);
        let largest = largest.map(|e| uncertain(e.value, e.half_width));
        let largest = match segment.spectrum.time > 0.0 {
            true => largest.collect::<Vec<_>>().join(", "),
            false => "too short to average".to_owned(),
        };
        let [start, end] = [segment.start, segment.end].map(|t| format!("{t:.3}"));
        table.row([start, end, segment.attractor.to_string(), largest]);
    }
    table.text()
}

/// Reasons to distrust the result.
fn warnings(found: &SceneLyapunov) -> Vec<String> {
    let study = &found.study;
    let mut warnings = Vec::from_iter(step_warning(found));
    let unsettled = study.unsettled().into_iter();
    let unsettled: Vec<String> = unsettled.map(|k| (k + 1).to_string()).collect();
    if !unsettled.is_empty() {
        warnings.push(format!(
            "the tangent vectors are not aligned (out-of-order exponents: {}); raise --settle",
            unsettled.join(", ")
        ));
    }
    if study.stats.steps_without_event_location > 0 {
        warnings.push(format!(
            "{} of {} steps passed events without locating them, because the events were too frequent",
            study.stats.steps_without_event_location, study.stats.steps
        ));
    }
    if study.ending == Ending::MaxTimeReached {
        warnings.push(
            "the maximum averaging time was reached before the target; raise --average-time"
                .to_owned(),
        );
    }
    warnings
}

/// The averaging time, the resolution and the statistics of the integrator.
fn work(result: &LyapunovResult<'_>) -> String {
    let found = result.found;
    let study = &found.study;
    let mut text = format!(
        "  averaged over {:.3} s, after {:.3} s of the scene and {:.3} s of tangent alignment\n",
        study.spectrum.time, found.transient, study.settled
    );
    if !study.spectrum.exponents.is_empty() {
        let _ = writeln!(
            text,
            "  resolution: an exponent within +-{:.2} 1/s cannot be distinguished from zero",
            study.spectrum.resolution
        );
    }
    let tolerance = found.tolerance;
    let tolerance = tolerance.map(|tolerance| format!(" (tolerance {tolerance:.0e})"));
    let factor = result.real_time_factor;
    let factor = factor.map(|factor| format!(" ({factor:.2} x real time)"));
    let _ = writeln!(
        text,
        "  {} steps{}, {} rejected, {} right-hand-side evaluations in {:.2} s{}",
        study.stats.steps,
        tolerance.unwrap_or_default(),
        study.stats.rejections,
        study.stats.rhs_evals,
        study.busy_seconds,
        factor.unwrap_or_default()
    );
    text
}
