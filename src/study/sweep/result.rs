//! Result of a sweep: the points, and the parameter intervals of each regime.

use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::continuation::BifurcationKind;

use super::{Shard, Start, SweepPlan, SweepPoint, Transition, transitions};

/// Result of a sweep.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SweepResult<'a> {
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
    pub points: &'a [SweepPoint],
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

impl<'a> SweepResult<'a> {
    /// Collects the result from the points of a plan, in ascending order of index.
    pub fn new(
        plan: &SweepPlan,
        points: &'a [SweepPoint],
        shard: Shard,
        interrupted: bool,
    ) -> Self {
        let single_axis = match plan.axes.len() {
            1 => points,
            _ => &[],
        };
        Self {
            axes: plan.axes.iter().map(|axis| axis.label()).collect(),
            points_computed: points.len(),
            points_total: plan.len(),
            points_in_shard: plan.chains(shard).iter().map(Vec::len).sum(),
            interrupted,
            regime_intervals: regime_intervals(single_axis),
            transitions: transitions(single_axis),
            hysteresis: hysteresis(single_axis),
            hysteresis_ends: Vec::new(),
            points,
        }
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
