//! Figures of branches over one parameter: modes of the equilibria; periodic orbits with their frequencies, tori and
//! multipliers; and the stability map over two parameters.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use strum::VariantArray as _;

use super::axis::{extent, lowest_growth, readable};
use super::color::colormap;
use super::{Axis, Color, Figure, Layer, Panel, Rgb};
use crate::analysis::{regime::Regime, stats::range};
use crate::dynamics::continuation::{Multiplier, PeriodicOrbit};
use crate::joint::NamedMode;
use crate::study::branch::{
    Branch, Curve, MapPoint, OrbitPoint, StabilityMap, SteadyBifurcationKind, TorusKind,
    by_stability,
};

/// Height of a row of panels, mm.
const ROW_MM: f64 = 62.0;
/// Radius of the plot of the multipliers.
const RADIUS: f64 = 1.35;
/// Vertices of the unit circle.
const CIRCLE: u32 = 180;
/// Colour of a stable grid point.
const STABLE: Rgb = [226, 238, 230];
/// Largest number of unstable modes with a colour of its own.
const MAX_COLORS: usize = 8;

/// The figures of branches: `modes` with equilibria, which a driven system does not have, `branch` and `multipliers` with
/// periodic orbits.
pub fn branch_figures(scene: &str, branch: &Branch) -> Vec<Figure> {
    let modes = (!branch.equilibria.is_empty()).then(|| modes_figure(scene, branch));
    let orbits = [branch_figure, multipliers_figure].into_iter();
    let orbits = orbits.filter(|_| !branch.points.is_empty());
    let orbits = orbits.map(|figure| figure(scene, branch));
    modes.into_iter().chain(orbits).collect()
}

/// The figure `modes`: growth rates and frequencies of the modes over the parameter, solid where a mode is stable and
/// dashed where it is unstable, with the points at which a mode changes its stability.
pub fn modes_figure(scene: &str, branch: &Branch) -> Figure {
    let growth = |mode: &NamedMode| mode.growth;
    let frequency = |mode: &NamedMode| mode.frequency_hz;
    let x = parameter_axis(branch);
    let lowest = lowest_growth(range(all(branch, growth)));
    let growths = all(branch, growth).filter(|growth| *growth >= lowest);
    let y = Axis::with_margin("growth rate, 1/s", growths.chain([0.0]));
    let title = "growth rates of the modes of steady sliding";
    let upper = Panel::new(title, x.clone(), y, layers(branch, growth, Some(0.0)));
    let [_, highest] = extent(all(branch, frequency));
    let y = Axis::linear("frequency", [0.0, 1.08 * highest]).of("Hz");
    let title = "frequencies: solid if stable, dashed if unstable";
    let lower = Panel::new(title, x, y, layers(branch, frequency, None));
    let title = format!("{scene}: modes of steady sliding");
    Figure::grid("modes", &title, ROW_MM, 1, vec![upper, lower])
}

fn parameter_axis(branch: &Branch) -> Axis {
    Axis::linear(readable(&branch.parameter, &branch.unit), branch.interval)
}

/// Values of all oscillating modes.
fn all(branch: &Branch, of: fn(&NamedMode) -> f64) -> impl Iterator<Item = f64> {
    let modes = branch.equilibria.iter().flat_map(|point| &point.modes);
    let modes = modes.map(|mode| &mode.mode);
    modes.filter(|mode| mode.frequency_hz > 0.0).map(of)
}

/// The lines of the modes by label, and the bifurcations; on a level, which has a line, or at their frequencies.
fn layers(branch: &Branch, of: fn(&NamedMode) -> f64, level: Option<f64>) -> Vec<Layer> {
    let points = &branch.equilibria;
    // A mode is named by its first point.
    let mut modes = BTreeMap::new();
    for mode in points.iter().flat_map(|point| &point.modes) {
        modes.entry(mode.number).or_insert(&mode.mode);
    }
    modes.retain(|_, first| first.frequency_hz > 0.0);
    let mut labels: Vec<&str> = Vec::new();
    let mut layers = Vec::from_iter(level.map(Layer::horizontal_line));
    for (number, first) in modes {
        let known = labels.iter().position(|label| *label == first.label);
        let color = Color::Series(known.unwrap_or(labels.len()));
        if known.is_none() {
            labels.push(&first.label);
        }
        let course = points.iter().map(|point| {
            let mut own = point.modes.iter().filter(|mode| mode.number == number);
            let mode = &own.find(|mode| mode.mode.frequency_hz > 0.0)?.mode;
            Some(([point.at.value, of(mode)], !mode.unstable))
        });
        layers.extend(stability_lines(course, color, &first.label));
    }
    let marks = branch.steady_bifurcations().map(|found| {
        let kind = match found.kind {
            SteadyBifurcationKind::ZeroEigenvalue => "zero eigenvalue".to_owned(),
            kind => format!("{kind} {:.2} kHz", 1e-3 * found.frequency_hz),
        };
        let y = level.unwrap_or(found.frequency_hz);
        ([found.at.value, y], kind)
    });
    layers.push(Layer::peaks(marks.collect()));
    let keys = labels.into_iter().enumerate();
    let keys = keys.map(|(k, label)| Layer::legend_entry(label, Color::Series(k)));
    keys.chain(layers).collect()
}

/// The figure `stability-map`: number of unstable modes and largest growth rate over two parameters, with the curves on
/// which a mode changes its stability.
pub fn map_figure(scene: &str, map: &StabilityMap) -> Figure {
    let [x, y] = map.axes.each_ref().map(|axis| {
        let name = readable(&axis.parameter, &axis.unit);
        Axis::cells(name, &axis.values)
    });
    let panel = |title: &str, palette: &[Rgb], index: &dyn Fn(&MapPoint) -> Option<u8>| {
        let cells: Vec<Option<u8>> = map.grid.iter().map(index).collect();
        let cells = Layer::cells([&x, &y], map.axes[0].values.len(), &cells, palette);
        let layers = [cells].into_iter().chain(curves(map));
        Panel::new(title, x.clone(), y.clone(), layers.collect())
    };
    let count = |point: &MapPoint| Some(point.unstable_modes?.min(MAX_COLORS));
    let shades = colormap();
    // Equally spaced from a pale shade, for one mode, to a dark one.
    let colors = (1..=MAX_COLORS).map(|count| shades[15 + 19 * count]);
    let colors: Vec<Rgb> = [STABLE].into_iter().chain(colors).collect();
    let title = match map.curves[..] {
        [] => "number of unstable modes",
        _ => "number of unstable modes; curves: Hopf points",
    };
    let mut counted = panel(title, &colors, &|point| Some(count(point)? as u8));
    let counts: BTreeSet<usize> = map.grid.iter().filter_map(count).collect();
    counted.layers.extend(counts.into_iter().map(|n| {
        let key = Layer::areas(Vec::new(), 1.0, Color::Shade([colors[n]; 2]));
        key.with_label(match n {
            MAX_COLORS => format!("{n} or more"),
            n => n.to_string(),
        })
    }));
    let mut panels = vec![counted];
    let growths = map.grid.iter().filter_map(|p| p.largest_growth_per_s);
    let [low, high] = range(growths.filter(|growth| *growth > 0.0));
    if low <= high {
        let growth = |point: &MapPoint| {
            let growth = point.largest_growth_per_s?;
            let share = (growth - low) / (high - low).max(f64::MIN_POSITIVE);
            // Of the shades below, which are neither the palest nor so dark that they hide the curves.
            let shade = (171.0 * share) as u8;
            Some(if growth > 0.0 { 1 + shade } else { 0 })
        };
        let title = format!("largest growth rate: {low:.0} (pale) to {high:.0} 1/s; green: stable");
        let colors = [&[STABLE][..], &shades[8..180]].concat();
        panels.push(panel(&title, &colors, &growth));
    }
    let title = format!("{scene}: stability of steady sliding");
    Figure::grid("stability-map", &title, 85.0, 2, panels)
}

/// The Hopf curves, by mode, and those of the births of tori.
fn curves(map: &StabilityMap) -> Vec<Layer> {
    let strip = |curve: &Curve| curve.points.iter().map(|point| point.values).collect();
    let labels: BTreeSet<&str> = map.curves.iter().map(|curve| &curve.label[..]).collect();
    let layers = labels.into_iter().enumerate().map(|(k, label)| {
        let own = map.curves.iter().filter(|curve| curve.label == label);
        Layer::lines(own.map(strip).collect(), Color::Series(k)).with_label(label)
    });
    let torus = Layer::lines(map.torus_curves.iter().map(strip).collect(), Color::Ink);
    let torus = torus.dashed().with_label("birth of a torus");
    let torus = Some(torus).filter(|_| !map.torus_curves.is_empty());
    let layers = layers.chain(torus);
    layers.map(|layer| layer.with_size(1.6)).collect()
}

/// The figure `branch`: amplitude and frequency of the periodic orbits over the parameter, solid where they attract and
/// dashed where they do not, the equilibrium at amplitude zero, and the bifurcations. The points of a sweep are dots in the
/// colour of their type of motion.
pub fn branch_figure(scene: &str, branch: &Branch) -> Figure {
    let x = parameter_axis(branch);
    let amplitude = |orbit: &PeriodicOrbit| orbit.amplitude;
    let mut layers = Vec::new();
    let branches = branch.orbit_branches();
    if branches > 1 {
        let entry = |k| Layer::legend_entry(format!("branch {k}"), Color::Series(k));
        layers.extend((0..branches).map(entry));
    }
    let equilibria = branch.equilibria.iter();
    let equilibria = equilibria.map(|p| Some(([p.at.value, 0.0], p.unstable_modes == 0)));
    layers.extend(stability_lines(equilibria, Color::Faint, "equilibrium"));
    layers.extend(lines(branch, amplitude));
    let dots = Regime::VARIANTS.iter().map(|&regime| {
        let dots = branch.settled.iter().filter_map(|point| {
            let response = point.found().filter(|found| found.regime == regime)?;
            Some([*point.place.values.first()?, response.amplitude_m])
        });
        Layer::points(dots.collect(), 1.5, Color::Regime(regime))
            .with_label(format!("sweep: {regime}"))
            .with_id(format!("sweep {regime}"))
    });
    layers.extend(dots.filter(Layer::has_points));
    let values = layers.iter().flat_map(Layer::points_of).map(|at| at[1]);
    let [_, highest] = extent(values.chain([0.0]));
    let named = marks(branch, amplitude);
    layers.push(Layer::rings(named.iter().map(|(at, _)| *at)));
    layers.push(Layer::peaks(named));
    let y = Axis::linear("amplitude", [-0.04 * highest, 1.12 * highest]).of("m");
    let title = "amplitude: solid if the motion attracts, dashed if not";
    let upper = Panel::new(title, x.clone(), y, layers);
    let frequencies = branch.points.iter().map(|point| point.orbit.frequency_hz());
    let mut layers = lines(branch, PeriodicOrbit::frequency_hz);
    // The names are in the upper panel: here they would cover the curve.
    let places = marks(branch, PeriodicOrbit::frequency_hz).into_iter();
    layers.push(Layer::rings(places.map(|(at, _)| at)));
    let y = Axis::with_margin("frequency", frequencies).of("Hz");
    let lower = Panel::new("frequency of the periodic orbits", x.clone(), y, layers);
    let title = format!("{scene}: branches of periodic orbits");
    let panels = [upper, lower].into_iter().chain(rotation_panel(branch, x));
    Figure::grid("branch", &title, ROW_MM, 1, panels.collect())
}

/// The rotation numbers of the tori: dots in the colour of the motion, bars where they are phase-locked. `None` without a
/// torus that was followed.
fn rotation_panel(branch: &Branch, x: Axis) -> Option<Panel> {
    let points = || branch.tori.iter().flat_map(|torus| &torus.points);
    points().next()?;
    let births = branch.tori.iter().filter_map(|torus| {
        let mut found = branch.orbit_bifurcations();
        let born = found.find(|b| b.branch == torus.branch && b.at.value == torus.born)?;
        Some([torus.born, born.bifurcation.rotation_number?])
    });
    let mut layers = vec![Layer::rings(births).with_label("birth")];
    for (kind, color) in [
        (TorusKind::Torus, Color::Regime(Regime::QuasiPeriodic)),
        (TorusKind::Doubled, Color::Series(4)),
        (TorusKind::Locked, Color::Regime(Regime::Periodic)),
        (TorusKind::Irregular, Color::Regime(Regime::Chaotic)),
    ] {
        let own = points().filter(|point| point.kind == kind);
        let places = own.filter_map(|point| Some([point.at.value, point.rotation_number?]));
        let dots = Layer::points(places.collect(), 2.4, color).with_label(kind.to_string());
        layers.extend(Some(dots).filter(Layer::has_points));
    }
    let rotations = layers.iter().flat_map(Layer::points_of).map(|at| at[1]);
    let y = Axis::with_margin("rotation number", rotations);
    let tongues = branch.tori.iter().flat_map(|torus| &torus.tongues);
    let bars = tongues.filter_map(|tongue| {
        let [p, q] = tongue.locking.map(f64::from);
        let [low, high] = tongue.borders;
        Some(vec![[low?, p / q], [high?, p / q]])
    });
    let bars = Layer::lines(bars.collect(), Color::Regime(Regime::Periodic));
    layers.push(bars.with_size(1.6));
    let title = "rotation number of the tori; bars: phase-locked";
    Some(Panel::new(title, x, y, layers))
}

/// The figure `multipliers`: the Floquet multipliers of all orbits in the complex plane, and the largest magnitudes over
/// the parameter.
pub fn multipliers_figure(scene: &str, branch: &Branch) -> Figure {
    let mut layers = vec![Layer::horizontal_line(1.0)];
    for (k, label) in ["largest", "second", "third"].into_iter().enumerate().rev() {
        let branches = branch.points.chunk_by(|a, b| a.branch == b.branch);
        let strips = branches.map(|part| {
            let magnitudes = part.iter().filter_map(|point| {
                let multiplier = point.orbit.nontrivial_multipliers().nth(k)?;
                Some([point.at.value, multiplier.magnitude()])
            });
            magnitudes.collect()
        });
        // Lines behind are wider, so that those of a complex pair, which coincide, remain visible.
        let line = Layer::lines(strips.collect(), Color::Series(k))
            .with_size(1.1 + 1.1 * k as f64)
            .with_label(label);
        layers.extend(Some(line).filter(Layer::has_points));
    }
    let values = layers.iter().flat_map(Layer::points_of).map(|at| at[1]);
    let y = Axis::with_margin("magnitude", values);
    layers.push(Layer::peaks(marks(branch, |_| 1.0)));
    let title = "magnitudes, without the trivial multiplier";
    let magnitude = Panel::new(title, parameter_axis(branch), y, layers);
    let title = format!("{scene}: Floquet multipliers");
    let rows = vec![vec![multipliers_panel(branch, None), magnitude]];
    Figure::new("multipliers", &title, 85.0, rows)
}

/// The complex plane with the unit circle and the multipliers of all orbits, or of one of them in front of the others.
pub fn multipliers_panel(branch: &Branch, chosen: Option<&OrbitPoint>) -> Panel {
    let circle = (0..=CIRCLE).map(|k| {
        let angle = TAU * f64::from(k) / f64::from(CIRCLE);
        [angle.cos(), angle.sin()]
    });
    let horizontal = vec![[-RADIUS, 0.0], [RADIUS, 0.0]];
    let cross = vec![horizontal, vec![[0.0, -RADIUS], [0.0, RADIUS]]];
    let mut layers = vec![
        Layer::line(circle.collect(), Color::Ink).with_id("circle"),
        Layer::lines(cross, Color::Pale).with_id("cross"),
    ];
    // Each with its radius and its colour inside of the circle.
    for (prefix, points, radius, inside) in [
        ("all ", branch.points.iter().collect(), 0.8, Color::Faint),
        ("", Vec::from_iter(chosen), 2.2, Color::Ink),
    ] {
        let multipliers = points.iter().flat_map(|point| &point.orbit.multipliers);
        let (outer, inner): (Vec<&Multiplier>, _) =
            multipliers.partition(|m| m.ln_magnitude > 1e-6);
        for (side, multipliers, color) in
            [("inside", inner, inside), ("outside", outer, Color::Accent)]
        {
            let places = multipliers.iter().map(|m| [m.re(), m.im()]);
            let layer = Layer::points(places.collect(), radius, color);
            layers.push(layer.with_id(format!("{prefix}{side}")));
        }
    }
    let [x, y] = ["real part", "imaginary part"].map(|name| Axis::linear(name, [-RADIUS, RADIUS]));
    Panel::new("multipliers in the unit circle", x, y, layers).square()
}

/// The lines of all branches.
fn lines(branch: &Branch, of: fn(&PeriodicOrbit) -> f64) -> Vec<Layer> {
    let layers = (0..branch.orbit_branches()).flat_map(|number| {
        let course = branch.course(number).into_iter();
        let points = course.map(|(orbit, stable)| Some(([orbit.parameter, of(orbit)], stable)));
        stability_lines(points, Color::Series(number), &format!("branch {number}"))
    });
    layers.collect()
}

/// The unstable (dashed) and the stable parts (solid) of a line, which is interrupted at `None`.
fn stability_lines(
    points: impl Iterator<Item = Option<([f64; 2], bool)>>,
    color: Color,
    id: &str,
) -> [Layer; 2] {
    let [unstable, stable] = by_stability(points).map(|strips| Layer::lines(strips, color));
    [
        unstable.dashed().with_id(format!("{id}, unstable")),
        stable.with_size(1.6).with_id(format!("{id}, stable")),
    ]
}

/// Places of the bifurcations of the orbits, with their short names and second frequencies.
fn marks(branch: &Branch, of: fn(&PeriodicOrbit) -> f64) -> Vec<([f64; 2], String)> {
    let marks = branch.orbit_bifurcations().map(|found| {
        let name = match found.bifurcation.torus_frequency_hz {
            Some(hz) => format!("{}, {:.2} kHz", found.name(), 1e-3 * hz),
            None => found.name(),
        };
        ([found.at.value, of(&found.bifurcation.orbit)], name)
    });
    marks.collect()
}
