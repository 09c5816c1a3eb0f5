//! What `squeakscope sweep` says: where the kind of motion changes, a table, every number as JSON.

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::report::{FileReport, Report, list_files};
use crate::VERSION;
use crate::escape;
use crate::number::uncertain;
use crate::study::sweep::{Shard, Start, SweepPlan, SweepPoint};

const NAME: Style = Style::new().bold();
const BEWARE: Style = AnsiColor::Yellow.on_default().bold();

/// More rows than these are not printed.
const MOST_ROWS: usize = 100;

/// Result of `squeakscope sweep`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// The parameters, with units.
    pub axes: Vec<String>,
    /// Points that are known.
    pub points_known: usize,
    /// Points in all.
    pub points_in_all: usize,
    /// Points of the part that was asked for: all of them, but for a shard.
    pub points_of_part: usize,
    /// Whether Ctrl-C ended it before its time.
    pub interrupted: bool,
    /// Stretches of one kind of motion, for a sweep over one parameter.
    pub stretches: Vec<StretchReport>,
    /// Values at which `up` and `down` come to different kinds of motion.
    pub hysteresis: Vec<f64>,
    /// The points, by number.
    pub points: Vec<PointReport>,
    /// Files written.
    pub files: Vec<FileReport>,
}

/// Neighbouring points of one kind of motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StretchReport {
    /// How they were started.
    pub start: String,
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// The kind of motion.
    pub regime: String,
}

/// One point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointReport {
    /// Its number.
    pub index: usize,
    /// How it was started.
    pub start: String,
    /// Values of the parameters.
    pub values: Vec<f64>,
    /// Why there is no response; `null` where there is one.
    pub error: Option<String>,
    /// Kind of motion.
    pub regime: Option<String>,
    /// How sure that is, 0 to 1.
    pub confidence: Option<f64>,
    /// Whether the transient was over.
    pub settled: Option<bool>,
    /// Time until then, s.
    pub transient_s: Option<f64>,
    /// Amplitude at the probe, um.
    pub amplitude_um: Option<f64>,
    /// Lines, the strongest first, Hz.
    pub lines_hz: Vec<f64>,
    /// Largest exponents, 1/s.
    pub exponents_per_s: Vec<f64>,
    /// Half widths of their 95 % intervals, 1/s.
    pub half_widths_per_s: Vec<f64>,
    /// Unstable linear modes.
    pub unstable_modes: Option<usize>,
    /// The largest exponent in brief.
    #[serde(skip)]
    largest: String,
}

impl SweepReport {
    /// What a sweep has come to so far; the points in the order of their numbers.
    pub fn new(
        plan: &SweepPlan,
        points: &[SweepPoint],
        shard: Shard,
        interrupted: bool,
        files: Vec<FileReport>,
    ) -> Self {
        let rows: Vec<PointReport> = points.iter().map(PointReport::new).collect();
        let one = plan.axes.len() == 1;
        Self {
            version: VERSION,
            scene: plan.scene.name.clone(),
            axes: plan.axes.iter().map(|axis| axis.label()).collect(),
            points_known: points.len(),
            points_in_all: plan.len(),
            points_of_part: plan.chains(shard).iter().map(Vec::len).sum(),
            interrupted,
            stretches: if one { stretches(&rows) } else { Vec::new() },
            hysteresis: if one { hysteresis(&rows) } else { Vec::new() },
            points: rows,
            files,
        }
    }
}

impl PointReport {
    fn new(point: &SweepPoint) -> Self {
        let place = &point.place;
        let found = point.outcome.as_ref().ok();
        let exponents = || {
            let spectrum = found.and_then(|found| found.exponents.as_ref());
            spectrum
                .into_iter()
                .flat_map(|spectrum| &spectrum.exponents)
        };
        Self {
            index: place.index,
            start: place.start.to_string(),
            values: place.values.clone(),
            error: point.outcome.as_ref().err().cloned(),
            regime: found.map(|found| found.regime.to_string()),
            confidence: found.map(|found| found.confidence),
            settled: found.map(|found| found.settled),
            transient_s: found.map(|found| found.transient),
            amplitude_um: found.map(|found| 1e6 * found.amplitude),
            lines_hz: found
                .iter()
                .flat_map(|found| found.lines.iter().map(|line| line.frequency))
                .collect(),
            exponents_per_s: exponents().map(|e| e.value).collect(),
            half_widths_per_s: exponents().map(|e| e.half_width).collect(),
            unstable_modes: found
                .and_then(|found| found.linear.as_ref())
                .map(|linear| linear.unstable().count()),
            largest: exponents()
                .next()
                .map(|e| uncertain(e.value, e.half_width))
                .unwrap_or_default(),
        }
    }

    /// The kind of motion in a word.
    fn kind(&self) -> &str {
        self.regime.as_deref().unwrap_or("no response")
    }
}

/// Neighbours of one kind, start by start.
fn stretches(points: &[PointReport]) -> Vec<StretchReport> {
    let mut stretches: Vec<StretchReport> = Vec::new();
    for point in points {
        let value = point.values[0];
        match stretches.last_mut() {
            Some(last) if last.start == point.start && last.regime == point.kind() => {
                last.to = value
            }
            _ => stretches.push(StretchReport {
                start: point.start.clone(),
                from: value,
                to: value,
                regime: point.kind().to_owned(),
            }),
        }
    }
    stretches
}

/// Where up and down differ.
fn hysteresis(points: &[PointReport]) -> Vec<f64> {
    let of = |start: Start| {
        let name = start.to_string();
        points.iter().filter(move |point| point.start == name)
    };
    let up = of(Start::Up).filter(|up| {
        let mut down = of(Start::Down);
        down.any(|down| down.values == up.values && down.kind() != up.kind())
    });
    up.map(|up| up.values[0]).collect()
}

impl Report for SweepReport {
    fn text(&self) -> String {
        let mut text = format!(
            "{NAME}{}{NAME:#} over {}\n",
            escape::line(&self.scene),
            self.axes.join(" and ")
        );
        if self.points_known < self.points_of_part {
            let _ = writeln!(
                text,
                "  {BEWARE}{} of {} points{BEWARE:#} so far; --resume goes on with the rest",
                self.points_known, self.points_of_part
            );
        } else if self.points_known < self.points_in_all {
            let _ = writeln!(
                text,
                "  a part: {} of {} points; `squeakscope merge` joins the parts",
                self.points_known, self.points_in_all
            );
        }
        for stretch in &self.stretches {
            let _ = if stretch.from == stretch.to {
                writeln!(
                    text,
                    "  {:>4}  {}: {}",
                    stretch.start, stretch.from, stretch.regime
                )
            } else {
                writeln!(
                    text,
                    "  {:>4}  {} to {}: {}",
                    stretch.start, stretch.from, stretch.to, stretch.regime
                )
            };
        }
        if !self.hysteresis.is_empty() {
            let values: Vec<String> = self.hysteresis.iter().map(f64::to_string).collect();
            let _ = writeln!(text, "  up and down differ at {}", values.join(", "));
        }
        self.table(&mut text);
        let failed = self
            .points
            .iter()
            .filter(|point| point.error.is_some())
            .count();
        if failed > 0 {
            let _ = writeln!(
                text,
                "  {BEWARE}{failed} points{BEWARE:#} have no response: see `error` in the tables"
            );
        }
        let unsettled = self
            .points
            .iter()
            .filter(|point| point.settled == Some(false))
            .count();
        if unsettled > 0 {
            let _ = writeln!(
                text,
                "  {BEWARE}{unsettled} points{BEWARE:#} (marked *) still changed when they were measured; give a longer --most"
            );
        }
        list_files(&mut text, &self.files);
        text
    }
}

impl SweepReport {
    fn table(&self, text: &mut String) {
        if self.points.len() > MOST_ROWS {
            return;
        }
        let values = self.axes.join("  ");
        let width = values.len();
        let _ = writeln!(
            text,
            "\n  {:>4}  {values}  {:<16}  {:>9}  {:>12}  {:>14}  unstable",
            "", "motion", "um", "line, Hz", "exponent, 1/s"
        );
        for point in &self.points {
            let values: Vec<String> = point.values.iter().map(f64::to_string).collect();
            let mark = if point.settled == Some(false) {
                "*"
            } else {
                ""
            };
            let number = |value: Option<f64>, places: usize| {
                value
                    .map(|value| format!("{value:.places$}"))
                    .unwrap_or_default()
            };
            let _ = writeln!(
                text,
                "  {:>4}  {:>width$}  {:<16}  {:>9}  {:>12}  {:>14}  {}",
                point.start,
                values.join("  "),
                format!("{}{mark}", point.kind()),
                number(point.amplitude_um, 4),
                number(point.lines_hz.first().copied(), 1),
                point.largest,
                point
                    .unstable_modes
                    .map(|count| count.to_string())
                    .unwrap_or_default(),
            );
        }
        text.push('\n');
    }
}
