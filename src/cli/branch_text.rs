//! The report of `squeakscope branch` for the terminal.

use std::fmt::Write as _;

use super::report::{HEADING, WARNING};
use crate::analysis::range;
use crate::dynamics::continuation::{Criticality, PeriodicOrbit};
use crate::escape;
use crate::number::{fixed, short};
use crate::study::branch::{
    Branch, OrbitBifurcation, OrbitPoint, StabilityMap, SteadyBifurcation, Torus, TorusCurvePoint,
};
use crate::table::Table;

/// The branches over one parameter.
pub(super) fn branch(scene: &str, branch: &Branch) -> String {
    let mut text = String::new();
    let [from, to] = branch.interval;
    let _ = writeln!(
        text,
        "{HEADING}{}{HEADING:#}: {} from {from} to {to}{}",
        escape::line(scene),
        branch.parameter,
        unit(&branch.unit),
    );
    for ([low, high], count) in branch.unstable_intervals() {
        let _ = writeln!(
            text,
            "  steady sliding with {count} unstable modes from {} to {}",
            short(low),
            short(high)
        );
    }
    let bifurcations: Vec<_> = branch.steady_bifurcations().collect();
    if !bifurcations.is_empty() {
        let _ = writeln!(text, "\n{}", steady_table(branch, &bifurcations).text());
    }
    for found in &bifurcations {
        text += &normal_form(found, &branch.unit);
    }
    if !branch.points.is_empty() {
        let _ = writeln!(text, "\n{}", orbit_table(branch).text());
    }
    let found: Vec<_> = branch.orbit_bifurcations().collect();
    if !found.is_empty() {
        let _ = writeln!(text, "{}", bifurcation_table(branch, &found).text());
    }
    for torus in &branch.tori {
        text += &self::torus(branch, torus);
    }
    for reason in &branch.ended {
        let _ = writeln!(text, "  {WARNING}ended{WARNING:#} {reason}");
    }
    text
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
                format!("{value:.4e} +-{error:.0e}")
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
        .right("+-")
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
                format!("{} ({value:.3} +-{error:.0e})", birth.criticality)
            }),
        ]);
    }
    table
}

/// A torus from its birth on, one row per value, and its tongues.
fn torus(branch: &Branch, torus: &Torus) -> String {
    let mut table = Table::default()
        .right(branch.name())
        .left("motion")
        .right("first tone, Hz")
        .right("second tone, Hz")
        .right("side line")
        .right("rotation number")
        .right("+-");
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
            point
                .rotation_number
                .map_or_else(String::new, |rotation| format!("{rotation:.8}")),
            point
                .rotation_number_error
                .map_or_else(String::new, |error| format!("{error:.0e}")),
        ]);
    }
    let mut text = format!(
        "  torus of branch {}, born at {:.7}\n{}",
        torus.branch,
        torus.born,
        table.text()
    );
    for tongue in &torus.tongues {
        let [p, q] = tongue.locking;
        let [low, high] = tongue
            .borders
            .map(|border| border.map_or_else(|| "?".to_owned(), |border| format!("{border:.7}")));
        let _ = writeln!(text, "  phase-locked {p}:{q} from {low} to {high}");
    }
    if let Some(reason) = &torus.ended {
        let _ = writeln!(text, "  {WARNING}ended{WARNING:#} {reason}");
    }
    text.push('\n');
    text
}

/// The range of the normal form of a Hopf point with kinks, as a sentence.
fn normal_form(found: &SteadyBifurcation, unit: &str) -> String {
    let Some(cycle) = &found.cycle else {
        return String::new();
    };
    let (Some(amplitude), Some(range)) = (cycle.smooth_amplitude_m, cycle.smooth_range) else {
        return String::new();
    };
    let word = match cycle.criticality {
        Criticality::Undetermined => "kinks begin",
        _ => "the normal form holds",
    };
    format!(
        "  {:.0} Hz: {word} up to an amplitude of {:.2e} um ({:.1e}{} from the Hopf point), where the law has its first kink\n",
        found.frequency_hz,
        1e6 * amplitude,
        range,
        self::unit(unit),
    )
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

/// The stability map.
pub(super) fn map(scene: &str, map: &StabilityMap) -> String {
    let mut text = String::new();
    let [x, y] = &map.axes;
    let _ = writeln!(
        text,
        "{HEADING}{}{HEADING:#}: stability over {} and {}, {} x {} points",
        escape::line(scene),
        x.parameter,
        y.parameter,
        x.values.len(),
        y.values.len()
    );
    let mut table = Table::default()
        .right("unstable modes")
        .right("share of the map");
    let counts = || map.grid.iter().map(|point| point.unstable_modes);
    let most = counts().flatten().max().unwrap_or(0);
    let kinds = (0..=most).map(Some).chain([None]);
    for kind in kinds {
        let number = counts().filter(|count| *count == kind).count();
        if number > 0 {
            let name = kind.map_or_else(|| "no equilibrium".to_owned(), |count| count.to_string());
            let share = 100.0 * number as f64 / map.grid.len() as f64;
            table.row([name, format!("{share:.1} %")]);
        }
    }
    text += &table.text();
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
        let _ = write!(text, "\n{}", table.text());
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
        let _ = write!(text, "\n{}", table.text());
    }
    text
}
