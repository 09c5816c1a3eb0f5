//! Parameter sweeps: settled responses over one or two parameters, as in Fig. 11 of the paper.

mod plan;
#[cfg(feature = "table")]
mod result;
#[cfg(feature = "table")]
mod table;
#[cfg(all(test, feature = "table"))]
mod table_tests;

#[cfg(test)]
pub(super) mod tests;

use std::collections::HashMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::pool::{Emit, run_jobs};
use super::response::{SettledResponse, response};
use super::subject::Subject;
use super::{OnProgress, StudyError};
use crate::analysis::regime::Regime;
use crate::chain_of_causes;
pub use plan::{Axis, Place, Shard, Start, SweepPlan};
#[cfg(feature = "table")]
pub use result::{HysteresisEnd, RegimeInterval, SweepResult};
#[cfg(feature = "table")]
pub use table::{SweepTable, TableError, TableWriter, read_table, write_table};

/// A point of a sweep and its result.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "table", derive(JsonSchema))]
#[cfg_attr(
    feature = "table",
    schemars(
        with = "table::Row<'static>",
        description = "A point; missing values are null."
    )
)]
pub struct SweepPoint {
    /// Place of the point: index, start and axis values.
    pub place: Place,
    /// Outcome: the response, or the error message if there is none.
    pub outcome: Result<SettledResponse, String>,
}

impl SweepPoint {
    /// The response, if there is one.
    pub fn found(&self) -> Option<&SettledResponse> {
        self.outcome.as_ref().ok()
    }

    /// Name of the regime with its doubling ([`SettledResponse::motion`]), or "no response".
    pub fn regime_name(&self) -> String {
        let found = self.found();
        found.map_or_else(|| "no response".to_owned(), SettledResponse::motion)
    }

    /// Whether the motion still changed when it was measured.
    pub fn is_unsettled(&self) -> bool {
        self.found().is_some_and(|found| !found.settled)
    }
}

/// Computes the response at each point of a shard that is not among the known `points`, on `threads` threads (at
/// least one). Returns all points, the known ones too (also those of other shards), in ascending order of index.
/// After a stop by `progress`, points of the shard are missing.
///
/// The results do not depend on the number of threads, on the shard or on the known points. A failed
/// run is kept as a point with its error message; the next point of its chain starts from the scene's kick.
/// For systems of a caller, times of the plan are in periods of the slowest motion
/// ([`Trial::period`](super::Trial::period)).
///
/// `on_point` takes each point as soon as it is computed, on the thread of the caller; they arrive in any order.
///
/// # Errors
/// [`StudyError::Threads`]; the error of `on_point`, which ends the sweep.
pub fn sweep<S: Subject, E: From<StudyError>>(
    plan: &SweepPlan<S>,
    shard: Shard,
    mut points: Vec<SweepPoint>,
    threads: usize,
    progress: OnProgress<'_>,
    mut on_point: impl FnMut(&SweepPoint) -> Result<(), E>,
) -> Result<Vec<SweepPoint>, E> {
    let (chains, names) = (plan.chains(shard), plan.names());
    let all: usize = chains.iter().map(Vec::len).sum();
    let known = points.iter().map(|point| (point.place.index, point));
    let known: HashMap<usize, &SweepPoint> = known.collect();
    let planned = chains.iter().flatten();
    let mut done = planned.filter(|k| known.contains_key(k)).count();
    let run = |chain: &[usize], emit: Emit<'_, _>| {
        let mut before: Option<SettledResponse> = None;
        for &index in chain {
            if let Some(known) = known.get(&index) {
                before = known.found().cloned();
                continue;
            }
            let place = plan.place(index);
            let mut check = || emit(None);
            let trial = plan.subject.trial(&names, &place.values);
            let found = trial.map_err(StudyError::from).and_then(|trial| {
                let plan = plan.response.scaled(trial.period.unwrap_or(1.0));
                response(trial, before.as_ref(), &plan, &mut check)
            });
            let outcome = match found {
                Err(StudyError::Stopped(_)) => return,
                // A failed run is kept as a point.
                found => found.map_err(|error| chain_of_causes(&error)),
            };
            before = outcome.as_ref().ok().cloned();
            if emit(Some(SweepPoint { place, outcome })).is_err() {
                return;
            }
        }
    };
    let job = |chain: usize, emit: Emit<'_, _>| {
        plan.subject.enter(&mut || run(&chains[chain], emit));
    };
    let mut computed = Vec::new();
    let mut is_stopped = false;
    let ended: Result<(), E> = run_jobs(chains.len(), threads, job, |event| {
        if let Some(point) = event {
            done += 1;
            on_point(&point)?;
            computed.push(point);
        }
        let share = done as f64 / all.max(1) as f64;
        let go_on = progress(share, &format!("{done} of {all} points"));
        is_stopped = go_on.is_err();
        go_on.map_err(|stopped| StudyError::from(stopped).into())
    });
    // A stop is no error: the points so far count.
    if !is_stopped {
        ended?;
    }
    points.extend(computed);
    points.sort_by_key(|point| point.place.index);
    Ok(points)
}

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
    let (below, above) = (below.found()?, above.found()?);
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
mod transition_tests {
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
            transient_s: 0.1,
            settled: true,
            amplitude_m: 7e-7,
            mean_m: 0.0,
            rms_velocity_m_per_s: 0.01,
            peak_velocity_m_per_s: 0.02,
            regime,
            confidence: 0.9,
            broadband_share: 1e-9,
            maxima_m: Vec::new(),
            section_m: Vec::new(),
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
                named: Default::default(),
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
