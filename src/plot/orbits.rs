//! Figures of branches of periodic orbits: branch diagram, frequency and amplitude, multipliers in the unit circle.

use std::f64::consts::TAU;

use super::axis::{Axis, extent, readable};
use super::color::Color;
use super::figure::{Figure, Layer, Marker, Panel};
use super::unit::Unit;
use crate::analysis::Regime;
use crate::dynamics::continuation::PeriodicOrbit;
use crate::study::branch::{Branch, OrbitBifurcation, OrbitPoint, TorusKind};
use crate::study::sweep::SweepPoint;

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

/// The figure `branch`: amplitude and frequency of the periodic orbits over the parameter, solid where they attract and
/// dashed where they do not, the equilibrium at amplitude zero, and the bifurcations. `settled` are the points of a
/// sweep over the same parameter, drawn as dots in the colour of their type of motion.
pub fn branch_figure(scene: &str, branch: &Branch, settled: &[SweepPoint]) -> Figure {
    let x = Axis::linear(readable(&branch.parameter, &branch.unit), branch.interval);
    let responses = || {
        settled
            .iter()
            .filter_map(|point| point.outcome.as_ref().ok())
    };
    let amplitudes = branch.points.iter().map(|point| point.orbit.amplitude);
    let amplitudes = amplitudes.chain(responses().map(|response| response.amplitude));
    let [_, highest] = extent(amplitudes.chain([0.0]));
    let unit = Unit::of("m", highest);
    let amplitude = |orbit: &PeriodicOrbit| unit.factor * orbit.amplitude;
    let mut layers = legend(branch);
    layers.extend(equilibrium(branch));
    layers.extend(lines(branch, &amplitude));
    layers.extend(dots(settled, &|response| {
        Some(unit.factor * response.amplitude)
    }));
    layers.push(rings(branch, &amplitude));
    layers.push(names(branch, &amplitude));
    let upper = Panel::new(
        "amplitude: solid if the motion attracts, dashed if not",
        x.clone(),
        Axis::linear(
            unit.after("amplitude"),
            [-0.04, 1.12].map(|y| y * unit.factor * highest),
        ),
        layers,
    );
    let frequency = |orbit: &PeriodicOrbit| 1e-3 * orbit.frequency_hz();
    let frequencies = branch.points.iter().map(|point| frequency(&point.orbit));
    let mut layers: Vec<Layer> = lines(branch, &frequency);
    // The names are in the upper panel: here they would cover the curve.
    layers.push(rings(branch, &frequency));
    let lower = Panel::new(
        "frequency of the periodic orbits",
        x.clone(),
        Axis::with_margin("frequency, kHz", frequencies),
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
        let born =
            found.find(|found| found.branch == torus.branch && found.at.value == torus.born)?;
        Some([torus.born, born.bifurcation.rotation_number?])
    });
    let births: Vec<[f64; 2]> = births.collect();
    let rotations = points().filter_map(|point| point.rotation_number);
    let shown = rotations.chain(births.iter().map(|[_, rotation]| *rotation));
    let y = Axis::with_margin("rotation number", shown);
    let mut layers = vec![
        Layer::points(births, 2.4, Color::Accent)
            .with_marker(Marker::Ring)
            .with_label("birth")
            .with_id("births"),
    ];
    let kinds = [
        (TorusKind::Torus, Color::Regime(Regime::QuasiPeriodic)),
        (TorusKind::Doubled, Color::Series(4)),
        (TorusKind::Locked, Color::Regime(Regime::Periodic)),
        (TorusKind::Irregular, Color::Regime(Regime::Chaotic)),
    ];
    for (kind, color) in kinds {
        let own = points().filter(|point| point.kind == kind);
        let places = own.filter_map(|point| Some([point.at.value, point.rotation_number?]));
        let layer = Layer::points(places.collect(), 2.4, color)
            .with_label(kind.to_string())
            .with_id(kind.to_string());
        layers.extend(Some(layer).filter(Layer::has_points));
    }
    let tongues = branch.tori.iter().flat_map(|torus| &torus.tongues);
    let bars = tongues.filter_map(|tongue| {
        let [p, q] = tongue.locking.map(f64::from);
        let [low, high] = tongue.borders;
        Some(vec![[low?, p / q], [high?, p / q]])
    });
    layers.push(
        Layer::lines(bars.collect(), Color::Regime(Regime::Periodic))
            .with_line_width(1.6)
            .with_id("tongues"),
    );
    let title = "rotation number of the tori; bars: phase-locked";
    Some(Panel::new(title, x, y, layers))
}

/// The figure `multipliers`: the Floquet multipliers of all orbits in the complex plane, and the largest magnitudes over
/// the parameter.
pub fn multipliers_figure(scene: &str, branch: &Branch) -> Figure {
    let circle = multipliers_panel(branch, None);
    let mut layers = vec![Layer::horizontal_line(1.0)];
    let magnitudes = |k: usize| {
        let points = branch.points.iter();
        points.filter_map(move |point| {
            let magnitude = point.orbit.nontrivial_multipliers().nth(k)?.magnitude();
            Some((point.branch, [point.at.value, magnitude]))
        })
    };
    for k in (0..3).rev() {
        let color = Color::Exponent(k);
        let mut strips: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut last = None;
        for (number, at) in magnitudes(k) {
            if last != Some(number) {
                strips.push(Vec::new());
                last = Some(number);
            }
            if let Some(strip) = strips.last_mut() {
                strip.push(at);
            }
        }
        let label = ["largest", "second", "third"][k];
        // Lines behind are wider, so that those of a complex pair, which coincide, remain visible.
        let line = Layer::lines(strips, color).with_line_width(1.1 + 1.1 * k as f64);
        layers.extend(
            line.last_point()
                .map(|_| line.with_label(label).with_id(label)),
        );
    }
    let marks = branch.orbit_bifurcations().map(|found| {
        let magnitude = 1.0;
        ([found.at.value, magnitude], name(found))
    });
    layers.push(Layer::peaks(marks.collect()));
    let values = (0..3).flat_map(|k| magnitudes(k).map(|(_, at)| at[1]));
    let magnitude = Panel::new(
        "magnitudes, without the trivial multiplier",
        Axis::linear(readable(&branch.parameter, &branch.unit), branch.interval),
        Axis::with_margin("magnitude", values.chain([1.0])),
        layers,
    );
    let title = format!("{scene}: Floquet multipliers");
    let rows = vec![vec![circle, magnitude]];
    Figure::new("multipliers", title, 85.0, rows)
}

/// The complex plane with the unit circle and the multipliers of all orbits, or of one of them in front of the others.
pub fn multipliers_panel(branch: &Branch, chosen: Option<&OrbitPoint>) -> Panel {
    let circle = (0..=CIRCLE).map(|k| {
        let angle = TAU * f64::from(k) / f64::from(CIRCLE);
        [angle.cos(), angle.sin()]
    });
    let mut layers = vec![
        Layer::line(circle.collect(), Color::Ink).with_id("circle"),
        Layer::lines(
            vec![
                vec![[-RADIUS, 0.0], [RADIUS, 0.0]],
                vec![[0.0, -RADIUS], [0.0, RADIUS]],
            ],
            Color::Pale,
        )
        .with_id("cross"),
    ];
    let at = |point: &OrbitPoint, is_outside: bool| -> Vec<[f64; 2]> {
        let multipliers = point.orbit.multipliers.iter();
        let chosen = multipliers.filter(|m| (m.ln_magnitude > 1e-6) == is_outside);
        chosen.map(|m| [m.re(), m.im()]).collect()
    };
    for (is_outside, color) in [(false, Color::Faint), (true, Color::Accent)] {
        let all = branch.points.iter().flat_map(|point| at(point, is_outside));
        let (radius, color) = match chosen {
            Some(_) => (0.5, Color::Pale),
            None => (0.8, color),
        };
        let id = if is_outside { "outside" } else { "inside" };
        layers.push(Layer::points(all.collect(), radius, color).with_id(format!("all {id}")));
    }
    for (is_outside, color) in [(false, Color::Ink), (true, Color::Accent)] {
        if let Some(point) = chosen {
            let id = if is_outside { "outside" } else { "inside" };
            layers.push(Layer::points(at(point, is_outside), 2.2, color).with_id(id));
        }
    }
    let axis = |name: &str| Axis::linear(name, [-RADIUS, RADIUS]);
    Panel::new(
        "multipliers in the unit circle",
        axis("real part"),
        axis("imaginary part"),
        layers,
    )
    .square()
}

/// Legend entries of the branches, if there are several.
fn legend(branch: &Branch) -> Vec<Layer> {
    let count = branch.orbit_branches();
    let keys = (0..count).filter(|_| count > 1);
    keys.map(|k| Layer::legend_entry(format!("branch {k}"), color(k)))
        .collect()
}

fn color(branch: usize) -> Color {
    BRANCH_COLORS[branch % BRANCH_COLORS.len()]
}

/// The equilibrium at amplitude zero.
fn equilibrium(branch: &Branch) -> [Layer; 2] {
    let points = branch.equilibria.iter();
    let points = points.map(|point| Some(([point.at.value, 0.0], point.unstable_modes == 0)));
    solid_and_dashed(stable_parts(points), Color::Faint, "equilibrium")
}

/// The lines of all branches.
fn lines(branch: &Branch, of: &dyn Fn(&PeriodicOrbit) -> f64) -> Vec<Layer> {
    let count = branch.orbit_branches();
    let layers = (0..count).flat_map(|number| {
        let course = branch.course(number).into_iter();
        let points = course.map(|(orbit, stable)| Some(([orbit.parameter, of(orbit)], stable)));
        solid_and_dashed(
            stable_parts(points),
            color(number),
            &format!("branch {number}"),
        )
    });
    layers.collect()
}

/// The unstable and the stable parts of a line, which is interrupted at `None`. Neighbouring parts share a point.
pub(super) fn stable_parts(
    points: impl Iterator<Item = Option<([f64; 2], bool)>>,
) -> [Vec<Vec<[f64; 2]>>; 2] {
    let mut parts: [Vec<Vec<[f64; 2]>>; 2] = [Vec::new(), Vec::new()];
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

fn solid_and_dashed(
    [unstable, stable]: [Vec<Vec<[f64; 2]>>; 2],
    color: Color,
    id: &str,
) -> [Layer; 2] {
    [
        Layer::lines(unstable, color)
            .dashed()
            .with_id(format!("{id}, unstable")),
        Layer::lines(stable, color)
            .with_line_width(1.6)
            .with_id(format!("{id}, stable")),
    ]
}

/// The settled responses of a sweep.
fn dots(
    settled: &[SweepPoint],
    of: &dyn Fn(&crate::study::response::SettledResponse) -> Option<f64>,
) -> Vec<Layer> {
    let layers = Regime::ALL.into_iter().map(|regime| {
        let points = settled.iter().filter_map(|point| {
            let response = point.outcome.as_ref().ok()?;
            let value = *point.place.values.first()?;
            (response.regime == regime).then_some([value, of(response)?])
        });
        Layer::points(points.collect(), 1.5, Color::Regime(regime))
            .with_label(format!("sweep: {regime}"))
            .with_id(format!("sweep {regime}"))
    });
    layers.filter(Layer::has_points).collect()
}

/// The bifurcations of the orbits, each with its place.
fn places(branch: &Branch, of: &dyn Fn(&PeriodicOrbit) -> f64) -> Vec<([f64; 2], String)> {
    let found = branch.orbit_bifurcations();
    let place = |found: &OrbitBifurcation| [found.at.value, of(&found.bifurcation.orbit)];
    found.map(|found| (place(found), name(found))).collect()
}

fn rings(branch: &Branch, of: &dyn Fn(&PeriodicOrbit) -> f64) -> Layer {
    let places = places(branch, of).into_iter().map(|(at, _)| at);
    Layer::points(places.collect(), 2.4, Color::Accent)
        .with_marker(Marker::Ring)
        .with_id("bifurcations")
}

fn names(branch: &Branch, of: &dyn Fn(&PeriodicOrbit) -> f64) -> Layer {
    Layer::peaks(places(branch, of))
}

/// Short name of a bifurcation with its second frequency.
fn name(found: &OrbitBifurcation) -> String {
    let kind = found.name();
    match found.bifurcation.torus_frequency_hz {
        Some(hz) => format!("{kind}, {:.2} kHz", 1e-3 * hz),
        None => kind,
    }
}
