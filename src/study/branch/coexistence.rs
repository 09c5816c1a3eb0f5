//! The bifurcations that end the coexistence of two motions: the causes of hysteresis in a sweep.

use super::equilibria::BranchPlan;
use super::orbits::{OrbitStarts, add_orbits};
use super::result::Branch;
use crate::dynamics::continuation::BifurcationKind;
use crate::study::sweep::{HysteresisEnd, SweepPlan, SweepPoint};
use crate::study::{OnProgress, StudyError};

/// The bifurcations at which a periodic motion that coexists with another one ends or loses its stability: those of the
/// branches through the periodic motions of a sweep over one parameter, within or next to the values at which upward and
/// downward continuation differ. The list is empty for a sweep without such values,
/// and where continuation finds none.
///
/// # Errors
/// If the system cannot be built.
pub fn hysteresis_ends(
    plan: &SweepPlan,
    points: &[SweepPoint],
    differing: &[f64],
    progress: OnProgress<'_>,
) -> Result<Vec<HysteresisEnd>, StudyError> {
    let ([axis], [first, ..], [.., last]) = (&plan.axes[..], differing, differing) else {
        return Ok(Vec::new());
    };
    let (values, parameter) = (&axis.values[..], axis.parameter()?);
    let [from, .., to] = values else {
        return Ok(Vec::new());
    };
    if !parameter.is_continuous() {
        return Ok(Vec::new());
    }
    let branches = BranchPlan::new(plan.subject.clone(), parameter, [*from, *to], 2);
    let mut branch = Branch::new(&branches);
    let starts = OrbitStarts::Settled(points);
    add_orbits(&branches, starts, &mut branch, progress, &mut |_| ())?;
    // The change lies between the last value that differs and the next one.
    let before = values.iter().rfind(|value| *value < first).unwrap_or(from);
    let after = values.iter().find(|value| *value > last).unwrap_or(to);
    let ends = branch.orbit_bifurcations().filter(|found| {
        let bifurcation = &found.bifurcation;
        let changes = bifurcation.kind == BifurcationKind::Fold || bifurcation.unstable_change != 0;
        changes && bifurcation.has_stable_side() && (*before..=*after).contains(&found.at.value)
    });
    let mut ends: Vec<_> = ends
        .map(|found| HysteresisEnd {
            kind: found.bifurcation.kind,
            value: found.at.value,
            frequency_hz: found.bifurcation.frequency_hz,
        })
        .collect();
    ends.sort_by(|a, b| a.value.total_cmp(&b.value));
    Ok(ends)
}
