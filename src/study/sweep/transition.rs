//! Transitions between the regimes of neighbouring points of a sweep.

use serde::Serialize;

use super::{Start, SweepPoint};
use crate::analysis::Regime;

/// A transition between two neighbouring values of the parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transition {
    /// Start of both points.
    pub start: Start,
    /// Lower value of the parameter, in the unit of the scene file.
    pub from: f64,
    /// Higher value of the parameter, in the unit of the scene file.
    pub to: f64,
    /// Name of the regime at the lower value.
    pub below: String,
    /// Name of the regime at the higher value.
    pub above: String,
    /// What happens with a rising parameter: "doubling of the torus, lines at (f1 + f2)/2"; `null` for a
    /// transition that is no doubling.
    pub doubling: Option<String>,
}

/// Transitions between neighbouring points with equal start. The points are those of a sweep over one
/// parameter in ascending order of index.
pub fn transitions(points: &[SweepPoint]) -> Vec<Transition> {
    let pairs = points.windows(2).filter(|pair| {
        let (below, above) = (&pair[0], &pair[1]);
        below.place.start == above.place.start && below.regime_name() != above.regime_name()
    });
    let transitions = pairs.map(|pair| Transition {
        start: pair[0].place.start,
        from: pair[0].place.values[0],
        to: pair[1].place.values[0],
        below: pair[0].regime_name(),
        above: pair[1].regime_name(),
        doubling: doubling(&pair[0], &pair[1]),
    });
    transitions.collect()
}

/// Description of a doubling, or of its reverse, between two points of the same regime.
fn doubling(below: &SweepPoint, above: &SweepPoint) -> Option<String> {
    let [below, above] = [below, above].map(|point| point.outcome.as_ref().ok());
    let (below, above) = (below?, above?);
    if below.regime != above.regime || below.doubling == above.doubling {
        return None;
    }
    let motion = match below.regime {
        Regime::QuasiPeriodic => "torus",
        _ => "period",
    };
    let (change, doubled) = match below.doubling < above.doubling {
        true => ("doubling", above),
        false => ("reverse doubling", below),
    };
    let lines = doubled.doubling_line();
    let lines = lines.map_or_else(String::new, |name| format!(", lines at {name}"));
    Some(format!("{change} of the {motion}{lines}"))
}
