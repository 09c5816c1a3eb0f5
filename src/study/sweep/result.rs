//! What a sweep has come to: where the kind of motion changes, and all points.

use serde::{Serialize, Serializer};

use super::row::Row;
use super::{Shard, Start, SweepPlan, SweepPoint};

/// What is known of a sweep.
#[derive(Debug, Serialize)]
pub struct SweepResult<'a> {
    /// The parameters, with units.
    pub axes: Vec<String>,
    /// Points that are known.
    pub points_known: usize,
    /// Points in all.
    pub points_in_all: usize,
    /// Points of the part that was asked for: all of them, but for a shard.
    pub points_of_part: usize,
    /// Whether it was ended before its time.
    pub interrupted: bool,
    /// Stretches of one kind of motion, for a sweep over one parameter.
    pub stretches: Vec<Stretch>,
    /// Values at which `up` and `down` come to different kinds of motion.
    pub hysteresis: Vec<f64>,
    /// The points, by number.
    #[serde(serialize_with = "rows")]
    pub points: &'a [SweepPoint],
}

/// Neighbouring points of one kind of motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// How they were started.
    pub start: Start,
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// The kind of motion.
    pub regime: String,
}

impl<'a> SweepResult<'a> {
    /// What is known by the points of a plan, in the order of their numbers, when a shard was asked for.
    pub fn new(
        plan: &SweepPlan,
        points: &'a [SweepPoint],
        shard: Shard,
        interrupted: bool,
    ) -> Self {
        let over_one = match plan.axes.len() {
            1 => points,
            _ => &[],
        };
        Self {
            axes: plan.axes.iter().map(|axis| axis.label()).collect(),
            points_known: points.len(),
            points_in_all: plan.len(),
            points_of_part: plan.chains(shard).iter().map(Vec::len).sum(),
            interrupted,
            stretches: stretches(over_one),
            hysteresis: hysteresis(over_one),
            points,
        }
    }
}

/// Neighbours of one kind, start by start.
fn stretches(points: &[SweepPoint]) -> Vec<Stretch> {
    let alike =
        |a: &SweepPoint, b: &SweepPoint| (a.place.start, a.kind()) == (b.place.start, b.kind());
    let stretches = points.chunk_by(alike).map(|points| Stretch {
        start: points[0].place.start,
        from: points[0].place.values[0],
        to: points[points.len() - 1].place.values[0],
        regime: points[0].kind(),
    });
    stretches.collect()
}

/// Where up and down differ.
fn hysteresis(points: &[SweepPoint]) -> Vec<f64> {
    let of = |start: Start| {
        points
            .iter()
            .filter(move |point| point.place.start == start)
    };
    let differ = of(Start::Up).filter(|up| {
        of(Start::Down).any(|down| down.place.values == up.place.values && down.kind() != up.kind())
    });
    differ.map(|up| up.place.values[0]).collect()
}

/// A point as JSON has it.
#[derive(Serialize)]
struct Record {
    /// Its row of the table.
    #[serde(flatten)]
    row: Row,
    /// How many linear modes are unstable.
    unstable_modes: Option<usize>,
}

/// Points as JSON has them: without what is only there to draw or to go on from, which the table has.
fn rows<S: Serializer>(points: &[SweepPoint], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(points.iter().map(|point| {
        let linear = point
            .outcome
            .as_ref()
            .ok()
            .and_then(|found| found.linear.as_ref());
        let unstable_modes = linear.map(|linear| linear.unstable().count());
        let mut point = point.clone();
        if let Ok(found) = &mut point.outcome {
            found.portrait = None;
            found.state.clear();
        }
        Record {
            row: Row::new(&point),
            unstable_modes,
        }
    }))
}
