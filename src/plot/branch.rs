//! Figures of branches over one parameter: modes of the equilibria, and the stability map over two parameters.

use super::axis::{Axis, extent, readable};
use super::color::{Color, Rgb, colormap, colormap_index};
use super::figure::{Figure, Image, Layer, Marker, Panel, Swatch};
use super::orbits::stable_parts;
use crate::analysis::range;
use crate::study::branch::{
    Branch, EquilibriumPoint, MapPoint, StabilityMap, SteadyBifurcationKind,
};

/// Height of a row of panels, mm.
const ROW_MM: f64 = 62.0;
/// Lowest growth rate of the figure of the modes, relative to the largest size of a positive one.
const LOWEST: f64 = -1.2;
/// Colour of a stable grid point, and of one without equilibrium.
const STABLE: Rgb = [226, 238, 230];
const UNKNOWN: Rgb = [245, 246, 247];
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
    let shown = |growth: f64| -> bool { growth >= lowest(points) };
    let growths = all(points, |mode| Some(mode.growth).filter(|g| shown(*g)));
    let [low, high] = extent(growths.chain([0.0]));
    let margin = 0.08 * (high - low);
    let growth_axis = Axis::linear("growth rate, 1/s", [low - margin, high + margin]);
    let growth = Panel::new(
        "growth rates of the modes of steady sliding",
        x.clone(),
        growth_axis,
        layers(branch, true),
    );
    let frequencies = all(points, |mode| Some(1e-3 * mode.frequency_hz));
    let [_, highest] = extent(frequencies);
    let frequency = Panel::new(
        "frequencies: solid if stable, dashed if unstable",
        x,
        Axis::linear("frequency, kHz", [0.0, 1.08 * highest]),
        layers(branch, false),
    );
    let title = format!("{scene}: modes of steady sliding");
    let rows = vec![vec![growth], vec![frequency]];
    Figure::new("modes", title, 2.0 * ROW_MM, rows)
}

/// The lowest growth rate shown: overdamped modes would determine the axis.
fn lowest(points: &[EquilibriumPoint]) -> f64 {
    let growths = all(points, |mode| Some(mode.growth));
    let [low, high] = range(growths);
    if high > 0.0 {
        (LOWEST * high).max(low)
    } else {
        low
    }
}

/// Values of all oscillating modes.
fn all<'a>(
    points: &'a [EquilibriumPoint],
    of: impl Fn(&crate::joint::NamedMode) -> Option<f64> + 'a,
) -> impl Iterator<Item = f64> + 'a {
    let modes = points.iter().flat_map(|point| &point.modes);
    modes
        .filter(|mode| mode.mode.frequency_hz > 0.0)
        .filter_map(move |mode| of(&mode.mode))
}

/// The lines of the modes by label, the zero line and the bifurcations, over growth rate or frequency.
fn layers(branch: &Branch, of_growth: bool) -> Vec<Layer> {
    let points = &branch.equilibria;
    let mut numbers: Vec<usize> = points
        .iter()
        .flat_map(|point| point.modes.iter().map(|mode| mode.number))
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    let mut labels: Vec<&str> = Vec::new();
    let mut layers = Vec::new();
    let mut keys = Vec::new();
    if of_growth {
        layers.push(Layer::horizontal_line(0.0));
    }
    for number in numbers {
        // A mode is named by its first point.
        let mut modes = points.iter().flat_map(|point| &point.modes);
        let Some(first) = modes.find(|mode| mode.number == number) else {
            continue;
        };
        if first.mode.frequency_hz == 0.0 {
            continue;
        }
        let label = &first.mode.label[..];
        let known = labels.iter().position(|known| *known == label);
        let index = known.unwrap_or(labels.len());
        let color = Color::Series(index);
        if known.is_none() {
            labels.push(label);
            keys.push(Layer::legend_entry(label, color));
        }
        let value = |mode: &crate::joint::NamedMode| {
            if of_growth {
                mode.growth
            } else {
                1e-3 * mode.frequency_hz
            }
        };
        let course = points.iter().map(|point| {
            let mut own = point.modes.iter().filter(|mode| mode.number == number);
            let mode = &own.find(|mode| mode.mode.frequency_hz > 0.0)?.mode;
            Some(([point.at.value, value(mode)], !mode.unstable))
        });
        let [unstable, stable] = stable_parts(course)
            .map(|strips| Layer::lines(strips, color).with_id(format!("mode {number}")));
        layers.extend([stable, unstable.dashed()]);
    }
    let marks = branch.steady_bifurcations().map(|found| {
        let y = if of_growth {
            0.0
        } else {
            1e-3 * found.frequency_hz
        };
        let kind = match found.kind {
            SteadyBifurcationKind::ZeroEigenvalue => "zero eigenvalue".to_owned(),
            kind => format!("{kind} {:.2} kHz", 1e-3 * found.frequency_hz),
        };
        ([found.at.value, y], kind)
    });
    let marks: Vec<_> = marks.collect();
    let places = marks.iter().map(|(at, _)| *at).collect();
    layers.push(Layer::points(places, 2.4, Color::Accent).with_marker(Marker::Ring));
    layers.push(Layer::peaks(marks));
    keys.into_iter().chain(layers).collect()
}

/// The figure `stability-map`: number of unstable modes and largest growth rate over two parameters, with the curves on
/// which a mode changes its stability.
pub fn map_figure(scene: &str, map: &StabilityMap) -> Figure {
    let axes = [0, 1].map(|k| {
        let axis = &map.axes[k];
        let [low, high] = range(axis.values.iter().copied());
        let half = 0.5 * (high - low) / (axis.values.len().max(2) - 1) as f64;
        Axis::linear(
            readable(&axis.parameter, &axis.unit),
            [low - half, high + half],
        )
    });
    let counts = map.grid.iter().filter_map(|point| point.unstable_modes);
    let most = counts.max().unwrap_or(0);
    let unstable = |point: &MapPoint| point.unstable_modes.map(|n| n.min(MAX_COLORS) as u8);
    let [first, step] = UNSTABLE_SHARES;
    let shades = colormap();
    let shade = |n: usize| shades[usize::from(colormap_index(first + step * n as f64))];
    let palette = (0..=MAX_COLORS).map(|n| if n == 0 { STABLE } else { shade(n) });
    let mut layers = vec![image(map, &axes, palette.collect(), &unstable)];
    layers.extend(curves(map));
    layers.extend(labels(map));
    let panel = |title: &str, layers| Panel::new(title, axes[0].clone(), axes[1].clone(), layers);
    let curves_are = if map.curves.is_empty() {
        ""
    } else {
        "; curves: Hopf points"
    };
    let title = format!("number of unstable modes (at most {most}){curves_are}");
    let mut panels = vec![panel(&title, layers)];
    let growths = map
        .grid
        .iter()
        .filter_map(|point| point.largest_growth_per_s);
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
        let palette = [STABLE].into_iter().chain(shades[..251].iter().copied());
        let mut layers = vec![image(map, &axes, palette.collect(), &growth)];
        layers.extend(curves(map));
        let title = format!("largest growth rate: {low:.0} (pale) to {high:.0} 1/s; green: stable");
        panels.push(panel(&title, layers));
    }
    let title = format!("{scene}: stability of steady sliding");
    Figure::grid("stability-map", title, 85.0, 2, &panels)
}

/// The grid as an image; the entry after the palette is for points without equilibrium.
fn image(
    map: &StabilityMap,
    axes: &[Axis; 2],
    palette: Vec<Rgb>,
    index: &dyn Fn(&MapPoint) -> Option<u8>,
) -> Layer {
    let [columns, rows] = [0, 1].map(|k| map.axes[k].values.len());
    let unknown = palette.len() as u8;
    // The upper row first.
    let pixels = (0..rows).rev().flat_map(|row| {
        let points = map.grid[row * columns..][..columns].iter();
        points.map(|point| index(point).unwrap_or(unknown))
    });
    Layer::image(Image {
        x: axes[0].range,
        y: axes[1].range,
        size: [columns, rows],
        pixels: pixels.collect(),
        palette: palette
            .into_iter()
            .chain([UNKNOWN])
            .map(Swatch::uniform)
            .collect(),
    })
}

/// The Hopf curves, by mode.
fn curves(map: &StabilityMap) -> Vec<Layer> {
    let mut labels: Vec<&str> = map.curves.iter().map(|curve| &curve.label[..]).collect();
    labels.sort_unstable();
    labels.dedup();
    let layers = labels.iter().enumerate().map(|(k, label)| {
        let own = map.curves.iter().filter(|curve| curve.label == *label);
        let strips = own.map(|curve| curve.points.iter().map(|point| point.values).collect());
        Layer::lines(strips.collect(), Color::Series(k))
            .with_line_width(1.6)
            .with_label(*label)
            .with_id(format!("curve {k}"))
    });
    let tori = map.torus_curves.iter();
    let tori = tori.map(|curve| curve.points.iter().map(|point| point.values).collect());
    let tori: Vec<_> = tori.collect();
    let torus = (!tori.is_empty()).then(|| {
        Layer::lines(tori, Color::Ink)
            .dashed()
            .with_line_width(1.6)
            .with_label("birth of a torus")
            .with_id("torus curves")
    });
    layers.chain(torus).collect()
}

/// The number of unstable modes as text, once in each connected region, at the point farthest from its border.
fn labels(map: &StabilityMap) -> Vec<Layer> {
    let [columns, rows] = [0, 1].map(|k| map.axes[k].values.len());
    let count = |k: usize| map.grid[k].unstable_modes;
    let mut region = vec![None; columns * rows];
    let mut layers = Vec::new();
    for start in 0..columns * rows {
        if region[start].is_some() || count(start).is_none() {
            continue;
        }
        let mut members = vec![start];
        region[start] = Some(start);
        let mut next = 0;
        while let Some(&here) = members.get(next) {
            next += 1;
            for near in neighbours(here, columns, rows) {
                if region[near].is_none() && count(near) == count(start) {
                    region[near] = Some(start);
                    members.push(near);
                }
            }
        }
        // Regions of a few points have no room for a text.
        if members.len() < columns * rows / 60 {
            continue;
        }
        let inner = members
            .iter()
            .max_by_key(|k| depth(**k, columns, rows, &count));
        if let (Some(&k), Some(n)) = (inner, count(start)) {
            let at = [
                map.axes[0].values[k % columns],
                map.axes[1].values[k / columns],
            ];
            layers.push(Layer::text(at, n.to_string()));
        }
    }
    layers
}

fn neighbours(k: usize, columns: usize, rows: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (k % columns, k / columns);
    let near = [
        (x > 0).then(|| k - 1),
        (x + 1 < columns).then_some(k + 1),
        (y > 0).then(|| k - columns),
        (y + 1 < rows).then_some(k + columns),
    ];
    near.into_iter().flatten()
}

/// Distance of a point from the border of its region, in points.
fn depth(k: usize, columns: usize, rows: usize, count: &dyn Fn(usize) -> Option<usize>) -> usize {
    let (x, y) = ((k % columns) as isize, (k / columns) as isize);
    let is_inside = |radius: isize| {
        let span = || -radius..=radius;
        span()
            .flat_map(|dx| span().map(move |dy| (x + dx, y + dy)))
            .all(|(x, y)| {
                let on_grid = (0..columns as isize).contains(&x) && (0..rows as isize).contains(&y);
                on_grid && count(y as usize * columns + x as usize) == count(k)
            })
    };
    (1..).take_while(|radius| is_inside(*radius)).count()
}
