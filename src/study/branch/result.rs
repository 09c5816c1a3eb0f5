//! The result of a study of branches over one parameter.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::equilibria::{BranchPlan, EquilibriumPoint};
use super::hopf::SteadyBifurcation;
use super::tori::Torus;
use crate::dynamics::continuation::{Bifurcation, OrbitBranch, PeriodicOrbit};
use crate::study::sweep::SweepPoint;

/// Branches over a parameter: equilibria, periodic orbits, and their bifurcations.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Branch {
    /// Path of the parameter in the scene file.
    pub parameter: String,
    /// Unit of the parameter; empty for a dimensionless number.
    pub unit: String,
    /// Ends of the interval, in this unit.
    pub interval: [f64; 2],
    /// The equilibria, in ascending order of the parameter.
    pub equilibria: Vec<EquilibriumPoint>,
    /// The periodic orbits, in their order along each branch.
    pub points: Vec<OrbitPoint>,
    /// The bifurcations of the equilibria, then those of the periodic orbits along each branch.
    pub bifurcations: Vec<BranchBifurcation>,
    /// The points of a sweep over the same parameter, beside which branches are shown.
    #[serde(skip)]
    pub settled: Vec<SweepPoint>,
    /// The tori that are born at Neimark-Sacker points, if they were followed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tori: Vec<Torus>,
    /// Why branches end inside the interval, one sentence each.
    pub ended: Vec<String>,
    /// Whether the study was interrupted.
    pub interrupted: bool,
}

/// A periodic orbit on a branch.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct OrbitPoint {
    /// Number of the branch, from 0.
    pub branch: usize,
    /// The orbit.
    #[serde(flatten)]
    pub orbit: PeriodicOrbit,
    /// Value of the parameter.
    #[serde(flatten)]
    pub at: At,
}

/// A bifurcation of a periodic orbit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct OrbitBifurcation {
    /// Number of the branch, from 0.
    pub branch: usize,
    /// The bifurcation.
    #[serde(flatten)]
    pub bifurcation: Bifurcation,
    /// Value of the parameter.
    #[serde(flatten)]
    pub at: At,
}

impl OrbitBifurcation {
    /// Name of the bifurcation, with its strong resonance if there is one.
    pub fn name(&self) -> String {
        let kind = self.bifurcation.kind;
        match self.bifurcation.resonance {
            Some(resonance) => format!("{kind}, {resonance} resonance"),
            None => kind.to_string(),
        }
    }
}

/// A bifurcation of an equilibrium or of a periodic orbit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[allow(
    clippy::large_enum_variant,
    reason = "a study has few bifurcations: their size does not matter"
)]
pub enum BranchBifurcation {
    /// Of a periodic orbit.
    Orbit(OrbitBifurcation),
    /// Of an equilibrium.
    Steady(SteadyBifurcation),
}

impl BranchBifurcation {
    /// Value of the parameter.
    pub fn value(&self) -> f64 {
        match self {
            Self::Orbit(orbit) => orbit.at.value,
            Self::Steady(steady) => steady.at.value,
        }
    }
}

impl Branch {
    /// The result of a plan, still empty.
    pub fn new(plan: &BranchPlan) -> Self {
        Self {
            parameter: plan.parameter.clone(),
            unit: plan.unit.clone(),
            interval: plan.interval,
            equilibria: Vec::new(),
            points: Vec::new(),
            bifurcations: Vec::new(),
            settled: Vec::new(),
            tori: Vec::new(),
            ended: Vec::new(),
            interrupted: false,
        }
    }

    /// Number of branches of periodic orbits.
    pub fn orbit_branches(&self) -> usize {
        self.points.last().map_or(0, |point| point.branch + 1)
    }

    /// Adds a branch of periodic orbits.
    pub fn add_orbits(&mut self, orbits: OrbitBranch) {
        let branch = self.orbit_branches();
        let name = self.name().to_owned();
        let at = |value: f64| At::new(&name, value);
        let points = orbits.points.into_iter().map(|orbit| OrbitPoint {
            branch,
            at: at(orbit.parameter),
            orbit,
        });
        self.points.extend(points);
        let bifurcations = orbits.bifurcations.into_iter().map(|bifurcation| {
            BranchBifurcation::Orbit(OrbitBifurcation {
                branch,
                at: at(bifurcation.parameter),
                bifurcation,
            })
        });
        self.bifurcations.extend(bifurcations);
    }

    /// The orbits of a branch in their order, each with whether it attracts. Where the stability changes between two
    /// orbits, that of the bifurcation between them is added, with the stability of the one before it.
    pub fn course(&self, number: usize) -> Vec<(&PeriodicOrbit, bool)> {
        let mut course: Vec<(&PeriodicOrbit, bool)> = Vec::new();
        for point in self.points.iter().filter(|point| point.branch == number) {
            if let Some(&(before, stable)) = course.last()
                && stable != point.orbit.stable
            {
                let ends = [before.parameter, point.orbit.parameter];
                let between = self.orbit_bifurcations().find(|found| {
                    let value = found.at.value;
                    let is_inside = (ends[0] - value) * (ends[1] - value) <= 0.0;
                    found.branch == number && found.bifurcation.unstable_change != 0 && is_inside
                });
                course.extend(between.map(|found| (&found.bifurcation.orbit, stable)));
            }
            course.push((&point.orbit, point.orbit.stable));
        }
        course
    }

    /// The intervals of the parameter with a constant number of unstable modes of the equilibrium, in ascending order.
    /// Neighbouring intervals meet at the bifurcation between their points, or half-way if none was located there.
    pub fn unstable_intervals(&self) -> Vec<([f64; 2], usize)> {
        let mut intervals: Vec<([f64; 2], usize)> = Vec::new();
        for point in &self.equilibria {
            let (value, count) = (point.at.value, point.unstable_modes);
            match intervals.last_mut() {
                Some(([_, end], last)) if *last == count => *end = value,
                Some(([_, end], _)) => {
                    let mut found = self.steady_bifurcations().map(|found| found.at.value);
                    let border = found
                        .find(|at| (*end..=value).contains(at))
                        .unwrap_or(0.5 * (*end + value));
                    *end = border;
                    intervals.push(([border, value], count));
                }
                None => intervals.push(([value; 2], count)),
            }
        }
        intervals
    }

    /// Whether the equilibria on one side of a value of the parameter, or next to it, have no unstable mode.
    pub fn slides_stably_beside(&self, value: f64) -> bool {
        let mut intervals = self.unstable_intervals().into_iter();
        intervals.any(|([from, to], count)| count == 0 && (from..=to).contains(&value))
    }

    /// The bifurcations of the equilibria.
    pub fn steady_bifurcations(&self) -> impl Iterator<Item = &SteadyBifurcation> {
        self.bifurcations.iter().filter_map(|found| match found {
            BranchBifurcation::Steady(steady) => Some(steady),
            BranchBifurcation::Orbit(_) => None,
        })
    }

    /// The bifurcations of the periodic orbits.
    pub fn orbit_bifurcations(&self) -> impl Iterator<Item = &OrbitBifurcation> {
        self.bifurcations.iter().filter_map(|found| match found {
            BranchBifurcation::Orbit(orbit) => Some(orbit),
            BranchBifurcation::Steady(_) => None,
        })
    }

    /// Name of the key without its table, such as `tilt_deg`.
    pub fn name(&self) -> &str {
        name_of(&self.parameter)
    }
}

/// The unstable and the stable parts of a line, which is interrupted at `None`. Neighbouring parts share a point.
pub fn by_stability(
    points: impl IntoIterator<Item = Option<([f64; 2], bool)>>,
) -> [Vec<Vec<[f64; 2]>>; 2] {
    let mut parts = [Vec::<Vec<_>>::new(), Vec::new()];
    let mut last = None;
    for point in points {
        if let Some((at, stable)) = point {
            let strips = &mut parts[usize::from(stable)];
            match (last, strips.last_mut()) {
                (Some((_, before)), Some(strip)) if before == stable => strip.push(at),
                (before, _) => {
                    let before = before.map(|(before, _)| before);
                    strips.push(before.into_iter().chain([at]).collect());
                }
            }
        }
        last = point;
    }
    parts
}

/// Name of the key with a path.
pub(super) fn name_of(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

/// The value of a parameter at a point, in the unit of the scene file. In JSON it is a field with the name of the key, such as
/// `tilt_deg`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(into = "BTreeMap<String, f64>")]
pub struct At {
    /// Name of the key, such as `tilt_deg`.
    pub name: String,
    /// Value in the unit of the scene file.
    pub value: f64,
}

impl At {
    /// A value of the key with a name.
    pub fn new(name: &str, value: f64) -> Self {
        let name = name.to_owned();
        Self { name, value }
    }
}

impl From<At> for BTreeMap<String, f64> {
    fn from(at: At) -> Self {
        Self::from([(at.name, at.value)])
    }
}
