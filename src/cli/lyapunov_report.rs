//! What `squeakscope lyapunov` says: a table for the terminal, every number as JSON.

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::flow_report::{DimensionReport, ExponentReport, exponents};
use super::report::{FileReport, Report, degrees, list_files};
use crate::VERSION;
use crate::dynamics::{Attractor, Exponent, Motion, Sign, Stability};
use crate::escape;
use crate::scene::Held;
use crate::study::lyapunov::{
    Ending, Goal, LyapunovRequest, LyapunovStudy, RESOLVING, RunningExponents, SceneLyapunov,
};

const GROWS: Style = AnsiColor::Red.on_default().bold();
const DOUBTFUL: Style = AnsiColor::Yellow.on_default().bold();
const NAME: Style = Style::new().bold();

/// Result of `squeakscope lyapunov`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LyapunovReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// Tilt of the load, degrees; `null` for a scene without a load.
    pub tilt_deg: Option<f64>,
    /// Load, N; `null` where it is constant in the scene.
    pub load_n: Option<f64>,
    /// Factor on the rotation; `null` where it is constant in the scene.
    pub rotation_factor: Option<f64>,
    /// Whether Ctrl-C ended it before its time.
    pub interrupted: bool,
    /// What was asked for: `time`, `half_width` or `verdict`.
    pub goal: &'static str,
    /// Whether that was reached.
    pub goal_reached: bool,
    /// Time for which the scene ran before, s.
    pub transient_s: f64,
    /// Time in which the tangent vectors settled, s.
    pub settle_s: f64,
    /// Time over which growth was averaged, s.
    pub averaged_s: f64,
    /// How many exponents there are in all.
    pub dimension: usize,
    /// The exponents followed, the largest first.
    pub exponents: Vec<ExponentReport>,
    /// An exponent nearer to zero than this cannot be told from zero, 1/s; `null` without exponents.
    pub resolution_per_s: Option<f64>,
    /// What the motion comes to: `rest`, `in-step`, `cycle`, `torus`, `chaos`, `hyper-chaos`,
    /// `stable-equilibrium`, `unstable-equilibrium`, `equilibrium` or `undecided`.
    pub attractor: &'static str,
    /// The same in words.
    pub words: String,
    /// Kaplan-Yorke dimension; `null` where too few exponents are known.
    pub kaplan_yorke: Option<DimensionReport>,
    /// Sum of all exponents, 1/s; `null` where not all are followed.
    pub sum_per_s: Option<f64>,
    /// Mean trace of `dF/dz`, which the sum must equal, 1/s; `null` where it is not known.
    pub mean_trace_per_s: Option<f64>,
    /// Error allowed in a step, relative to the size of the state; `null` for a fixed step.
    pub tolerance: Option<f64>,
    /// Circular frequency of the slowest mode, rad/s.
    pub omega_1_rad_per_s: f64,
    /// Accepted steps of the integrator, with tangent vectors.
    pub steps: u64,
    /// Rejected steps of the integrator.
    pub rejections: u64,
    /// Calls of the right-hand side.
    pub calls: u64,
    /// Guards crossed, where events are located.
    pub crossings: u64,
    /// Steps that ran over their events, which came too often to stop at each.
    pub overrun: u64,
    /// Wall time of settling and averaging, s.
    pub wall_s: f64,
    /// Simulated seconds a second of these; `null` where there were none.
    pub real_time_factor: Option<f64>,
    /// The exponents along the way.
    pub running: Vec<RunningReport>,
    /// Numbers, from 1, of exponents well below the next one: the tangent vectors have not settled.
    pub unsettled: Vec<usize>,
    /// Files written.
    pub files: Vec<FileReport>,
    /// What makes the steps too long for the contractions, for the terminal.
    #[serde(skip)]
    coarse: Option<String>,
}

/// The exponents after some time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunningReport {
    /// Time averaged, s.
    pub time_s: f64,
    /// Values, 1/s.
    pub values_per_s: Vec<f64>,
    /// Half widths of their intervals, 1/s.
    pub half_widths_per_s: Vec<f64>,
}

impl LyapunovReport {
    /// What a scene's exponents came to.
    pub fn new(
        scene: &str,
        request: &LyapunovRequest,
        found: &SceneLyapunov,
        files: Vec<FileReport>,
    ) -> Self {
        let study = &found.study;
        let spectrum = &study.spectrum;
        let attractor = study.attractor();
        let running = study.running.iter().map(|at| RunningReport {
            time_s: at.time,
            values_per_s: at.exponents.iter().map(|e| e.value).collect(),
            half_widths_per_s: at.exponents.iter().map(|e| e.half_width).collect(),
        });
        Self {
            version: VERSION,
            scene: scene.to_owned(),
            tilt_deg: found.tilt.map(degrees),
            load_n: found.held.load,
            rotation_factor: found.held.rotation_factor,
            interrupted: study.ending == Ending::Stopped,
            goal: match request.goal {
                Goal::Time(_) => "time",
                Goal::HalfWidth(_) => "half_width",
                Goal::Verdict => "verdict",
            },
            goal_reached: study.ending == Ending::Reached,
            transient_s: found.transient,
            settle_s: study.settled,
            averaged_s: spectrum.time,
            dimension: spectrum.dimension,
            exponents: exponents(spectrum, found.omega_1),
            resolution_per_s: Some(spectrum.resolution).filter(|_| !spectrum.exponents.is_empty()),
            attractor: attractor.name(),
            words: words(attractor, study),
            kaplan_yorke: DimensionReport::of(spectrum, study.motion),
            sum_per_s: study.sum(),
            mean_trace_per_s: study.mean_trace.filter(|_| study.sum().is_some()),
            tolerance: found.tolerance,
            omega_1_rad_per_s: found.omega_1,
            steps: study.tally.steps,
            rejections: study.tally.rejections,
            calls: study.tally.calls,
            crossings: study.tally.crossings,
            overrun: study.tally.overrun,
            wall_s: study.busy_seconds,
            real_time_factor: (study.followed > 0.0).then(|| study.followed / study.busy_seconds),
            running: running.collect(),
            unsettled: study.unsettled().into_iter().map(|k| k + 1).collect(),
            files,
            coarse: coarseness(found),
        }
    }

    /// Which motion it is, for a heading.
    pub fn title(scene: &str, tilt: Option<f64>) -> String {
        match tilt {
            Some(tilt) => format!("{scene} at {} deg", degrees(tilt)),
            None => scene.to_owned(),
        }
    }
}

/// What the motion comes to, and why.
fn words(attractor: Attractor, study: &LyapunovStudy) -> String {
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

/// A value with its error: two digits of the error, as many places of the value.
pub(super) fn in_brief(exponent: Exponent) -> String {
    let (value, error) = columns(exponent.value, exponent.half_width);
    format!("{value} +- {error}")
}

/// A value and its error as they stand in their columns.
fn columns(value: f64, error: f64) -> (String, String) {
    let places = if error > 0.0 && error.is_finite() {
        (1.0 - error.log10().floor()).clamp(0.0, 9.0) as usize
    } else {
        3
    };
    let number = |x: f64| match x.is_finite() {
        true => format!("{x:.places$}"),
        false if x.is_nan() => "?".to_owned(),
        false if x > 0.0 => "?".to_owned(),
        false => "-infinite".to_owned(),
    };
    (number(value), number(error))
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

impl Report for LyapunovReport {
    fn text(&self) -> String {
        let mut text = String::new();
        let scene = escape::line(&self.scene);
        let title = match self.tilt_deg {
            Some(tilt) => format!("{NAME}{scene}{NAME:#} at {tilt} deg"),
            None => format!("{NAME}{scene}{NAME:#}"),
        };
        // The tilt is in the title.
        let held = Held {
            tilt: None,
            load: self.load_n,
            rotation_factor: self.rotation_factor,
        };
        let held = held.words().map(|words| format!(", {words}"));
        let _ = writeln!(text, "{title}{}: {}", held.unwrap_or_default(), self.words);
        if !self.exponents.is_empty() {
            self.table(&mut text);
        }
        if let Some(dimension) = self.kaplan_yorke {
            let (value, error) = columns(dimension.value, dimension.half_width);
            let _ = writeln!(text, "  Kaplan-Yorke dimension {value} +- {error}");
        }
        if let Some(sum) = self.sum_per_s {
            let _ = write!(text, "  sum {sum:.3} 1/s");
            if let Some(trace) = self.mean_trace_per_s {
                let _ = write!(text, ", mean trace {trace:.3} 1/s");
            }
            text.push('\n');
        }
        if let Some(coarse) = &self.coarse {
            let _ = writeln!(text, "  {DOUBTFUL}beware:{DOUBTFUL:#} {coarse}");
        }
        if !self.unsettled.is_empty() {
            let numbers: Vec<String> = self.unsettled.iter().map(usize::to_string).collect();
            let _ = writeln!(
                text,
                "  {DOUBTFUL}beware:{DOUBTFUL:#} the vectors have not settled (the order of exponents {}); give a \
                 longer time with --settle",
                numbers.join(", ")
            );
        }
        if self.overrun > 0 {
            let _ = writeln!(
                text,
                "  {DOUBTFUL}beware:{DOUBTFUL:#} {} of {} steps ran over events that came too often to \
                 stop at each",
                self.overrun, self.steps
            );
        }
        let _ = writeln!(
            text,
            "  {:.3} s averaged, after {:.3} s of the scene and {:.3} s of settling",
            self.averaged_s, self.transient_s, self.settle_s
        );
        if let Some(resolution) = self.resolution_per_s {
            let _ = writeln!(
                text,
                "  nearer to zero than {resolution:.2} 1/s is not told from zero"
            );
        }
        if !self.goal_reached && !self.interrupted {
            let _ = writeln!(
                text,
                "  {DOUBTFUL}beware:{DOUBTFUL:#} the longest time was over before that was reached; give \
                 a longer one with --until"
            );
        }
        let _ = writeln!(
            text,
            "  {} steps{}, {} rejected, {} calls in {:.2} s{}",
            self.steps,
            match self.tolerance {
                Some(tolerance) => format!(" at tolerance {tolerance:.0e}"),
                None => String::new(),
            },
            self.rejections,
            self.calls,
            self.wall_s,
            match self.real_time_factor {
                Some(factor) => format!(" ({factor:.2} x real time)"),
                None => String::new(),
            }
        );
        list_files(&mut text, &self.files);
        text
    }
}

impl LyapunovReport {
    fn table(&self, text: &mut String) {
        let _ = writeln!(
            text,
            "  {:>3}  {:>12}  {:>10}  {:>13}  sign",
            "", "1/s", "+- 95 %", "over omega_1"
        );
        for e in &self.exponents {
            let (value, error) = columns(e.value_per_s, e.half_width_per_s);
            let _ = write!(
                text,
                "  {:>3}  {value:>12}  {error:>10}  {:>13.3e}  ",
                e.number, e.value_over_omega_1
            );
            let _ = match e.sign {
                "positive" => writeln!(text, "{GROWS}{}{GROWS:#}", e.sign),
                "doubtful" => writeln!(text, "{DOUBTFUL}{}{DOUBTFUL:#}", e.sign),
                sign => writeln!(text, "{sign}"),
            };
        }
    }
}
