//! Figures of branches over one parameter: modes of the equilibria, and the stability map over two parameters.

use std::collections::{BTreeMap, BTreeSet};

use super::axis::{Axis, extent, lowest_growth, readable};
use super::color::{Color, Rgb, colormap, colormap_index};
use super::figure::{Figure, Layer, Panel};
use super::orbits::{ROW_MM, stability_lines};
use crate::analysis::stats::range;
use crate::joint::NamedMode;
use crate::study::branch::{
    Branch, Curve, EquilibriumPoint, MapPoint, StabilityMap, SteadyBifurcationKind,
};

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
    Figure::grid("stability-map", title, 85.0, 2, &panels)
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
