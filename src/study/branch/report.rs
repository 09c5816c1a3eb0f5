//! The reports of branches and of stability maps.

use super::{
    Branch, Curve, CurvePoint, OrbitBifurcation, StabilityMap, SteadyBifurcation, Torus,
    by_stability,
};
use crate::analysis::stats::range;
use crate::dynamics::continuation::{Criticality, PeriodicOrbit};
use crate::number::{fixed, short};
use crate::report::{Block, Report, Table};

impl Report for Branch {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let [from, to] = self.interval;
        let rest = format!(
            ": {} from {from} to {to}{}",
            self.parameter,
            unit(&self.unit)
        );
        let mut blocks = vec![Block::heading(scene, rest)];
        for ([low, high], count) in self.unstable_intervals() {
            blocks.push(Block::text(format!(
                "steady sliding with {count} unstable modes from {} to {}",
                short(low),
                short(high)
            )));
        }
        let bifurcations: Vec<_> = self.steady_bifurcations().collect();
        if !bifurcations.is_empty() {
            blocks.push(Block::heading("bifurcations of the equilibria", ""));
            blocks.push(steady_table(self, &bifurcations));
        }
        blocks.extend(
            bifurcations
                .iter()
                .filter_map(|found| normal_form(found, &self.unit)),
        );
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
        let ended = self.ended.iter();
        blocks.extend(ended.map(|reason| Block::Warning(format!("ended: {reason}"))));
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
        .right("first Lyapunov coefficient", |found| {
            found.cycle.as_ref().map(|cycle| {
                let (value, error) = (cycle.first_lyapunov, cycle.first_lyapunov_error);
                format!("{value:.4e} ±{error:.0e}")
            })
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
    let orbits = |number: &usize| {
        let number = *number;
        let points = branch.points.iter();
        points.filter(move |point| point.branch == number)
    };
    Table::of(0..branch.orbit_branches())
        .right("branch", usize::to_string)
        .right("orbits", |number| orbits(number).count().to_string())
        .right(branch.name(), |number| {
            span(orbits(number).map(|point| point.at.value), 4)
        })
        .right("frequency, Hz", |number| {
            span(orbits(number).map(|point| point.orbit.frequency_hz()), 2)
        })
        .right("amplitude, um", |number| {
            span(orbits(number).map(|point| 1e6 * point.orbit.amplitude), 4)
        })
        .left("attracting at", |number| {
            stable_intervals(&branch.course(*number))
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
        .right("±", |(_, it)| format!("{:.0e}", it.accuracy))
        .left("bifurcation", |(found, _)| found.name())
        .right("frequency, Hz", |(_, it)| fixed(it.frequency_hz, 3))
        .right("rotation number", |(_, it)| fixed(it.rotation_number, 6))
        .right("second frequency, Hz", |(_, it)| {
            fixed(it.torus_frequency_hz, 3)
        })
        .right("unstable", |(_, it)| format!("{:+}", it.unstable_change))
        .left("motion born there, by the normal form", |(_, it)| {
            it.birth.map(|birth| {
                let (value, error) = (birth.coefficient, birth.coefficient_error);
                format!("{} ({value:.3} ±{error:.0e})", birth.criticality)
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
        .right("±", |point| {
            let error = point.rotation_number_error;
            error.map(|error| format!("{error:.0e}"))
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
        "{:.0} Hz: {holds} up to an amplitude of {:.2e} um ({:.1e}{} from the Hopf point), where the law has its first kink",
        found.frequency_hz,
        1e6 * amplitude,
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
        let rest = format!(
            ": stability over {} and {}, {} x {} points",
            x.parameter,
            y.parameter,
            x.values.len(),
            y.values.len()
        );
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
        if !map.curves.is_empty() {
            let curves = Table::of(&map.curves)
                .left("Hopf curve", |curve| curve.label.clone())
                .right("points", |curve| curve.points.len().to_string())
                .right("frequency, Hz", |curve| {
                    span(curve.points.iter().map(|point| point.frequency_hz), 1)
                })
                .left("end", |curve| curve_end(curve));
            blocks.push(curves.into());
        }
        if !map.torus_curves.is_empty() {
            let spans = |curve: &Curve, of: fn(&CurvePoint) -> f64, decimals| {
                span(curve.points.iter().map(of), decimals)
            };
            let curves = Table::of(&map.torus_curves)
                .left(
                    "Neimark-Sacker curve of",
                    |_| "the periodic motion of the scene",
                )
                .right("points", |curve| curve.points.len().to_string())
                .right(&x.parameter, |curve| {
                    spans(curve, |point| point.values[0], 4)
                })
                .right(&y.parameter, |curve| {
                    spans(curve, |point| point.values[1], 4)
                })
                .right("second frequency, Hz", |curve| {
                    spans(curve, |point| point.second_hz.unwrap_or(f64::NAN), 1)
                })
                .left("end", |curve| curve_end(curve));
            blocks.push(curves.into());
        }
        blocks
    }
}
