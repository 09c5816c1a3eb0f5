//! The reports of branches and of stability maps.

use super::{
    Branch, OrbitBifurcation, OrbitPoint, StabilityMap, SteadyBifurcation, Torus, TorusCurvePoint,
};
use crate::analysis::range;
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
            blocks.push(Block::Table(steady_table(self, &bifurcations)));
        }
        blocks.extend(
            bifurcations
                .iter()
                .filter_map(|found| normal_form(found, &self.unit)),
        );
        if !self.points.is_empty() {
            blocks.push(Block::heading("periodic orbits", ""));
            blocks.push(Block::Table(orbit_table(self)));
        }
        let found: Vec<_> = self.orbit_bifurcations().collect();
        if !found.is_empty() {
            blocks.push(Block::heading("their bifurcations", ""));
            blocks.push(Block::Table(bifurcation_table(self, &found)));
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
fn steady_table(branch: &Branch, found: &[&SteadyBifurcation]) -> Table {
    let per_unit = match &branch.unit[..] {
        "" => "crossing speed, 1/s".to_owned(),
        unit => format!("crossing speed, 1/s per {unit}"),
    };
    let mut table = Table::default()
        .right(branch.name())
        .left("bifurcation")
        .right("frequency, Hz")
        .left("mode")
        .right(per_unit)
        .right("first Lyapunov coefficient")
        .left("cycle");
    for found in found {
        let cycle = found.cycle.as_ref();
        table.row([
            format!("{:.9}", found.at.value),
            found.kind.to_string(),
            fixed(found.frequency_hz, 3),
            found.label.clone(),
            found
                .crossing_speed
                .map_or_else(String::new, |speed| format!("{speed:.4}")),
            cycle.map_or_else(String::new, |cycle| {
                let (value, error) = (cycle.first_lyapunov, cycle.first_lyapunov_error);
                format!("{value:.4e} ±{error:.0e}")
            }),
            cycle.map_or_else(String::new, |cycle| {
                format!("{}, by the {}", cycle.criticality, cycle.method)
            }),
        ]);
    }
    table
}

/// The branches of periodic orbits, one per row.
fn orbit_table(branch: &Branch) -> Table {
    let mut table = Table::default()
        .right("branch")
        .right("orbits")
        .right(branch.name())
        .right("frequency, Hz")
        .right("amplitude, um")
        .left("attracting at");
    let count = branch.orbit_branches();
    for number in 0..count {
        let own = || branch.points.iter().filter(|point| point.branch == number);
        let span = |of: fn(&OrbitPoint) -> f64, digits: usize| {
            let [low, high] = range(own().map(of));
            format!("{low:.digits$} to {high:.digits$}")
        };
        table.row([
            number.to_string(),
            own().count().to_string(),
            span(|point| point.at.value, 4),
            span(|point| point.orbit.frequency_hz(), 2),
            span(|point| 1e6 * point.orbit.amplitude, 4),
            stable_intervals(&branch.course(number)),
        ]);
    }
    table
}

/// Parts of a branch whose orbits attract, in its order.
fn stable_intervals(course: &[(&PeriodicOrbit, bool)]) -> String {
    let mut parts: Vec<[f64; 2]> = Vec::new();
    let mut before: Option<(f64, bool)> = None;
    for &(orbit, stable) in course {
        let value = orbit.parameter;
        match (before, parts.last_mut()) {
            (Some((_, true)), Some(last)) if stable => last[1] = value,
            // It begins at the bifurcation.
            (Some((bifurcation, _)), _) if stable => parts.push([bifurcation, value]),
            (None, _) if stable => parts.push([value; 2]),
            _ => {}
        }
        before = Some((value, stable));
    }
    let parts = parts
        .iter()
        .map(|[from, to]| format!("{from:.4} to {to:.4}"));
    let parts: Vec<String> = parts.collect();
    if parts.is_empty() {
        "-".to_owned()
    } else {
        parts.join(", ")
    }
}

/// The bifurcations of the periodic orbits, one per row.
fn bifurcation_table(branch: &Branch, found: &[&OrbitBifurcation]) -> Table {
    let mut table = Table::default()
        .right("branch")
        .right(branch.name())
        .right("±")
        .left("bifurcation")
        .right("frequency, Hz")
        .right("rotation number")
        .right("second frequency, Hz")
        .right("unstable")
        .left("motion born there, by the normal form");
    for found in found {
        let bifurcation = &found.bifurcation;
        table.row([
            found.branch.to_string(),
            format!("{:.7}", found.at.value),
            format!("{:.0e}", bifurcation.accuracy),
            found.name(),
            format!("{:.3}", bifurcation.frequency_hz),
            bifurcation
                .rotation_number
                .map_or_else(String::new, |r| format!("{r:.6}")),
            fixed(bifurcation.torus_frequency_hz, 3),
            format!("{:+}", bifurcation.unstable_change),
            bifurcation.birth.map_or_else(String::new, |birth| {
                let (value, error) = (birth.coefficient, birth.coefficient_error);
                format!("{} ({value:.3} ±{error:.0e})", birth.criticality)
            }),
        ]);
    }
    table
}

/// A torus from its birth on, one row per value, and its tongues.
fn torus(branch: &Branch, torus: &Torus) -> Vec<Block> {
    let mut table = Table::default()
        .right(branch.name())
        .left("motion")
        .right("first tone, Hz")
        .right("second tone, Hz")
        .right("side line")
        .right("rotation number")
        .right("±");
    for point in &torus.points {
        let [p, q] = point.locking.unwrap_or_default();
        table.row([
            format!("{:.6}", point.at.value),
            match point.locking {
                Some(_) => format!("{} {p}:{q}", point.kind),
                None => point.kind.to_string(),
            },
            format!("{:.4}", point.first_hz),
            fixed(point.second_hz, 4),
            format!("{:.2e}", point.side_line),
            fixed(point.rotation_number, 8),
            point
                .rotation_number_error
                .map_or_else(String::new, |error| format!("{error:.0e}")),
        ]);
    }
    let title = format!("torus of branch {}", torus.branch);
    let mut blocks = vec![
        Block::heading(title, format!(", born at {:.7}", torus.born)),
        Block::Table(table),
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
fn curve_end(closed: bool, reasons: &[String]) -> String {
    match (closed, reasons) {
        (true, _) => "closed".to_owned(),
        (false, []) => "at the borders".to_owned(),
        (false, reasons) => reasons.join("; "),
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
        let mut blocks = vec![Block::heading(scene, rest)];
        let mut table = Table::default()
            .right("unstable modes")
            .right("share of the map");
        let counts = || map.grid.iter().map(|point| point.unstable_modes);
        let most = counts().flatten().max().unwrap_or(0);
        let kinds = (0..=most).map(Some).chain([None]);
        for kind in kinds {
            let number = counts().filter(|count| *count == kind).count();
            if number > 0 {
                let name =
                    kind.map_or_else(|| "no equilibrium".to_owned(), |count| count.to_string());
                let share = 100.0 * number as f64 / map.grid.len() as f64;
                table.row([name, format!("{share:.1} %")]);
            }
        }
        blocks.push(Block::Table(table));
        if !map.curves.is_empty() {
            let mut table = Table::default()
                .left("Hopf curve")
                .right("points")
                .right("frequency, Hz")
                .left("end");
            for curve in &map.curves {
                let frequencies = curve.points.iter().map(|point| point.frequency_hz);
                let [low, high] = range(frequencies);
                table.row([
                    curve.label.clone(),
                    curve.points.len().to_string(),
                    format!("{low:.1} to {high:.1}"),
                    curve_end(curve.closed, &curve.ended),
                ]);
            }
            blocks.push(Block::Table(table));
        }
        if !map.torus_curves.is_empty() {
            let mut table = Table::default()
                .left("Neimark-Sacker curve of")
                .right("points")
                .right(&x.parameter)
                .right(&y.parameter)
                .right("second frequency, Hz")
                .left("end");
            for curve in &map.torus_curves {
                let span = |of: fn(&TorusCurvePoint) -> f64, digits: usize| {
                    let [low, high] = range(curve.points.iter().map(of));
                    format!("{low:.digits$} to {high:.digits$}")
                };
                table.row([
                    "the periodic motion of the scene".to_owned(),
                    curve.points.len().to_string(),
                    span(|point| point.values[0], 4),
                    span(|point| point.values[1], 4),
                    span(|point| point.second_hz, 1),
                    curve_end(curve.closed, &curve.ended),
                ]);
            }
            blocks.push(Block::Table(table));
        }
        blocks
    }
}
