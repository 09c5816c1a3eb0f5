//! Figures of branches over one parameter: modes of the equilibria; periodic orbits with their frequencies, tori and
//! multipliers; and the stability map over two parameters.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use strum::VariantArray as _;

use super::axis::{extent, lowest_growth, readable};
use super::color::{colormap, colormap_index};
use super::{Axis, Color, Figure, Layer, Panel, Rgb};
use crate::analysis::{regime::Regime, stats::range};
use crate::dynamics::continuation::PeriodicOrbit;
use crate::joint::NamedMode;
use crate::study::branch::{
    Branch, Curve, EquilibriumPoint, MapPoint, OrbitBifurcation, OrbitPoint, StabilityMap,
    SteadyBifurcationKind, TorusKind, by_stability,
};

/// Height of a row of panels, mm.
const ROW_MM: f64 = 62.0;
/// Colours of the branches, cyclically.
const BRANCH_COLORS: [Color; 4] = [
    Color::Series(0),
    Color::Series(1),
    Color::Series(4),
    Color::Series(3),
];
/// Radius of the plot of the multipliers.
const RADIUS: f64 = 1.35;
/// Vertices of the unit circle.
const CIRCLE: u32 = 180;
/// Colour of a stable grid point.
const STABLE: Rgb = [226, 238, 230];
/// Colours of grid points with unstable modes: positions in the colour map of the first, and steps between.
const UNSTABLE_SHARES: [f64; 2] = [0.06, 0.075];
/// Positions in the colour map of the smallest and the largest positive growth rate.
const GROWTH_SHARES: [f64; 2] = [0.03, 0.7];
/// Largest number of unstable modes with a colour of its own.
const MAX_COLORS: usize = 8;

/// The figure `modes`: growth rates and frequencies of the modes over the parameter, solid where a mode is stable and
/// dashed where it is unstable, with the points at which a mode changes its stability.
pub fn modes_figure(scene: &str, branch: &Branch) -> Figure {
    let points = &branch.equilibria;
    let x = Axis::linear(readable(&branch.parameter, &branch.unit), branch.interval);
    let lowest = lowest_growth(range(all(points, |mode| mode.growth)));
    let growths = all(points, |mode| mode.growth).filter(|growth| *growth >= lowest);
    let [low, high] = extent(growths.chain([0.0]));
    let margin = 0.08 * (high - low);
    let y = Axis::linear("growth rate, 1/s", [low - margin, high + margin]);
    let title = "growth rates of the modes of steady sliding";
    let growth = Panel::new(title, x.clone(), y, layers(branch, true));
    let [_, highest] = extent(all(points, |mode| mode.frequency_hz));
    let y = Axis::linear("frequency", [0.0, 1.08 * highest]).of("Hz");
    let title = "frequencies: solid if stable, dashed if unstable";
    let frequency = Panel::new(title, x, y, layers(branch, false));
    let title = format!("{scene}: modes of steady sliding");
    let rows = vec![vec![growth], vec![frequency]];
    Figure::new("modes", title, 2.0 * ROW_MM, rows)
}

/// Values of all oscillating modes.
fn all<'a>(
    points: &'a [EquilibriumPoint],
    of: impl Fn(&NamedMode) -> f64 + 'a,
) -> impl Iterator<Item = f64> + 'a {
    let modes = points.iter().flat_map(|point| &point.modes);
    let modes = modes.map(|mode| &mode.mode);
    modes.filter(|mode| mode.frequency_hz > 0.0).map(of)
}

/// The lines of the modes by label, the zero line and the bifurcations, over growth rate or frequency.
fn layers(branch: &Branch, of_growth: bool) -> Vec<Layer> {
    let points = &branch.equilibria;
    // A mode is named by its first point.
    let mut modes = BTreeMap::new();
    for mode in points.iter().flat_map(|point| &point.modes) {
        modes.entry(mode.number).or_insert(&mode.mode);
    }
    modes.retain(|_, first| first.frequency_hz > 0.0);
    let mut labels: Vec<&str> = Vec::new();
    let mut layers = Vec::new();
    let mut keys = Vec::new();
    if of_growth {
        layers.push(Layer::horizontal_line(0.0));
    }
    for (number, first) in modes {
        let label = &first.label[..];
        let known = labels.iter().position(|known| *known == label);
        let index = known.unwrap_or(labels.len());
        let color = Color::Series(index);
        if known.is_none() {
            labels.push(label);
            keys.push(Layer::legend_entry(label, color));
        }
        let course = points.iter().map(|point| {
            let mut own = point.modes.iter().filter(|mode| mode.number == number);
            let mode = &own.find(|mode| mode.mode.frequency_hz > 0.0)?.mode;
            let value = if of_growth {
                mode.growth
            } else {
                mode.frequency_hz
            };
            Some(([point.at.value, value], !mode.unstable))
        });
        layers.extend(stability_lines(course, color, label));
    }
    let marks = branch.steady_bifurcations().map(|found| {
        let y = if of_growth { 0.0 } else { found.frequency_hz };
        let kind = match found.kind {
            SteadyBifurcationKind::ZeroEigenvalue => "zero eigenvalue".to_owned(),
            kind => format!("{kind} {:.2} kHz", 1e-3 * found.frequency_hz),
        };
        ([found.at.value, y], kind)
    });
    let marks: Vec<_> = marks.collect();
    layers.push(Layer::rings(marks.iter().map(|(at, _)| *at)));
    layers.push(Layer::peaks(marks));
    keys.into_iter().chain(layers).collect()
}

/// The figure `stability-map`: number of unstable modes and largest growth rate over two parameters, with the curves on
/// which a mode changes its stability.
pub fn map_figure(scene: &str, map: &StabilityMap) -> Figure {
    let names = map
        .axes
        .each_ref()
        .map(|axis| readable(&axis.parameter, &axis.unit));
    let axes = [0, 1].map(|k| Axis::cells(&names[k], &map.axes[k].values));
    let image = |palette: &mut dyn Iterator<Item = Rgb>,
                 index: &dyn Fn(&MapPoint) -> Option<u8>| {
        let cells: Vec<Option<u8>> = map.grid.iter().map(index).collect();
        Layer::cells(axes.each_ref(), map.axes[0].values.len(), &cells, palette)
    };
    let panel = |title: String, layers: Vec<Layer>| {
        let layers = layers.into_iter().chain(curves(map)).collect();
        Panel::new(title, axes[0].clone(), axes[1].clone(), layers)
    };
    let count = |point: &MapPoint| Some(point.unstable_modes?.min(MAX_COLORS));
    let [first, step] = UNSTABLE_SHARES;
    let shades = colormap();
    let shade = |n: usize| match n {
        0 => STABLE,
        n => shades[usize::from(colormap_index(first + step * n as f64))],
    };
    let counts: BTreeSet<usize> = map.grid.iter().filter_map(count).collect();
    let keys = counts.into_iter().map(|n| {
        let key = Layer::areas(Vec::new(), 1.0, Color::Shade([shade(n); 2]));
        key.with_label(match n {
            MAX_COLORS => format!("{n} or more"),
            n => n.to_string(),
        })
    });
    let counted = image(&mut (0..=MAX_COLORS).map(shade), &|point| {
        Some(count(point)? as u8)
    });
    let layers = [counted].into_iter().chain(keys).collect();
    let curves_are = if map.curves.is_empty() {
        ""
    } else {
        "; curves: Hopf points"
    };
    let title = format!("number of unstable modes{curves_are}");
    let mut panels = vec![panel(title, layers)];
    let growths = map.grid.iter().filter_map(|p| p.largest_growth_per_s);
    let [low, high] = range(growths.filter(|growth| *growth > 0.0));
    if low <= high {
        let [pale, dark] = GROWTH_SHARES;
        let growth = |point: &MapPoint| {
            let growth = point.largest_growth_per_s?;
            let share = pale + (dark - pale) * (growth - low) / (high - low).max(f64::MIN_POSITIVE);
            Some(if growth > 0.0 {
                1 + colormap_index(share).min(250)
            } else {
                0
            })
        };
        let mut palette = [STABLE].into_iter().chain(shades[..251].iter().copied());
        let title = format!("largest growth rate: {low:.0} (pale) to {high:.0} 1/s; green: stable");
        panels.push(panel(title, vec![image(&mut palette, &growth)]));
    }
    let title = format!("{scene}: stability of steady sliding");
    Figure::grid("stability-map", title, 85.0, 2, panels)
}

/// The Hopf curves, by mode, and those of the births of tori.
fn curves(map: &StabilityMap) -> Vec<Layer> {
    let lines = |curves: &mut dyn Iterator<Item = &Curve>, color| {
        let strips = curves.map(|curve| curve.points.iter().map(|point| point.values).collect());
        Layer::lines(strips.collect(), color).with_size(1.6)
    };
    let labels: BTreeSet<&str> = map.curves.iter().map(|curve| &curve.label[..]).collect();
    let layers = labels.into_iter().enumerate().map(|(k, label)| {
        let mut own = map.curves.iter().filter(|curve| curve.label == label);
        lines(&mut own, Color::Series(k))
            .with_label(label)
            .with_id(format!("curve {k}"))
    });
    let torus = (!map.torus_curves.is_empty()).then(|| {
        lines(&mut map.torus_curves.iter(), Color::Ink)
            .dashed()
            .with_label("birth of a torus")
            .with_id("torus curves")
    });
    layers.chain(torus).collect()
}

/// The figure `branch`: amplitude and frequency of the periodic orbits over the parameter, solid where they attract and
/// dashed where they do not, the equilibrium at amplitude zero, and the bifurcations. The points of a sweep are dots in the
/// colour of their type of motion.
pub fn branch_figure(scene: &str, branch: &Branch) -> Figure {
    let x = Axis::linear(readable(&branch.parameter, &branch.unit), branch.interval);
    let amplitude = |orbit: &PeriodicOrbit| orbit.amplitude;
    let branches = branch.orbit_branches();
    let mut layers = Vec::new();
    if branches > 1 {
        let entry = |k| Layer::legend_entry(format!("branch {k}"), color(k));
        layers.extend((0..branches).map(entry));
    }
    let equilibria = branch.equilibria.iter();
    let equilibria = equilibria.map(|p| Some(([p.at.value, 0.0], p.unstable_modes == 0)));
    layers.extend(stability_lines(equilibria, Color::Faint, "equilibrium"));
    layers.extend(lines(branch, &amplitude));
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
    layers.push(rings(branch, &amplitude));
    let names = branch.orbit_bifurcations();
    let names = names.map(|found| (place(found, &amplitude), name(found)));
    layers.push(Layer::peaks(names.collect()));
    let upper = Panel::new(
        "amplitude: solid if the motion attracts, dashed if not",
        x.clone(),
        Axis::linear("amplitude", [-0.04 * highest, 1.12 * highest]).of("m"),
        layers,
    );
    let frequencies = branch.points.iter().map(|point| point.orbit.frequency_hz());
    let mut layers = lines(branch, &PeriodicOrbit::frequency_hz);
    // The names are in the upper panel: here they would cover the curve.
    layers.push(rings(branch, &PeriodicOrbit::frequency_hz));
    let lower = Panel::new(
        "frequency of the periodic orbits",
        x.clone(),
        Axis::with_margin("frequency", frequencies).of("Hz"),
        layers,
    );
    let title = format!("{scene}: branches of periodic orbits");
    let mut rows = vec![vec![upper], vec![lower]];
    rows.extend(rotation_panel(branch, x).map(|panel| vec![panel]));
    let height = rows.len() as f64 * ROW_MM;
    Figure::new("branch", title, height, rows)
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
    let mut layers = vec![Layer::rings(births).with_label("birth").with_id("births")];
    let kinds = [
        (TorusKind::Torus, Color::Regime(Regime::QuasiPeriodic)),
        (TorusKind::Doubled, Color::Series(4)),
        (TorusKind::Locked, Color::Regime(Regime::Periodic)),
        (TorusKind::Irregular, Color::Regime(Regime::Chaotic)),
    ];
    let kinds = kinds.map(|(kind, color)| {
        let own = points().filter(|point| point.kind == kind);
        let places = own.filter_map(|point| Some([point.at.value, point.rotation_number?]));
        Layer::points(places.collect(), 2.4, color)
            .with_label(kind.to_string())
            .with_id(kind.to_string())
    });
    layers.extend(kinds.into_iter().filter(Layer::has_points));
    let rotations = layers.iter().flat_map(Layer::points_of).map(|at| at[1]);
    let y = Axis::with_margin("rotation number", rotations);
    let tongues = branch.tori.iter().flat_map(|torus| &torus.tongues);
    let bars = tongues.filter_map(|tongue| {
        let [p, q] = tongue.locking.map(f64::from);
        let [low, high] = tongue.borders;
        Some(vec![[low?, p / q], [high?, p / q]])
    });
    layers.push(
        Layer::lines(bars.collect(), Color::Regime(Regime::Periodic))
            .with_size(1.6)
            .with_id("tongues"),
    );
    let title = "rotation number of the tori; bars: phase-locked";
    Some(Panel::new(title, x, y, layers))
}

/// The figure `multipliers`: the Floquet multipliers of all orbits in the complex plane, and the largest magnitudes over
/// the parameter.
pub fn multipliers_figure(scene: &str, branch: &Branch) -> Figure {
    let mut layers = vec![Layer::horizontal_line(1.0)];
    let magnitude = |point: &OrbitPoint, k: usize| {
        let magnitude = point.orbit.nontrivial_multipliers().nth(k)?.magnitude();
        Some([point.at.value, magnitude])
    };
    for (k, label) in ["largest", "second", "third"].into_iter().enumerate().rev() {
        let branches = branch.points.chunk_by(|a, b| a.branch == b.branch);
        let strip = |part: &[OrbitPoint]| part.iter().filter_map(|at| magnitude(at, k)).collect();
        let strips = branches.map(strip);
        // Lines behind are wider, so that those of a complex pair, which coincide, remain visible.
        let line = Layer::lines(strips.collect(), Color::Exponent(k))
            .with_size(1.1 + 1.1 * k as f64)
            .with_label(label)
            .with_id(label);
        layers.extend(Some(line).filter(Layer::has_points));
    }
    let values = layers.iter().flat_map(Layer::points_of).map(|at| at[1]);
    let y = Axis::with_margin("magnitude", values);
    let marks = branch.orbit_bifurcations();
    let marks = marks.map(|found| ([found.at.value, 1.0], name(found)));
    layers.push(Layer::peaks(marks.collect()));
    let magnitude = Panel::new(
        "magnitudes, without the trivial multiplier",
        Axis::linear(readable(&branch.parameter, &branch.unit), branch.interval),
        y,
        layers,
    );
    let title = format!("{scene}: Floquet multipliers");
    let rows = vec![vec![multipliers_panel(branch, None), magnitude]];
    Figure::new("multipliers", title, 85.0, rows)
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
    let at = |point: &OrbitPoint, is_outside: bool| -> Vec<[f64; 2]> {
        let multipliers = point.orbit.multipliers.iter();
        let chosen = multipliers.filter(|m| (m.ln_magnitude > 1e-6) == is_outside);
        chosen.map(|m| [m.re(), m.im()]).collect()
    };
    let sides = [("inside", false), ("outside", true)];
    for (side, is_outside) in sides {
        let all = branch.points.iter().flat_map(|point| at(point, is_outside));
        let (radius, color) = match (chosen, is_outside) {
            (Some(_), _) => (0.5, Color::Pale),
            (None, false) => (0.8, Color::Faint),
            (None, true) => (0.8, Color::Accent),
        };
        layers.push(Layer::points(all.collect(), radius, color).with_id(format!("all {side}")));
    }
    layers.extend(chosen.into_iter().flat_map(|point| {
        sides.map(|(side, is_outside)| {
            let color = if is_outside {
                Color::Accent
            } else {
                Color::Ink
            };
            Layer::points(at(point, is_outside), 2.2, color).with_id(side)
        })
    }));
    let [x, y] = ["real part", "imaginary part"].map(|name| Axis::linear(name, [-RADIUS, RADIUS]));
    Panel::new("multipliers in the unit circle", x, y, layers).square()
}

fn color(branch: usize) -> Color {
    BRANCH_COLORS[branch % BRANCH_COLORS.len()]
}

/// The lines of all branches.
fn lines(branch: &Branch, of: &dyn Fn(&PeriodicOrbit) -> f64) -> Vec<Layer> {
    let layers = (0..branch.orbit_branches()).flat_map(|number| {
        let course = branch.course(number).into_iter();
        let points = course.map(|(orbit, stable)| Some(([orbit.parameter, of(orbit)], stable)));
        stability_lines(points, color(number), &format!("branch {number}"))
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

/// Parameter and value of a bifurcation.
fn place(found: &OrbitBifurcation, of: &dyn Fn(&PeriodicOrbit) -> f64) -> [f64; 2] {
    [found.at.value, of(&found.bifurcation.orbit)]
}

fn rings(branch: &Branch, of: &dyn Fn(&PeriodicOrbit) -> f64) -> Layer {
    Layer::rings(branch.orbit_bifurcations().map(|found| place(found, of)))
}

/// Short name of a bifurcation with its second frequency.
fn name(found: &OrbitBifurcation) -> String {
    let kind = found.name();
    match found.bifurcation.torus_frequency_hz {
        Some(hz) => format!("{kind}, {:.2} kHz", 1e-3 * hz),
        None => kind,
    }
}
