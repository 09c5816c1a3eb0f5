//! Result of a sweep: the points, and the parameter intervals of each regime.

use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::continuation::BifurcationKind;

use super::{Axis, Shard, Start, SweepPlan, SweepPoint, Transition, transitions};
use crate::chain_of_causes;
use crate::number::{counted, fixed, quantity};
use crate::report::{Block, Measured, Report, Table, Tone};
use crate::study::branch::hysteresis_ends;
use crate::study::{OnProgress, StudyError};

/// Result of a sweep.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SweepResult {
    /// Labels of the axes, with units.
    pub axes: Vec<String>,
    /// Number of points computed.
    pub points_computed: usize,
    /// Total number of points of the sweep.
    pub points_total: usize,
    /// Number of points in the requested shard; without a shard, the total.
    pub points_in_shard: usize,
    /// Whether the sweep was stopped early.
    pub interrupted: bool,
    /// What the result lacks, and why.
    pub warnings: Vec<String>,
    /// Parameter intervals of one regime, for a sweep over one parameter.
    pub regime_intervals: Vec<RegimeInterval>,
    /// Transitions from one regime to another between neighbouring values of the parameter, for a sweep over
    /// one parameter.
    pub transitions: Vec<Transition>,
    /// Hysteresis: parameter values at which upward and downward continuation reach different regimes.
    pub hysteresis: Vec<f64>,
    /// Ends of the hysteresis: the bifurcations at which a periodic motion ends or loses its stability there, as far as
    /// continuation finds them.
    pub hysteresis_ends: Vec<HysteresisEnd>,
    /// The points in ascending order of index.
    pub points: Vec<SweepPoint>,
}

/// An end of hysteresis: a bifurcation at which a periodic motion ends or loses its stability, so that the response jumps to
/// another one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct HysteresisEnd {
    /// Kind of the bifurcation.
    pub kind: BifurcationKind,
    /// Value of the parameter, in the unit of the scene file.
    pub value: f64,
    /// Frequency of the motion, Hz.
    pub frequency_hz: f64,
}

/// An interval of the parameter with a single regime.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RegimeInterval {
    /// Start of its points.
    pub start: Start,
    /// First value of the parameter, in the unit of the scene file.
    pub from: f64,
    /// Last value of the parameter, in the unit of the scene file.
    pub to: f64,
    /// Name of the regime, or "no response".
    pub regime: String,
}

impl SweepResult {
    /// The result of the points of a plan in ascending order of index.
    pub fn new<S>(plan: &SweepPlan<S>, points: Vec<SweepPoint>, shard: Shard) -> Self {
        let points_in_shard = plan.chains(shard).iter().map(Vec::len).sum();
        let is_single = plan.axes.len() == 1;
        let single_axis = if is_single { &points[..] } else { &[] };
        Self {
            axes: plan.axes.iter().map(Axis::label).collect(),
            points_computed: points.len(),
            points_total: plan.size(),
            points_in_shard,
            interrupted: points.len() < points_in_shard,
            warnings: Vec::new(),
            regime_intervals: regime_intervals(single_axis),
            transitions: transitions(single_axis),
            hysteresis: hysteresis(single_axis),
            hysteresis_ends: Vec::new(),
            points,
        }
    }

    /// The result of a sweep of a scene with the bifurcations that end the hysteresis, unless it is interrupted.
    pub fn concluded(mut self, plan: &SweepPlan, progress: OnProgress<'_>) -> Self {
        if self.interrupted || self.hysteresis.is_empty() {
            return self;
        }
        let progress = &mut |_, _: &str| progress(1.0, "branches that end the hysteresis");
        match hysteresis_ends(plan, &self.points, &self.hysteresis, progress) {
            Ok(ends) => self.hysteresis_ends = ends,
            Err(StudyError::Stopped(_)) => self.interrupted = true,
            Err(error) => {
                let reason = chain_of_causes(&error);
                self.warnings
                    .push(format!("no ends of the hysteresis: {reason}"));
            }
        }
        self
    }
}

/// Runs of successive points with equal start and regime.
fn regime_intervals(points: &[SweepPoint]) -> Vec<RegimeInterval> {
    let alike = |a: &SweepPoint, b: &SweepPoint| {
        (a.place.start, a.regime_name()) == (b.place.start, b.regime_name())
    };
    let intervals = points.chunk_by(alike).map(|points| RegimeInterval {
        start: points[0].place.start,
        from: points[0].place.values[0],
        to: points[points.len() - 1].place.values[0],
        regime: points[0].regime_name(),
    });
    intervals.collect()
}

/// Values at which upward and downward continuation differ in regime.
fn hysteresis(points: &[SweepPoint]) -> Vec<f64> {
    let of = |start: Start| {
        points
            .iter()
            .filter(move |point| point.place.start == start)
    };
    let differ = of(Start::Upward).filter(|up| {
        of(Start::Downward).any(|down| {
            down.place.values == up.place.values && down.regime_name() != up.regime_name()
        })
    });
    differ.map(|up| up.place.values[0]).collect()
}

/// Largest number of points that are printed as a table.
const MAX_ROWS: usize = 100;

impl Report for SweepResult {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let over = format!(" over {}", self.axes.join(" and "));
        let mut blocks = vec![Block::heading(scene, over)];
        let (known, part) = (self.points_computed, self.points_in_shard);
        if known < part {
            let missing = format!("{known} of {part} points computed; --resume computes the rest");
            blocks.push(Block::Warning(missing));
        } else if known < self.points_total {
            blocks.push(Block::text(format!(
                "a shard: {known} of {} points; `squeakscope merge` joins the shards",
                self.points_total
            )));
        }
        for interval in &self.regime_intervals {
            let (start, from, to) = (interval.start, interval.from, interval.to);
            let to = if from == to {
                String::new()
            } else {
                format!(" to {to}")
            };
            let regime = &interval.regime;
            blocks.push(Block::text(format!("{start:>4}  {from}{to}: {regime}")));
        }
        for transition in &self.transitions {
            if let Some(doubling) = &transition.doubling {
                let (start, from, to) = (transition.start, transition.from, transition.to);
                blocks.push(Block::text(format!(
                    "{start:>4}  between {from} and {to}: {doubling}"
                )));
            }
        }
        if !self.hysteresis.is_empty() {
            let values: Vec<String> = self.hysteresis.iter().map(f64::to_string).collect();
            blocks.push(Block::text(format!(
                "hysteresis: upward and downward differ at {}",
                values.join(", ")
            )));
        }
        blocks.extend(self.warnings.iter().cloned().map(Block::Warning));
        for end in &self.hysteresis_ends {
            let (kind, value) = (end.kind, end.value);
            let ends = match kind {
                BifurcationKind::Fold => "ends",
                _ => "loses its stability",
            };
            let frequency = quantity(end.frequency_hz, 5, "Hz");
            blocks.push(Block::text(format!(
                "the motion of {frequency} {ends} at {value:.6} ({kind})"
            )));
        }
        if self.points.len() <= MAX_ROWS {
            blocks.push(self.table());
        }
        let count = |is_counted: fn(&SweepPoint) -> bool| {
            self.points.iter().filter(|point| is_counted(point)).count()
        };
        let failed = count(|point| point.outcome.is_err());
        if failed > 0 {
            blocks.push(Block::Text(vec![
                Tone::Doubtful.cell(counted(failed, "point")),
                " failed; the column `error` of the table has the reasons".into(),
            ]));
        }
        let unsettled = count(SweepPoint::is_unsettled);
        if unsettled > 0 {
            blocks.push(Block::Text(vec![
                Tone::Doubtful.cell(counted(unsettled, "point")),
                " (marked *) had not settled before the measurement; raise --max-transient".into(),
            ]));
        }
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted
    }
}

impl SweepResult {
    /// The points, one per row.
    fn table(&self) -> Block {
        let table = Table::of(self.points.iter());
        let table = table.right("", |point| point.place.start.to_string());
        let axes = self.axes.iter().enumerate();
        let table = axes.fold(table, |table, (k, axis)| {
            table.right(axis, |point| point.place.values[k].to_string())
        });
        table
            .left("type of motion", |point| {
                let mark = if point.is_unsettled() { "*" } else { "" };
                point.regime_name() + mark
            })
            .right("amplitude, µm", |point| {
                fixed(point.found().map(|found| 1e6 * found.amplitude_m), 4)
            })
            .right("line, Hz", |point| {
                let line = point.found().and_then(|found| found.lines.first());
                fixed(line.map(|line| line.frequency), 1)
            })
            .right("doubling", |point| {
                point.found().map(|found| found.doubling.to_string())
            })
            .right("exponent, 1/s", |point| {
                let largest = point.found()?.exponents.as_ref()?.exponents.first();
                largest.map(|largest| Measured::from(largest).to_string())
            })
            .right("unstable modes", |point| {
                let linear = point.found()?.linear.as_ref();
                linear.map(|linear| linear.unstable().count().to_string())
            })
            .into()
    }
}
