//! Branches of periodic orbits of a scene: from a settled motion, from Hopf points, and at period doublings.

use super::diagram::settled_responses;
use super::equilibria::{
    BranchPlan, CriticalityMethod, SteadyBifurcation, SteadyBifurcationKind, add_equilibria,
};
use super::family::SubjectFamily;
use super::result::{At, Branch, BranchBifurcation};
use crate::analysis::regime::Regime;
use crate::chain_of_causes;
use crate::dynamics::continuation::{
    BifurcationKind, BranchEnd, BranchStart, ContinuationOptions, Criticality, OrbitBranch,
    PeriodicOrbit, ReturnSearch, continue_orbits, doubled_orbit, hopf_orbit, settled_orbit,
};
use crate::dynamics::equilibrium::{Eigenmode, EquilibriumError};
use crate::scene::Scene;
use crate::study::response::{ResponsePlan, SLOWEST, SettledResponse, response};
use crate::study::sweep::SweepPoint;
#[cfg(feature = "table")]
use crate::study::sweep::{HysteresisEnd, SweepPlan};
use crate::study::{OnProgress, StudyError, Trial};

/// Amplitude of the first orbit at a Hopf point relative to that at which the motion is no longer small.
const HOPF_SHARE: f64 = 0.02;
/// Distance of the first orbit from a period doubling, relative to the size of the orbit.
const SWITCH: f64 = 0.02;
/// Largest period of a motion that is sought, in periods of its strongest line.
const MAX_RETURN: f64 = 40.0;
/// Distance from its start below which a settled motion has returned, relative to its size.
const RETURN: f64 = 0.02;
/// Time for which a driven motion settles, and largest period that is sought, in periods of the drive.
const DRIVES: [f64; 2] = [400.0, 16.0];
/// Relative distance of the parameters of two orbits at which they can be the same.
const SAME: f64 = 1e-2;
/// Relative distances of frequency and amplitude within which an orbit lies on a branch between two of its points.
const ON_BRANCH: [f64; 2] = [5e-4, 0.05];

/// Where branches of periodic orbits start, besides Hopf points and period doublings.
#[derive(Clone, Copy, Debug)]
pub enum OrbitStarts<'a> {
    /// The settled motion at the value of the scene, or at another value at which it is periodic.
    Scene,
    /// The settled motion at this value of the parameter.
    At(f64),
    /// Each periodic motion among these points of a sweep over the parameter that is on no branch yet.
    Settled(&'a [SweepPoint]),
    /// The same of a sweep over the tilt of this scene, which is computed first on a number of threads.
    Sweep(&'a Scene, usize),
}

/// A study of periodic orbits.
struct Study<'a> {
    plan: &'a BranchPlan,
    family: SubjectFamily,
    options: ContinuationOptions,
    progress: OnProgress<'a>,
    /// Receives the result after the sweep and after each branch.
    on_part: &'a mut dyn FnMut(&Branch),
    result: &'a mut Branch,
}

impl BranchPlan {
    /// The equilibria and, from `starts` on, the periodic orbits. If `progress` stops the study, the rest is missing. A system
    /// driven in time has no equilibria, but periodic orbits. `on_part` receives the result so far.
    ///
    /// # Errors
    /// If the start is outside the interval; if the system cannot be built, or has no equilibrium at the start of the interval.
    pub fn follow(
        &self,
        starts: Option<OrbitStarts<'_>>,
        progress: OnProgress<'_>,
        on_part: &mut dyn FnMut(&Branch),
    ) -> Result<Branch, StudyError> {
        if let Some(OrbitStarts::At(value)) = starts {
            self.check_start(value)?;
        }
        let mut result = Branch::new(self);
        let steady = add_equilibria(self, &mut result, &mut |share, task| {
            progress(0.1 * share, task)
        });
        match steady {
            Err(StudyError::Equilibrium(EquilibriumError::Driven)) if starts.is_some() => {}
            steady => steady?,
        }
        // What a stop leaves is no part.
        if let Some(starts) = starts
            && progress(0.1, "periodic motions").is_ok()
        {
            on_part(&result);
            let progress = &mut |share: f64, task: &str| progress(0.1 + 0.9 * share, task);
            add_orbits(self, starts, &mut result, progress, on_part)?;
        }
        Ok(result)
    }
}

/// Adds the branches of periodic orbits to a result that has the equilibria: those of `starts`, those born at the Hopf
/// points, and those of the first period doublings. If `progress` stops the study, the rest is missing. `on_part` receives the
/// result after the sweep and after each branch.
///
/// # Errors
/// If the system cannot be built. Branches that cannot be followed are reported in the result.
pub(super) fn add_orbits(
    plan: &BranchPlan,
    starts: OrbitStarts<'_>,
    result: &mut Branch,
    progress: OnProgress<'_>,
    on_part: &mut dyn FnMut(&Branch),
) -> Result<(), StudyError> {
    let family = plan.family();
    let mut study = Study {
        plan,
        options: family.options(plan.interval)?,
        family,
        progress,
        on_part,
        result,
    };
    match study.add(starts) {
        Err(StudyError::Stopped(_)) => Ok(()),
        ended => ended,
    }
}

impl Study<'_> {
    fn add(&mut self, starts: OrbitStarts<'_>) -> Result<(), StudyError> {
        match starts {
            OrbitStarts::Scene => self.add_first(&self.values())?,
            OrbitStarts::At(value) => self.add_first(&[value])?,
            OrbitStarts::Settled(points) => self.add_settled(points)?,
            OrbitStarts::Sweep(scene, threads) => {
                let progress = &mut *self.progress;
                let interval = self.plan.interval;
                let settled = settled_responses(scene, interval, threads, &mut |share, task| {
                    progress(0.8 * share, task)
                })?;
                self.result.settled.clone_from(&settled);
                progress(0.8, "periodic motions")?;
                (self.on_part)(self.result);
                self.add_settled(&settled)?;
            }
        }
        self.add_hopf_branches()?;
        self.add_doublings()
    }

    /// The branch through the first of the settled motions at some values that is periodic and attracts, or else through the
    /// first orbit found: a chaotic motion of a driven system also returns, next to an orbit that repels.
    fn add_first(&mut self, values: &[f64]) -> Result<(), StudyError> {
        let mut reasons: Vec<String> = Vec::new();
        let mut repelling = None;
        for &value in values {
            match self.settled(value) {
                Ok(orbit) if orbit.stable => return self.follow(&orbit.into()),
                Ok(orbit) => repelling = repelling.or(Some(orbit)),
                Err(StudyError::NoOrbit(reason)) => reasons.push(reason),
                Err(error) => return Err(error),
            }
        }
        match repelling {
            Some(orbit) => self.follow(&orbit.into()),
            None => {
                let reasons = reasons.join("; ");
                let reason = format!("no periodic motion to start from: {reasons}");
                self.result.ended.push(reason);
                Ok(())
            }
        }
    }

    /// The branches through the periodic motions of a sweep.
    fn add_settled(&mut self, points: &[SweepPoint]) -> Result<(), StudyError> {
        let [low, high] = self.plan.interval;
        for point in points {
            let (Ok(found), [value]) = (&point.outcome, &point.place.values[..]) else {
                continue;
            };
            if found.regime != Regime::Periodic || !(low..=high).contains(value) {
                continue;
            }
            match self.orbit(*value, found) {
                Ok(orbit) => self.follow(&orbit.into())?,
                Err(error) => self.result.ended.push(error.to_string()),
            }
        }
        Ok(())
    }

    /// Values of the parameter at which a settled motion is tried.
    fn values(&self) -> Vec<f64> {
        let [from, to] = self.plan.interval;
        let own = self.plan.own.filter(|value| (from..=to).contains(value));
        let shares = [0.5, 0.25, 0.75, 0.05, 0.95].map(|share| from + share * (to - from));
        own.into_iter().chain(shares).collect()
    }

    /// The orbit of the settled motion at a value.
    fn settled(&mut self, value: f64) -> Result<PeriodicOrbit, StudyError> {
        let name = self.plan.name();
        let task = format!("settling at {name} = {value}");
        (self.progress)(0.0, &task)?;
        // The linear modes of its scene are not needed, and their error would be no reason against an orbit.
        let trial = Trial {
            scene: None,
            ..self.family.trial(&[value])?
        };
        let plan = ResponsePlan {
            min_transient_s: 0.02,
            measurement_s: 0.05,
            exponents: 0,
            ..ResponsePlan::default()
        }
        .scaled(trial.period.map_or(1.0, |period| period / SLOWEST));
        let is_driven = trial.drive_period.is_some();
        let progress = &mut *self.progress;
        let found = response(trial, None, &plan, &mut || progress(0.0, &task));
        let found = found.map_err(|error| match error {
            StudyError::Stopped(_) => error,
            error => no_orbit(name, value, &error),
        })?;
        // Whether a driven motion repeats is seen at the period of the drive.
        if found.regime != Regime::Periodic && !is_driven {
            let kind = found.motion();
            let reason = format!("at {name} = {value} the settled motion is {kind}");
            return Err(StudyError::NoOrbit(reason));
        }
        self.orbit(value, &found)
    }

    /// The orbit of a settled response at a value.
    fn orbit(&self, value: f64, found: &SettledResponse) -> Result<PeriodicOrbit, StudyError> {
        let [settle_s, max_period_s] = match self.family.trial(&[value])?.drive_period {
            // The response ended at another phase of the drive than that at time zero, where the search begins.
            Some(drive) => DRIVES.map(|count| count * drive),
            None => {
                let line = found.lines.first().map_or(1e3, |line| line.frequency);
                [0.0, MAX_RETURN / line]
            }
        };
        let search = ReturnSearch {
            settle_s,
            max_period_s,
            tolerance: RETURN,
        };
        let orbit = settled_orbit(&self.family, value, &found.state, &search, &self.options);
        orbit.map_err(|error| no_orbit(self.plan.name(), value, &error))
    }

    /// The branches born at the Hopf points that no branch has reached.
    fn add_hopf_branches(&mut self) -> Result<(), StudyError> {
        for k in 0..self.result.bifurcations.len() {
            if let BranchBifurcation::Steady(found) = &self.result.bifurcations[k]
                && found.kind == SteadyBifurcationKind::Hopf
                && !self.is_known(found)
            {
                let mut found = found.clone();
                let start = self.born(&found);
                if let Ok(start) = &start {
                    fit_birth(&mut found, &start.orbit);
                }
                let at = found.at.clone();
                self.result.bifurcations[k] = BranchBifurcation::Steady(found);
                self.follow_from("Hopf point", &at, start)?;
            }
        }
        Ok(())
    }

    /// The branch from a bifurcation, if there is one.
    fn follow_from(
        &mut self,
        kind: &str,
        at: &At,
        start: Result<BranchStart, StudyError>,
    ) -> Result<(), StudyError> {
        match start {
            Ok(start) => self.follow(&start),
            Err(StudyError::NoOrbit(reason)) => {
                let At { name, value } = at;
                let reason = format!("no branch from the {kind} at {name} = {value}: {reason}");
                self.result.ended.push(reason);
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    /// Whether a branch has an orbit of small amplitude next to a Hopf point.
    fn is_known(&self, found: &SteadyBifurcation) -> bool {
        let width = self.plan.interval[1] - self.plan.interval[0];
        let amplitudes = self.result.points.iter().map(|point| point.orbit.amplitude);
        let largest = amplitudes.fold(0.0, f64::max);
        self.result.points.iter().any(|point| {
            let near = (point.at.value - found.at.value).abs() < SAME * width;
            let alike = (point.orbit.frequency_hz() / found.frequency_hz - 1.0).abs() < SAME;
            near && alike && point.orbit.amplitude < 0.1 * largest
        })
    }

    /// The first orbit of the branch born at a Hopf point.
    fn born(&mut self, found: &SteadyBifurcation) -> Result<BranchStart, StudyError> {
        let value = found.at.value;
        let state = self.family.at(&[value])?;
        let linearised = &state.linearised;
        let omega = std::f64::consts::TAU * found.frequency_hz;
        let modes = linearised.modes()?;
        let apart = |mode: &Eigenmode| (mode.value - faer::c64::new(0.0, omega)).norm();
        let mode = modes.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let mode = mode.ok_or_else(|| StudyError::NoOrbit("the mode is lost".to_owned()))?;
        let size = self.plan.subject.hopf_size(omega, &linearised.state);
        let point = (value, linearised, mode);
        hopf_orbit(&self.family, point, HOPF_SHARE * size, &self.options)
            .map_err(|error| StudyError::NoOrbit(chain_of_causes(&error)))
    }

    /// The branches of twice the period at the period doublings found so far.
    fn add_doublings(&mut self) -> Result<(), StudyError> {
        let doublings: Vec<_> = self
            .result
            .orbit_bifurcations()
            .filter(|found| found.bifurcation.kind == BifurcationKind::PeriodDoubling)
            .cloned()
            .collect();
        for found in doublings {
            let start = doubled_orbit(&self.family, &found.bifurcation, SWITCH, &self.options)
                .map_err(|error| StudyError::NoOrbit(chain_of_causes(&error)));
            self.follow_from("period doubling", &found.at, start)?;
        }
        Ok(())
    }

    /// Follows a branch and adds it to the result, with the reasons of its ends, unless its start lies on another branch.
    fn follow(&mut self, start: &BranchStart) -> Result<(), StudyError> {
        if has_orbit(self.result, &start.orbit) {
            return Ok(());
        }
        let branch = self.result.orbit_branches();
        let name = self.plan.name();
        let [from, to] = self.plan.interval;
        let progress = &mut *self.progress;
        let mut orbits = 0;
        let followed = continue_orbits(&self.family, start, &self.options, &mut |orbit| {
            orbits += 1;
            let value = orbit.parameter;
            let task = format!("branch {branch}: {orbits} orbits, {name} = {value:.4}");
            progress((value - from) / (to - from), &task)
        });
        match followed {
            Ok(orbits) => {
                let complete = orbits.complete();
                self.result.ended.extend(ends(&orbits, branch, name));
                self.result.ended.extend(orbits.unresolved.iter().map(|[from, to]| {
                    format!(
                        "branch {branch} changes the number of its unstable multipliers between {name} = {from:.6} and \
                         {to:.6} without an identified bifurcation"
                    )
                }));
                self.result.add_orbits(orbits);
                complete?;
                (self.on_part)(self.result);
                progress(1.0, "periodic motions")?;
            }
            Err(error) => self.result.ended.push(chain_of_causes(&error)),
        }
        Ok(())
    }
}

/// The bifurcations at which a periodic motion that coexists with another one ends or loses its stability: those of the
/// branches through the periodic motions of a sweep over one parameter, within or next to the values at which upward and
/// downward continuation differ. The list is empty for a sweep without such values,
/// and where continuation finds none.
///
/// # Errors
/// [`StudyError::Stopped`]; if the system cannot be built.
#[cfg(feature = "table")]
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
    // A stop ends the branches early, without an error.
    progress(1.0, "ends of the hysteresis")?;
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

/// The error of a start at a value that leads to no orbit.
fn no_orbit(name: &str, value: f64, error: &dyn std::error::Error) -> StudyError {
    StudyError::NoOrbit(format!("at {name} = {value}: {}", chain_of_causes(error)))
}

/// Whether an orbit lies on a branch of a result, between two neighbouring points.
fn has_orbit(result: &Branch, orbit: &PeriodicOrbit) -> bool {
    result.points.windows(2).any(|pair| {
        let [a, b] = [&pair[0], &pair[1]];
        let share = (orbit.parameter - a.at.value) / (b.at.value - a.at.value);
        if a.branch != b.branch || !(0.0..=1.0).contains(&share) {
            return false;
        }
        let is_alike = |of: fn(&PeriodicOrbit) -> f64, tolerance: f64| {
            let between = of(&a.orbit) + share * (of(&b.orbit) - of(&a.orbit));
            (of(orbit) / between - 1.0).abs() <= tolerance
        };
        is_alike(PeriodicOrbit::frequency_hz, ON_BRANCH[0])
            && is_alike(|orbit| orbit.amplitude, ON_BRANCH[1])
    })
}

/// Decides from the first orbit of the branch how the cycle of a Hopf point is born, where the normal form does not: it
/// has no significant sign, or does not hold up to the amplitude of this orbit.
fn fit_birth(found: &mut SteadyBifurcation, orbit: &PeriodicOrbit) {
    let (Some(cycle), Some(speed)) = (&mut found.cycle, found.crossing_speed) else {
        return;
    };
    let beyond_kinks = cycle
        .smooth_amplitude_m
        .is_some_and(|amplitude| amplitude < orbit.amplitude);
    let offset = orbit.parameter - found.at.value;
    if (cycle.criticality == Criticality::Undetermined || beyond_kinks)
        && offset.abs() > found.location_error
    {
        cycle.method = CriticalityMethod::FittedBranch;
        // The growth rate of steady sliding where the cycle exists.
        cycle.criticality = if offset * speed > 0.0 {
            Criticality::Supercritical
        } else {
            Criticality::Subcritical
        };
    }
}

/// Why a branch ends inside the interval.
fn ends(orbits: &OrbitBranch, branch: usize, name: &str) -> Vec<String> {
    let places = [orbits.points.first(), orbits.points.last()];
    let ends = orbits.ends.iter().zip(places);
    let reasons = ends.filter_map(|(end, place)| {
        let at = place.map_or(f64::NAN, |orbit| orbit.parameter);
        let why = match end.as_ref()? {
            BranchEnd::ParameterBound => return None,
            BranchEnd::Closed => "it returned to its start".to_owned(),
            BranchEnd::NotConverged { message } => message.clone(),
            BranchEnd::Grazing { guard, .. } => match guard {
                Some(guard) => format!("guard {guard} is grazed"),
                None => "the sequence of events changes".to_owned(),
            },
            BranchEnd::Hopf {
                parameter,
                frequency_hz,
            } => {
                format!("it was born in a Hopf bifurcation at {parameter:.6}, {frequency_hz:.2} Hz")
            }
            BranchEnd::PeriodHalved { .. } => "it joins the branch of half its period".to_owned(),
            BranchEnd::MaxPoints => "the maximum number of points was reached".to_owned(),
            BranchEnd::Stopped => "interrupted".to_owned(),
        };
        Some(format!("branch {branch} ends at {name} = {at:.6}: {why}"))
    });
    reasons.collect()
}
