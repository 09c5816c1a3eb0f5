//! Transitions between the regimes of neighbouring points of a sweep.

use schemars::JsonSchema;
use serde::Serialize;

use super::{Start, SweepPoint};
use crate::analysis::regime::Regime;

/// A transition between two neighbouring values of the parameter.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
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
    let (change, doubled) = if below.doubling < above.doubling {
        ("doubling", above)
    } else {
        ("reverse doubling", below)
    };
    let lines = doubled.doubling_line();
    let lines = lines.map_or_else(String::new, |name| format!(", lines at {name}"));
    Some(format!("{change} of the {motion}{lines}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::tones::SpectralLine;
    use crate::dynamics::SolverStats;
    use crate::study::response::SettledResponse;
    use crate::study::sweep::Place;

    fn point(index: usize, regime: Regime, doubling: u32) -> SweepPoint {
        let line = |label: &str| SpectralLine {
            frequency: 4000.0,
            amplitude: 1e-7,
            label: label.to_owned(),
        };
        let names = ["f1", "(f1 + f2)/2", "(f1 + 3 f2)/4"];
        let found = SettledResponse {
            transient: 0.1,
            settled: true,
            amplitude: 7e-7,
            mean: 0.0,
            rms_velocity: 0.01,
            peak_velocity: 0.02,
            regime,
            confidence: 0.9,
            broadband_share: 1e-9,
            maxima: Vec::new(),
            section: Vec::new(),
            curves: None,
            doubling,
            lines: names.map(line).to_vec(),
            exponents: None,
            recurrence: None,
            recurrence_periods: Default::default(),
            linear: None,
            state: Vec::new(),
            stats: SolverStats::default(),
            portrait: None,
        };
        SweepPoint {
            place: Place {
                index,
                start: Start::Downward,
                values: vec![2.0 + 0.5 * index as f64],
            },
            outcome: Ok(found),
        }
    }

    #[test]
    fn a_doubling_cascade_is_listed_with_its_lines() {
        use Regime::{Chaotic, QuasiPeriodic};
        let points = [
            point(0, QuasiPeriodic, 0),
            point(1, QuasiPeriodic, 1),
            point(2, QuasiPeriodic, 2),
            point(3, Chaotic, 0),
            point(4, QuasiPeriodic, 1),
            point(5, QuasiPeriodic, 0),
        ];
        let found = transitions(&points);
        let doublings: Vec<_> = found.iter().map(|t| t.doubling.as_deref()).collect();
        let expected = [
            Some("doubling of the torus, lines at (f1 + f2)/2"),
            Some("doubling of the torus, lines at (f1 + 3 f2)/4"),
            None,
            None,
            Some("reverse doubling of the torus, lines at (f1 + f2)/2"),
        ];
        assert_eq!(doublings, expected);
        assert_eq!((found[0].from, found[0].to), (2.0, 2.5));
        assert_eq!(found[0].below, "quasi-periodic");
        assert_eq!(found[0].above, "torus, doubled");
        assert_eq!(found[1].above, "torus, doubled twice");
    }
}
