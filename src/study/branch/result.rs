//! The result of a study of branches over one parameter, and the reports of branches and of stability maps.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::equilibria::{BranchPlan, EquilibriumPoint, SteadyBifurcation};
use super::map::{Curve, CurvePoint, StabilityMap};
use super::tori::Torus;
use crate::analysis::stats::range;
use crate::dynamics::continuation::{Bifurcation, Criticality, OrbitBranch, PeriodicOrbit};
use crate::number::{counted, error, fixed, quantity, short, with_error};
use crate::report::{Block, Report, Table};
use crate::study::sweep::SweepPoint;

/// Branches over a parameter: equilibria, periodic orbits, and their bifurcations.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
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

impl Branch {
    /// The result of a plan, still empty.
    pub fn new(plan: &BranchPlan) -> Self {
        Self {
            parameter: plan.parameter.clone(),
            unit: plan.unit.clone(),
            interval: plan.interval,
            ..Self::default()
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

impl Report for Branch {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let [from, to] = self.interval;
        let (parameter, unit) = (&self.parameter, unit(&self.unit));
        let rest = format!(": {parameter} from {from} to {to}{unit}");
        let mut blocks = vec![Block::heading(scene, rest)];
        for ([low, high], count) in self.unstable_intervals() {
            let [low, high] = [low, high].map(short);
            blocks.push(Block::text(format!(
                "steady sliding with {} from {low} to {high}",
                counted(count, "unstable mode")
            )));
        }
        let bifurcations: Vec<_> = self.steady_bifurcations().collect();
        if !bifurcations.is_empty() {
            blocks.push(Block::heading("bifurcations of the equilibria", ""));
            blocks.push(steady_table(self, &bifurcations));
        }
        let steady = bifurcations.iter();
        blocks.extend(steady.filter_map(|found| normal_form(found, &self.unit)));
        if !self.points.is_empty() {
            blocks.push(Block::heading("periodic orbits", ""));
            blocks.push(orbit_table(self));
        }
        let found: Vec<_> = self.orbit_bifurcations().collect();
        if !found.is_empty() {
            blocks.push(Block::heading("their bifurcations", ""));
            blocks.push(bifurcation_table(self, &found));
        }
        blocks.extend(self.tori.iter().flat_map(|torus| self::torus(self, torus)));
        blocks.extend(self.ended.iter().cloned().map(Block::Warning));
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted
    }
}

/// The bifurcations of the equilibria, one per row.
fn steady_table(branch: &Branch, found: &[&SteadyBifurcation]) -> Block {
    let per_unit = match &branch.unit[..] {
        "" => "crossing speed, 1/s".to_owned(),
        unit => format!("crossing speed, 1/s per {unit}"),
    };
    Table::of(found)
        .right(branch.name(), |found| fixed(found.at.value, 9))
        .left("bifurcation", |found| found.kind.to_string())
        .right("frequency, Hz", |found| fixed(found.frequency_hz, 3))
        .left("mode", |found| found.label.clone())
        .right(per_unit, |found| fixed(found.crossing_speed, 4))
        .right("first Lyapunov coefficient ± numerical error", |found| {
            let cycle = found.cycle.as_ref();
            cycle.map(|cycle| with_error(cycle.first_lyapunov, cycle.first_lyapunov_error))
        })
        .left("cycle", |found| {
            let cycle = found.cycle.as_ref();
            cycle.map(|cycle| format!("{}, by the {}", cycle.criticality, cycle.method))
        })
        .into()
}

/// The smallest and the largest of some values.
fn span(values: impl Iterator<Item = f64>, decimals: usize) -> String {
    let [low, high] = range(values);
    format!("{low:.decimals$} to {high:.decimals$}")
}

/// The branches of periodic orbits, one per row.
fn orbit_table(branch: &Branch) -> Block {
    let branches = branch.points.chunk_by(|a, b| a.branch == b.branch);
    let spans = |of: fn(&PeriodicOrbit) -> f64, decimals| {
        move |orbits: &&[OrbitPoint]| span(orbits.iter().map(|it| of(&it.orbit)), decimals)
    };
    Table::of(branches)
        .right("branch", |orbits| orbits[0].branch.to_string())
        .right("orbits", |orbits| orbits.len().to_string())
        .right(branch.name(), spans(|orbit| orbit.parameter, 4))
        .right("frequency, Hz", spans(PeriodicOrbit::frequency_hz, 2))
        .right("amplitude, µm", spans(|orbit| 1e6 * orbit.amplitude, 4))
        .left("attracting at", |orbits| {
            stable_intervals(&branch.course(orbits[0].branch))
        })
        .into()
}

/// Parts of a branch whose orbits attract, in its order. They begin and end at bifurcations.
fn stable_intervals(course: &[(&PeriodicOrbit, bool)]) -> String {
    let points = course.iter();
    let points = points.map(|(orbit, stable)| Some(([orbit.parameter, 0.0], *stable)));
    let [_, parts] = by_stability(points);
    let parts = parts.iter().map(|part| {
        let [from, to] = [part[0], part[part.len() - 1]].map(|at| at[0]);
        format!("{from:.4} to {to:.4}")
    });
    let parts = parts.collect::<Vec<_>>().join(", ");
    if parts.is_empty() {
        "-".to_owned()
    } else {
        parts
    }
}

/// The bifurcations of the periodic orbits, one per row.
fn bifurcation_table(branch: &Branch, found: &[&OrbitBifurcation]) -> Block {
    Table::of(found.iter().map(|found| (*found, &found.bifurcation)))
        .right("branch", |(found, _)| found.branch.to_string())
        .right(branch.name(), |(found, _)| fixed(found.at.value, 7))
        .right("± numerical error", |(_, it)| error(it.accuracy))
        .left("bifurcation", |(found, _)| found.name())
        .right("frequency, Hz", |(_, it)| fixed(it.frequency_hz, 3))
        .right("rotation number", |(_, it)| fixed(it.rotation_number, 6))
        .right("second frequency, Hz", |(_, it)| {
            fixed(it.torus_frequency_hz, 3)
        })
        .right("unstable", |(_, it)| format!("{:+}", it.unstable_change))
        .left("motion born there, by the normal form", |(_, it)| {
            it.birth.map(|birth| {
                let coefficient = with_error(birth.coefficient, birth.coefficient_error);
                format!("{} ({coefficient})", birth.criticality)
            })
        })
        .into()
}

/// A torus from its birth on, one row per value, and its tongues.
fn torus(branch: &Branch, torus: &Torus) -> Vec<Block> {
    let table = Table::of(&torus.points)
        .right(branch.name(), |point| fixed(point.at.value, 6))
        .left("motion", |point| match point.locking {
            Some([p, q]) => format!("{} {p}:{q}", point.kind),
            None => point.kind.to_string(),
        })
        .right("first tone, Hz", |point| fixed(point.first_hz, 4))
        .right("second tone, Hz", |point| fixed(point.second_hz, 4))
        .right("side line", |point| format!("{:.2e}", point.side_line))
        .right("rotation number", |point| fixed(point.rotation_number, 8))
        .right("± numerical error", |point| {
            point.rotation_number_error.map(error)
        });
    let title = format!("torus of branch {}", torus.branch);
    let mut blocks = vec![
        Block::heading(title, format!(", born at {:.7}", torus.born)),
        table.into(),
    ];
    for tongue in &torus.tongues {
        let [p, q] = tongue.locking;
        let [low, high] = tongue
            .borders
            .map(|border| border.map_or_else(|| "?".to_owned(), |border| format!("{border:.7}")));
        blocks.push(Block::text(format!(
            "phase-locked {p}:{q} from {low} to {high}"
        )));
    }
    let ended = torus.ended.iter();
    blocks.extend(ended.map(|reason| Block::Warning(format!("ended: {reason}"))));
    blocks
}

/// The range of the normal form of a Hopf point with kinks, as a sentence.
fn normal_form(found: &SteadyBifurcation, unit: &str) -> Option<Block> {
    let cycle = found.cycle.as_ref()?;
    let (amplitude, range) = (cycle.smooth_amplitude_m?, cycle.smooth_range?);
    let holds = match cycle.criticality {
        Criticality::Undetermined => "kinks begin",
        _ => "the normal form holds",
    };
    Some(Block::text(format!(
        "{:.0} Hz: {holds} up to an amplitude of {} ({:.1e}{} from the Hopf point), where the law has its first kink",
        found.frequency_hz,
        quantity(amplitude, 3, "m"),
        range,
        self::unit(unit),
    )))
}

/// A unit after a number.
fn unit(unit: &str) -> String {
    match unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    }
}

/// How a curve over two parameters ends.
fn curve_end(curve: &Curve) -> String {
    match &curve.ended[..] {
        _ if curve.closed => "closed".to_owned(),
        [] => "at the borders".to_owned(),
        reasons => reasons.join("; "),
    }
}

impl Report for StabilityMap {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let map = self;
        let [x, y] = &map.axes;
        let [columns, rows] = [x, y].map(|axis| axis.values.len());
        let [over, and] = [x, y].map(|axis| &axis.parameter);
        let rest = format!(": stability over {over} and {and}, {columns} x {rows} points");
        let counts = || map.grid.iter().map(|point| point.unstable_modes);
        let most = counts().flatten().max().unwrap_or(0);
        let kinds = (0..=most).map(Some).chain([None]);
        let numbers = kinds.map(|kind| (kind, counts().filter(|count| *count == kind).count()));
        let shares = Table::of(numbers.filter(|(_, number)| *number > 0))
            .right("unstable modes", |(kind, _)| match kind {
                Some(count) => count.to_string(),
                None => "no equilibrium".to_owned(),
            })
            .right("share of the map", |(_, number)| {
                format!("{:.1} %", 100.0 * *number as f64 / map.grid.len() as f64)
            });
        let mut blocks = vec![Block::heading(scene, rest), shares.into()];
        let spans = |of: fn(&CurvePoint) -> f64, decimals| {
            move |curve: &&Curve| span(curve.points.iter().map(of), decimals)
        };
        if !map.curves.is_empty() {
            let curves = Table::of(&map.curves)
                .left("Hopf curve", |curve| curve.label.clone())
                .right("points", |curve| curve.points.len().to_string())
                .right("frequency, Hz", spans(|point| point.frequency_hz, 1))
                .left("end", |curve| curve_end(curve));
            blocks.push(curves.into());
        }
        if !map.torus_curves.is_empty() {
            let second = spans(|point| point.second_hz.unwrap_or(f64::NAN), 1);
            let curves = Table::of(&map.torus_curves)
                .left(
                    "Neimark-Sacker curve of",
                    |_| "the periodic motion of the scene",
                )
                .right("points", |curve| curve.points.len().to_string())
                .right(&x.parameter, spans(|point| point.values[0], 4))
                .right(&y.parameter, spans(|point| point.values[1], 4))
                .right("second frequency, Hz", second)
                .left("end", |curve| curve_end(curve));
            blocks.push(curves.into());
        }
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted
    }
}
