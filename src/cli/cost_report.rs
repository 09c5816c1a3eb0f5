//! What `squeakscope cost` found, for people and for programs.

use std::fmt::Write as _;

use anstyle::Style;
use serde::Serialize;

use super::report::{FileReport, Report, list_files};
use crate::VERSION;
use crate::escape;
use crate::study::cost::{Advice, CostStudy};

const NAME: Style = Style::new().bold();

/// Result of `squeakscope cost`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// The tilt at which it was held, degrees; `null` if its own is constant.
    pub held_at_deg: Option<f64>,
    /// What was held at its first value, in words; `null` where nothing varies.
    pub held: Option<String>,
    /// Time over which trajectories are compared, ms.
    pub horizon_ms: f64,
    /// The largest Lyapunov exponent, 1/s; `null` if it is not known.
    pub exponent_per_s: Option<f64>,
    /// The sets.
    pub sets: Vec<SetReport>,
    /// The cheapest setting of the integrator for each error.
    pub advice: Vec<AdviceReport>,
    /// Whether Ctrl-C ended the study: then knobs are missing.
    pub stopped: bool,
    /// Files written.
    pub files: Vec<FileReport>,
}

/// A knob turned through a family of settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SetReport {
    /// The knob.
    pub knob: &'static str,
    /// The family.
    pub family: String,
    /// What is turned.
    pub turned: &'static str,
    /// What the error is.
    pub error_is: &'static str,
    /// The reference's own error.
    pub reference_error: Option<f64>,
    /// The points.
    pub points: Vec<PointReport>,
}

/// One setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointReport {
    /// The setting.
    pub value: f64,
    /// CPU time, ms.
    pub cpu_ms: f64,
    /// Calls of the right-hand side.
    pub calls: u64,
    /// Its error; `null` where it failed.
    pub error: Option<f64>,
    /// What the value does not tell.
    pub detail: String,
    /// Why it failed.
    pub failed: Option<String>,
}

/// The cheapest setting for an error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdviceReport {
    /// The error allowed.
    pub target: f64,
    /// Its error.
    pub error: f64,
    /// The method, as a scene names it.
    pub method: String,
    /// Its tolerance, or its step in s where it is fixed.
    pub value: f64,
    /// CPU time over the horizon, ms.
    pub cpu_ms: f64,
    /// Calls of the right-hand side.
    pub calls: u64,
}

impl CostReport {
    /// Of a study, with the advice that follows.
    pub(super) fn new(study: &CostStudy, advised: &[Advice]) -> Self {
        let sets = study.sets.iter().map(|set| SetReport {
            knob: set.knob.name(),
            family: set.family.clone(),
            turned: set.turned,
            error_is: set.knob.error(),
            reference_error: set.floor,
            points: set
                .points
                .iter()
                .map(|point| PointReport {
                    value: point.value,
                    cpu_ms: 1e3 * point.seconds,
                    calls: point.calls,
                    error: point.error.as_ref().ok().copied(),
                    detail: point.detail.clone(),
                    failed: point.error.as_ref().err().cloned(),
                })
                .collect(),
        });
        let advice = advised.iter().map(|advice| AdviceReport {
            target: advice.target,
            error: advice.error,
            method: advice.method.clone(),
            value: advice.value,
            cpu_ms: 1e3 * advice.seconds,
            calls: advice.calls,
        });
        Self {
            version: VERSION,
            scene: study.scene.clone(),
            held_at_deg: study.held.tilt.map(f64::to_degrees),
            held: study.held.words(),
            horizon_ms: 1e3 * study.horizon,
            exponent_per_s: study.exponent.map(|exponent| exponent.value),
            sets: sets.collect(),
            advice: advice.collect(),
            stopped: study.stopped,
            files: Vec::new(),
        }
    }

    /// The sets as a chapter of a page: tables of settings, a column a family.
    pub(super) fn chapter(&self) -> String {
        let mut text = format!("## {}\n\n", escape::markdown(&self.scene));
        if let Some(held) = &self.held {
            let _ = write!(text, "Held at its first values: {held}. ");
        }
        let _ = write!(
            text,
            "Trajectories over {:.3} ms from the settled motion",
            self.horizon_ms
        );
        if let Some(exponent) = self.exponent_per_s {
            let _ = write!(text, ", whose largest exponent is {exponent:.1} 1/s");
        }
        text.push_str(".\n\n");
        if !self.advice.is_empty() {
            text.push_str(
                "| for an error of | the cheapest setting | CPU ms | calls | its error |\n|---|---|---|---|---|\n",
            );
            for advice in &self.advice {
                let _ = writeln!(
                    text,
                    "| {:.0e} | `{}` at {} | {:.2} | {} | {:.1e} |",
                    advice.target,
                    advice.method,
                    short(advice.value),
                    advice.cpu_ms,
                    advice.calls,
                    advice.error
                );
            }
            text.push('\n');
        }
        for sets in self.sets.chunk_by(|a, b| a.knob == b.knob) {
            let _ = writeln!(
                text,
                "**{}**: {}{}\n",
                sets[0].knob,
                sets[0].error_is,
                floors(sets)
            );
            // Families whose settings are the same share a table.
            for sets in sets.chunk_by(SetReport::is_turned_like) {
                text.push_str(&table(sets));
                text.push('\n');
            }
        }
        text
    }
}

impl SetReport {
    fn is_turned_like(&self, other: &Self) -> bool {
        let values = |set: &Self| set.points.iter().map(|p| p.value).collect::<Vec<_>>();
        self.turned == other.turned && values(self) == values(other)
    }
}

/// What the references' own errors are.
fn floors(sets: &[SetReport]) -> String {
    let floors = || sets.iter().filter_map(|set| set.reference_error);
    let (Some(least), Some(most)) = (floors().reduce(f64::min), floors().reduce(f64::max)) else {
        return String::new();
    };
    match least == most {
        true => format!("; the reference's own {}", digits(most)),
        false => format!(
            "; the references' own {} to {}",
            digits(least),
            digits(most)
        ),
    }
}

/// A row a setting, a column a family. Work and details that all families share have columns of their own.
fn table(sets: &[SetReport]) -> String {
    let shared = |same: fn(&PointReport, &PointReport) -> bool| {
        let all = |set: &SetReport| {
            let mut pairs = set.points.iter().zip(&sets[0].points);
            pairs.all(|(a, b)| same(a, b))
        };
        sets.len() > 1 && sets.iter().all(all)
    };
    let one_work = shared(|a, b| (a.cpu_ms, a.calls) == (b.cpu_ms, b.calls));
    let one_detail = shared(|a, b| a.detail == b.detail && !a.detail.is_empty());
    let mut head = vec![sets[0].turned];
    if one_detail {
        head.push("which");
    }
    if one_work {
        head.extend(["CPU ms", "calls"]);
    }
    head.extend(sets.iter().map(|set| &*set.family));
    let mut text = format!("| {} |\n{}|\n", head.join(" | "), "|---".repeat(head.len()));
    for (k, first) in sets[0].points.iter().enumerate() {
        let mut row = vec![short(first.value)];
        if one_detail {
            row.push(first.detail.clone());
        }
        if one_work {
            row.extend([format!("{:.2}", first.cpu_ms), first.calls.to_string()]);
        }
        for point in sets.iter().map(|set| &set.points[k]) {
            let mut cell = match point.error {
                Some(error) => digits(error),
                None => "failed".to_owned(),
            };
            if !one_work {
                let _ = write!(cell, " · {:.2} ms", point.cpu_ms);
                if point.calls > 0 {
                    let _ = write!(cell, " · {}", point.calls);
                }
            }
            if !one_detail && !point.detail.is_empty() {
                let _ = write!(cell, " · {}", point.detail);
            }
            row.push(cell);
        }
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
    text
}

impl Report for CostReport {
    fn text(&self) -> String {
        let mut text = format!(
            "{NAME}{}{NAME:#}: trajectories over {:.3} ms",
            escape::line(&self.scene),
            self.horizon_ms
        );
        if let Some(exponent) = self.exponent_per_s {
            let _ = write!(text, ", largest exponent {exponent:.1} 1/s");
        }
        if let Some(held) = &self.held {
            let _ = write!(
                text,
                "\nheld at its first values, {held}: give the scene others for another cost"
            );
        }
        text.push('\n');
        for set in &self.sets {
            let _ = write!(text, "{NAME}{}{NAME:#}: {}", set.knob, set.family);
            if let Some(floor) = set.reference_error {
                let _ = write!(text, " (the reference's own error {floor:.1e})");
            }
            let _ = writeln!(
                text,
                "\n  {:>12}  {:>10}  {:>10}  {}",
                set.turned, "CPU ms", "calls", set.error_is
            );
            for point in &set.points {
                let error = match (point.error, &point.failed) {
                    (Some(error), _) => format!("{error:.2e}"),
                    (None, why) => {
                        format!("failed: {}", escape::line(why.as_deref().unwrap_or("")))
                    }
                };
                let row = format!(
                    "  {:>12}  {:>10.3}  {:>10}  {error:<8}  {}",
                    short(point.value),
                    point.cpu_ms,
                    point.calls,
                    point.detail
                );
                let _ = writeln!(text, "{}", row.trim_end());
            }
        }
        if !self.advice.is_empty() {
            let _ = writeln!(
                text,
                "{NAME}the cheapest setting of the integrator{NAME:#}, for an error of its own: that of nodes, modes and elements comes on top"
            );
            for advice in &self.advice {
                let _ = writeln!(
                    text,
                    "  for an error of {:.0e}: {} at {}, {:.3} ms of CPU, {} calls, error {:.1e}",
                    advice.target,
                    advice.method,
                    short(advice.value),
                    advice.cpu_ms,
                    advice.calls,
                    advice.error
                );
            }
        }
        list_files(&mut text, &self.files);
        text
    }
}

/// An error to two digits.
fn digits(error: f64) -> String {
    match error {
        0.0 => "0".to_owned(),
        error => format!("{error:.1e}"),
    }
}

/// A setting as people write it.
fn short(value: f64) -> String {
    match value {
        value if (1e-2..1e6).contains(&value) => format!("{value}"),
        value => format!("{value:.1e}"),
    }
}
