//! What `squeakscope lyapunov` says: what the motion comes to, a table, and what to beware of.

use std::fmt::Write as _;

use serde::Serialize;

use super::exponents::Reading;
use super::report::{BAD, DOUBTFUL, NAME, degrees};
use crate::dynamics::{Attractor, Motion, Sign, Stability};
use crate::escape;
use crate::number::{uncertain, value_and_error};
use crate::scene::Held;
use crate::study::lyapunov::{
    Ending, Goal, LyapunovStudy, RESOLVING, RunningExponents, SceneLyapunov,
};
use crate::table::Table;

/// What was found, and what it comes to.
#[derive(Debug, Serialize)]
pub(super) struct Found<'a> {
    /// What was asked for: `time`, `half_width` or `verdict`.
    goal: &'static str,
    /// Whether that was reached.
    goal_reached: bool,
    /// Whether it was ended before its time.
    interrupted: bool,
    #[serde(flatten)]
    pub reading: Reading,
    /// Sum of all exponents; none where not all are followed.
    pub sum_per_s: Option<f64>,
    /// Numbers, from 1, of exponents well below the next one: the tangent vectors have not settled.
    pub unsettled: Vec<usize>,
    /// Simulated seconds a second; none where nothing was followed.
    pub real_time_factor: Option<f64>,
    #[serde(flatten)]
    pub found: &'a SceneLyapunov,
}

impl<'a> Found<'a> {
    pub fn new(goal: Goal, found: &'a SceneLyapunov) -> Self {
        let study = &found.study;
        let attractor = study.attractor();
        Self {
            goal: match goal {
                Goal::Time(_) => "time",
                Goal::HalfWidth(_) => "half_width",
                Goal::Verdict => "verdict",
            },
            goal_reached: study.ending == Ending::Reached,
            interrupted: study.ending == Ending::Stopped,
            reading: Reading {
                words: words(study),
                ..Reading::new(&study.spectrum, study.motion, attractor, found.omega_1)
            },
            sum_per_s: study.sum(),
            unsettled: study.unsettled().into_iter().map(|k| k + 1).collect(),
            real_time_factor: (study.followed > 0.0).then(|| study.followed / study.busy_seconds),
            found,
        }
    }
}

/// Which motion it is, for a heading.
pub(super) fn title(scene: &str, tilt: Option<f64>) -> String {
    match tilt {
        Some(tilt) => format!("{scene} at {} deg", degrees(tilt)),
        None => scene.to_owned(),
    }
}

/// What the motion comes to, and why.
pub(super) fn words(study: &LyapunovStudy) -> String {
    let attractor = study.attractor();
    let spectrum = &study.spectrum;
    if spectrum.exponents.is_empty() {
        return "undecided: no growth was averaged".to_owned();
    }
    let zeros = spectrum.count(Sign::Zero);
    let others = match spectrum.dimension > zeros {
        true => ", the others are negative",
        false => "",
    };
    let because = match attractor {
        Attractor::Equilibrium(Stability::Stable) => {
            "it does not move, and every exponent is negative".to_owned()
        }
        Attractor::Equilibrium(Stability::Unstable) => {
            "it does not move, but the least push would grow".to_owned()
        }
        Attractor::Equilibrium(Stability::Undecided) => {
            "it does not move, and no exponent is shown to be positive".to_owned()
        }
        Attractor::Rest | Attractor::InStep => "every exponent is negative".to_owned(),
        Attractor::Cycle => format!("one exponent is zero{others}"),
        Attractor::Torus(_) => {
            let driven = match study.motion {
                Motion::Driven => "one tone is the drive's; ",
                Motion::Free | Motion::Still => "",
            };
            match zeros {
                1 => format!("{driven}one exponent is zero{others}"),
                zeros => format!("{driven}{zeros} exponents are zero{others}"),
            }
        }
        Attractor::Chaos => "one exponent is positive".to_owned(),
        Attractor::HyperChaos(count) => format!("{count} exponents are positive"),
        Attractor::Undecided => {
            "an exponent that matters is doubtful, or too few are followed".to_owned()
        }
    };
    format!("{attractor}: {because}")
}

/// The sum of all exponents may be so far off the mean trace, over the sum of their sizes: the trace
/// is a mean over samples.
const OFF: f64 = 0.01;
/// The last direction followed may shrink so much in a mean step, as a natural logarithm: at 1.3 the
/// fastest contraction of a joint came out a fifth too slow, at 0.4 it was right to a per cent.
const CONTRACTION: f64 = 0.7;

/// A warning where the steps are too long for the contractions.
fn coarseness(found: &SceneLyapunov) -> Option<String> {
    let study = &found.study;
    let advice = match found.tolerance {
        Some(tolerance) => {
            let tighter = (0.01 * tolerance).clamp(1e-13, RESOLVING);
            format!("give --tolerance {tighter:.0e}")
        }
        None => "shorten time.max_step_us".to_owned(),
    };
    let off = study.imbalance().filter(|&off| off > OFF);
    if let Some(off) = off {
        return Some(format!(
            "sum and mean trace should be equal and differ by {:.1} % of the exponents' sizes: the \
             steps are too long for the fastest contractions; {advice}",
            100.0 * off
        ));
    }
    let unseen = study.imbalance().is_none() && study.contraction_per_step() > CONTRACTION;
    unseen.then(|| {
        format!(
            "the last exponent is hardly resolved: its direction shrinks by e^{:.1} in a mean step; \
             {advice}",
            study.contraction_per_step()
        )
    })
}

/// The running values as columns of text with a heading.
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

/// The text for the terminal.
pub(super) fn text(scene: &str, result: &Found<'_>) -> String {
    let found = result.found;
    let study = &found.study;
    let name = format!("{NAME}{}{NAME:#}", escape::line(scene));
    // The tilt is in the title.
    let held = Held {
        tilt: None,
        ..found.held
    };
    let held = held.words().map(|words| format!(", {words}"));
    let mut text = format!(
        "{}{}: {}\n",
        title(&name, found.tilt),
        held.unwrap_or_default(),
        result.reading.words
    );
    if !study.spectrum.exponents.is_empty() {
        text += &table(result);
    }
    if let Some(dimension) = result.reading.kaplan_yorke {
        let dimension = uncertain(dimension.value, dimension.half_width);
        let _ = writeln!(text, "  Kaplan-Yorke dimension {dimension}");
    }
    if let Some(sum) = result.sum_per_s {
        let trace = study.mean_trace;
        let trace = trace.map(|trace| format!(", mean trace {trace:.3} 1/s"));
        let _ = writeln!(text, "  sum {sum:.3} 1/s{}", trace.unwrap_or_default());
    }
    for warning in warnings(found) {
        let _ = writeln!(text, "  {DOUBTFUL}beware:{DOUBTFUL:#} {warning}");
    }
    text + &work(result)
}

/// The exponents.
fn table(result: &Found<'_>) -> String {
    let titles = ["", "1/s", "+- 95 %", "over omega_1"];
    let table = titles.into_iter().fold(Table::default(), Table::right);
    let mut table = table.left("sign");
    let reading = &result.reading;
    let exponents = result.found.study.spectrum.exponents.iter();
    let scaled = reading.exponents_over_omega_1.iter().zip(&reading.signs);
    for (k, (exponent, (scaled, sign))) in exponents.zip(scaled).enumerate() {
        let [value, error] = value_and_error(exponent.value, exponent.half_width);
        let number = (k + 1).to_string();
        let sign = match sign {
            Sign::Positive => format!("{BAD}{sign}{BAD:#}"),
            Sign::Doubtful => format!("{DOUBTFUL}{sign}{DOUBTFUL:#}"),
            Sign::Zero | Sign::Negative => sign.to_string(),
        };
        table.row([number, value, error, format!("{:.3e}", scaled.value), sign]);
    }
    table.text()
}

/// What to beware of.
fn warnings(found: &SceneLyapunov) -> Vec<String> {
    let study = &found.study;
    let mut warnings = Vec::from_iter(coarseness(found));
    let unsettled = study.unsettled().into_iter();
    let unsettled: Vec<String> = unsettled.map(|k| (k + 1).to_string()).collect();
    if !unsettled.is_empty() {
        warnings.push(format!(
            "the vectors have not settled (the order of exponents {}); give a longer time with --settle",
            unsettled.join(", ")
        ));
    }
    if study.tally.overrun > 0 {
        warnings.push(format!(
            "{} of {} steps ran over events that came too often to stop at each",
            study.tally.overrun, study.tally.steps
        ));
    }
    if study.ending == Ending::OutOfTime {
        warnings.push(
            "the longest time was over before that was reached; give a longer one with --until"
                .to_owned(),
        );
    }
    warnings
}

/// Over which time was averaged, and what it took.
fn work(result: &Found<'_>) -> String {
    let found = result.found;
    let study = &found.study;
    let mut text = format!(
        "  {:.3} s averaged, after {:.3} s of the scene and {:.3} s of settling\n",
        study.spectrum.time, found.transient, study.settled
    );
    if !study.spectrum.exponents.is_empty() {
        let _ = writeln!(
            text,
            "  nearer to zero than {:.2} 1/s is not told from zero",
            study.spectrum.resolution
        );
    }
    let tolerance = found.tolerance;
    let tolerance = tolerance.map(|tolerance| format!(" at tolerance {tolerance:.0e}"));
    let factor = result.real_time_factor;
    let factor = factor.map(|factor| format!(" ({factor:.2} x real time)"));
    let _ = writeln!(
        text,
        "  {} steps{}, {} rejected, {} calls in {:.2} s{}",
        study.tally.steps,
        tolerance.unwrap_or_default(),
        study.tally.rejections,
        study.tally.calls,
        study.busy_seconds,
        factor.unwrap_or_default()
    );
    text
}
