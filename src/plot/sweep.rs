//! Figures of a sweep: bifurcation diagram, exponents and spectral lines over one parameter, or a map of
//! regimes over two. Fig. 11 of the paper.

use super::axis::{Axis, extent, readable};
use super::color::{Color, Rgb, colormap, colormap_index};
use super::figure::{Figure, Image, Layer, Marker, Panel, Swatch};
use super::unit::Unit;
use crate::analysis::{Regime, range};
use crate::dynamics::Exponent;
use crate::study::response::SettledResponse;
use crate::study::sweep::{self, Start, SweepPlan, SweepPoint};

/// Number of exponents shown.
const EXPONENTS: usize = 3;
/// Colour of a point that is not computed.
const UNKNOWN: Rgb = [245, 246, 247];
/// Lines weaker than this fraction of the strongest are not drawn.
const FAINTEST: f64 = 0.02;
/// Offset between the points of different starts, as a fraction of a step.
const OFFSET: f64 = 0.36;
/// Largest half-width of an interval that the axis must contain, and smallest exponent, 1/s. An exponent
/// averaged over a short time would otherwise determine the axis.
const INTERVAL: f64 = 40.0;
const SMALLEST_EXPONENT: f64 = -250.0;
/// Height of a row of panels, mm.
const ROW_MM: f64 = 50.0;

/// A response and its place in the sweep.
#[derive(Clone, Copy)]
struct Point<'a> {
    values: &'a [f64],
    start: Start,
    response: &'a SettledResponse,
}

/// The panels over one parameter: their axis, the responses, and the starts.
struct ParameterPanels<'a> {
    axis: Axis,
    /// The starts shown, and the offset of each along the axis.
    starts: Vec<(Start, f64)>,
    found: Vec<Point<'a>>,
    /// Starts, and parameters between two points, at which the motion doubles.
    doublings: Vec<(Start, f64)>,
}

/// All figures of a sweep: `bifurcation` over one parameter, with all starts in each panel; `regimes-START`
/// for each start of a sweep over two parameters. Points that are not computed yet are omitted.
pub fn sweep_figures(plan: &SweepPlan, points: &[SweepPoint]) -> Vec<Figure> {
    if let [_] = &plan.axes[..] {
        let shared = ParameterPanels::new(plan, points);
        let mut rows = vec![vec![shared.maxima()], vec![shared.lines()]];
        if shared
            .found
            .iter()
            .any(|found| found.response.exponents.is_some())
        {
            rows.push(vec![shared.exponents()]);
        }
        let starts = match &plan.starts[..] {
            [start] => start_label(*start).to_owned(),
            starts => {
                let starts: Vec<String> = starts.iter().map(Start::to_string).collect();
                format!("starts {}", starts.join(", "))
            }
        };
        let title = format!("{}: {starts}", plan.scene.name);
        let height = ROW_MM * rows.len() as f64;
        return vec![Figure::new("bifurcation", title, height, rows)];
    }
    let starts = plan.starts.iter();
    starts
        .map(|&start| map(plan, start, &found(points, start)))
        .collect()
}

/// Fig. 11: exponents, bifurcation diagram and spectral lines over the tilt.
pub fn bifurcation(plan: &SweepPlan, points: &[SweepPoint]) -> Figure {
    let shared = ParameterPanels::new(plan, points);
    let panels = [shared.exponents(), shared.maxima(), shared.lines()];
    let rows = panels.into_iter().zip(["a", "b", "c"]);
    let rows = rows.map(|(panel, letter)| {
        let title = format!("{letter}: {}", panel.title);
        vec![Panel { title, ..panel }]
    });
    let starts: Vec<&str> = plan
        .starts
        .iter()
        .map(|start| start_label(*start))
        .collect();
    let title = format!(
        "Fig. 11: Lyapunov exponents and bifurcation diagram, {}",
        starts.join(", ")
    );
    Figure::new("figure-11", title, 3.0 * ROW_MM, rows.collect())
}

/// The bifurcation diagram of one start, on axes that are the same for all starts; recordings use it.
pub fn maxima(plan: &SweepPlan, points: &[SweepPoint], start: Start) -> Panel {
    let mut shared = ParameterPanels::new(plan, points);
    shared.starts = vec![(start, 0.0)];
    shared.maxima()
}

/// Name of the way in which points are started.
pub fn start_label(start: Start) -> &'static str {
    match start {
        Start::Fresh => "fresh starts",
        Start::Upward => "upward continuation",
        Start::Downward => "downward continuation",
    }
}

/// The marker of a start.
fn marker(start: Start) -> Marker {
    match start {
        Start::Fresh => Marker::Dot,
        Start::Upward => Marker::Up,
        Start::Downward => Marker::Down,
    }
}

/// The responses of one start.
fn found(points: &[SweepPoint], start: Start) -> Vec<Point<'_>> {
    let of_start = points.iter().filter(|point| point.place.start == start);
    let found = of_start.filter_map(|point| {
        Some(Point {
            values: &point.place.values,
            start,
            response: point.outcome.as_ref().ok()?,
        })
    });
    found.collect()
}

/// Half a step of an axis.
fn half_step(axis: &sweep::Axis) -> f64 {
    let [low, high] = range(axis.values().iter().copied());
    match axis.values().len() {
        0 | 1 => 0.5,
        count => 0.5 * (high - low) / (count - 1) as f64,
    }
}

/// The axis of a parameter, extended by half a step at each end.
fn parameter_axis(axis: &sweep::Axis) -> Axis {
    let [low, high] = range(axis.values().iter().copied());
    let half = half_step(axis);
    let parameter = axis.parameter();
    let name = readable(parameter.path(), parameter.unit());
    Axis::linear(name, [low - half, high + half])
}

impl<'a> ParameterPanels<'a> {
    fn new(plan: &SweepPlan, points: &'a [SweepPoint]) -> Self {
        let axis = &plan.axes[0];
        let apart = 2.0 * OFFSET * half_step(axis) / plan.starts.len() as f64;
        let middle = 0.5 * (plan.starts.len() as f64 - 1.0);
        let starts = (0..).zip(&plan.starts);
        let doublings = sweep::transitions(points).into_iter();
        let doublings = doublings.filter_map(|transition| {
            let middle = 0.5 * (transition.from + transition.to);
            let doubles = transition.doubling.is_some();
            doubles.then_some((transition.start, middle))
        });
        Self {
            doublings: doublings.collect(),
            axis: parameter_axis(axis),
            starts: starts
                .map(|(k, start)| (*start, apart * (f64::from(k) - middle)))
                .collect(),
            found: plan
                .starts
                .iter()
                .flat_map(|start| found(points, *start))
                .collect(),
        }
    }

    /// Legend entries of the starts, if there are several.
    fn start_legend(&self) -> Vec<Layer> {
        let starts = self.starts.iter().filter(|_| self.starts.len() > 1);
        let keys = starts.map(|(start, _)| {
            Layer::legend_entry(start.to_string(), Color::Ink).with_marker(marker(*start))
        });
        keys.collect()
    }

    /// Points with the markers and offsets of their starts; `of` returns the ordinates of a response.
    fn points<I: IntoIterator<Item = f64>>(
        &self,
        radius: f64,
        color: Color,
        of: impl Fn(&Point<'a>) -> I,
    ) -> Vec<Layer> {
        let layers = self.starts.iter().map(|(start, shift)| {
            let found = self.found.iter().filter(|found| found.start == *start);
            let points = found.flat_map(|found| {
                let heights = of(found).into_iter();
                heights.map(|y| [found.values[0] + shift, y])
            });
            let form = if self.starts.len() > 1 {
                marker(*start)
            } else {
                Marker::Dot
            };
            Layer::points(points.collect(), radius, color).with_marker(form)
        });
        layers.filter(Layer::has_points).collect()
    }

    /// A vertical line at each doubling of the starts shown, the last with the legend entry.
    fn doublings(&self) -> Vec<Layer> {
        let shown = |start: &Start| self.starts.iter().any(|(own, _)| own == start);
        let shown = self.doublings.iter().filter(|(start, _)| shown(start));
        let mut layers: Vec<Layer> = shown
            .map(|(_, middle)| Layer::vertical_line(*middle, Color::Ink))
            .collect();
        if let Some(last) = layers.last_mut() {
            last.label = "doubling".to_owned();
        }
        layers
    }

    /// The maxima of the displacement in the colour of the regime.
    fn maxima(&self) -> Panel {
        let all = self
            .found
            .iter()
            .flat_map(|found| maxima_or_zero(found.response));
        let [low, high] = extent(all);
        let unit = Unit::of("m", low.abs().max(high.abs()));
        let mut keys = Vec::new();
        let mut layers = Vec::new();
        for regime in Regime::ALL {
            let color = Color::Regime(regime);
            let before = layers.len();
            // The few points of a periodic motion are larger, so that they are visible.
            for (few, radius) in [(false, 0.7), (true, 1.7)] {
                layers.extend(self.points(radius, color, |found| {
                    let response = found.response;
                    let chosen = response.regime == regime && has_few(&response.maxima) == few;
                    let tops = maxima_or_zero(response).map(|top| unit.factor * top);
                    tops.filter(move |_| chosen)
                }));
            }
            if layers.len() > before {
                keys.push(Layer::legend_entry(regime.to_string(), color));
            }
        }
        keys.extend(self.start_legend());
        keys.extend(self.doublings());
        keys.extend(layers);
        let drawn = [low, high].map(|top| unit.factor * top);
        Panel::new(
            "local maxima of the displacement",
            self.axis.clone(),
            Axis::with_margin(unit.after("maximum"), drawn.into_iter()),
            keys,
        )
    }

    /// The largest exponents with their intervals.
    fn exponents(&self) -> Panel {
        let kth = |found: &Point<'a>, k: usize| -> Option<Exponent> {
            found.response.exponents.as_ref()?.exponents.get(k).copied()
        };
        let mut layers = vec![Layer::horizontal_line(0.0)];
        let there = |k: &usize| self.found.iter().any(|found| kth(found, *k).is_some());
        let numbers: Vec<usize> = (0..EXPONENTS).filter(there).collect();
        let keys = numbers
            .iter()
            .map(|k| Layer::legend_entry(format!("λ{}", k + 1), Color::Exponent(*k)));
        layers.extend(keys);
        layers.extend(self.start_legend());
        // The largest exponent is drawn last with the smallest marker, so that equal exponents remain
        // visible.
        for &k in numbers.iter().rev() {
            let color = Color::Exponent(k);
            let shift = |start| {
                self.starts
                    .iter()
                    .find(|(own, _)| *own == start)
                    .map_or(0.0, |s| s.1)
            };
            let spans = self.found.iter().filter_map(|found| {
                let exponent = kth(found, k)?;
                let x = found.values[0] + shift(found.start);
                Some([x, exponent.low(), exponent.high()])
            });
            layers.push(Layer::intervals(&spans.collect::<Vec<_>>(), color));
            let radius = 1.6 + 0.8 * k as f64;
            layers.extend(self.points(radius, color, |found| kth(found, k).map(|e| e.value)));
        }
        let shown = self
            .found
            .iter()
            .flat_map(|found| (0..EXPONENTS).filter_map(|k| kth(found, k)));
        Panel::new(
            "largest Lyapunov exponents with 95 % intervals",
            self.axis.clone(),
            Axis::with_margin("exponent, 1/s", exponent_axis_values(shown).chain([0.0])),
            layers,
        )
    }

    /// The frequencies of the spectral lines; stronger lines have larger points.
    fn lines(&self) -> Panel {
        // From strong to weak: amplitude relative to the strongest, radius, colour.
        let kinds = [
            (0.5, 2.4, Color::Ink),
            (0.1, 1.6, Color::Faint),
            (FAINTEST, 1.0, Color::Regime(Regime::Undetermined)),
        ];
        let strongest = |response: &SettledResponse| {
            let first = response.lines.first();
            first.map_or(f64::INFINITY, |line| line.amplitude)
        };
        let mut keys = Vec::new();
        let mut layers = Vec::new();
        let mut upper = f64::INFINITY;
        for (least, radius, color) in kinds {
            layers.extend(self.points(radius, color, |found| {
                let strongest = strongest(found.response);
                let chosen = found.response.lines.iter().filter(move |line| {
                    let share = line.amplitude / strongest;
                    share >= least && share < upper
                });
                chosen.map(|line| 1e-3 * line.frequency)
            }));
            upper = least;
            keys.push(Layer::legend_entry(
                format!("from {:.0} %", 100.0 * least),
                color,
            ));
        }
        let highest = self.found.iter().flat_map(|found| {
            let weakest = FAINTEST * strongest(found.response);
            let lines = found.response.lines.iter();
            let strong = lines.filter(move |line| line.amplitude >= weakest);
            strong.map(|line| 1e-3 * line.frequency)
        });
        let [_, highest] = range(highest.chain([0.1]));
        keys.extend(self.start_legend());
        keys.extend(self.doublings());
        keys.extend(layers);
        Panel::new(
            "spectral lines by amplitude relative to the strongest",
            self.axis.clone(),
            Axis::linear("frequency, kHz", [0.0, 1.08 * highest]),
            keys,
        )
    }
}

/// The values that an axis of exponents must contain: the exponents and the near parts of their intervals.
pub fn exponent_axis_values(
    exponents: impl Iterator<Item = Exponent>,
) -> impl Iterator<Item = f64> {
    let ends = exponents.flat_map(|e| {
        let low = e.low().max(e.value - INTERVAL);
        [e.value, low, e.high().min(e.value + INTERVAL)]
    });
    ends.filter(|value| value.is_finite() && *value > SMALLEST_EXPONENT)
}

/// The maxima of a response, m; a joint at rest has one, at zero.
fn maxima_or_zero(response: &SettledResponse) -> impl Iterator<Item = f64> + '_ {
    let rests = response.maxima.is_empty().then_some(0.0);
    response.maxima.iter().copied().chain(rests)
}

/// Whether the maxima take only a few distinct values.
fn has_few(maxima: &[f64]) -> bool {
    const FEW: usize = 6;
    let [low, high] = range(maxima.iter().copied());
    let size = high.abs().max(low.abs());
    let mut sorted = maxima.to_vec();
    sorted.sort_by(f64::total_cmp);
    let gaps = || sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let spread: f64 = gaps().map(|gap| gap.min(0.01 * size)).sum();
    gaps().filter(|gap| *gap > 0.01 * size).count() < FEW && spread < 0.05 * size
}

/// Maps of the regime and of the largest exponent over two parameters.
fn map(plan: &SweepPlan, start: Start, found: &[Point<'_>]) -> Figure {
    let axes = [&plan.axes[0], &plan.axes[1]];
    let [columns, rows] = axes.map(|axis| axis.values().len());
    let [x, y] = axes.map(parameter_axis);
    // Index of the pixel of a point; the upper row first.
    let pixel = |found: &Point<'_>| {
        let place = |k: usize| axes[k].values().iter().position(|v| *v == found.values[k]);
        Some((rows - 1 - place(1)?) * columns + place(0)?)
    };
    let image = |palette: Vec<Rgb>, color: &dyn Fn(&SettledResponse) -> Option<u8>| {
        // The last palette entry is for points that are not computed.
        let mut pixels = vec![palette.len() as u8; columns * rows];
        for found in found {
            if let (Some(pixel), Some(color)) = (pixel(found), color(found.response)) {
                pixels[pixel] = color;
            }
        }
        let palette = palette.into_iter().chain([UNKNOWN]);
        Layer::image(Image {
            x: x.range,
            y: y.range,
            size: [columns, rows],
            pixels,
            palette: palette.map(Swatch::uniform).collect(),
        })
    };
    let panel = |title: String, layers| Panel::new(title, x.clone(), y.clone(), layers);
    let place = |regime: Regime| Regime::ALL.iter().position(|one| *one == regime);
    let colors = Regime::ALL.map(|regime| Color::Regime(regime).on_light());
    let regimes = image(colors.to_vec(), &|response| {
        Some(place(response.regime)? as u8)
    });
    let there = |regime: &Regime| found.iter().any(|point| point.response.regime == *regime);
    let there = Regime::ALL.into_iter().filter(there);
    let keys = there.map(|regime| Layer::legend_entry(regime.to_string(), Color::Regime(regime)));
    let unsettled = found.iter().filter(|point| !point.response.settled);
    let unsettled = unsettled.map(|point| [point.values[0], point.values[1]]);
    let crosses = Layer::points(unsettled.collect(), 2.0, Color::Ink).with_marker(Marker::Cross);
    let crosses = crosses.with_label("not in steady state");
    let crosses = Some(crosses).filter(Layer::has_points);
    let layers = { [regimes].into_iter() }
        .chain(keys)
        .chain(crosses)
        .collect();
    let title = "type of motion".to_owned();
    let mut panels = vec![panel(title, layers)];
    let largest = |response: &SettledResponse| {
        let spectrum = response.exponents.as_ref()?;
        spectrum.exponents.first().map(|e| e.value)
    };
    let values = found.iter().filter_map(|point| largest(point.response));
    let [_, most] = range(values.chain([1.0]));
    if found.iter().any(|point| largest(point.response).is_some()) {
        // The last palette entry is for points that are not computed.
        let shades = colormap()[..255].to_vec();
        let image = image(shades, &|response| {
            largest(response).map(|value| colormap_index(value.max(0.0) / most).min(254))
        });
        let title = format!("largest exponent: pale is 0 or negative, black {most:.0} 1/s");
        panels.push(panel(title, vec![image]));
    }
    let title = format!("{}: {}", plan.scene.name, start_label(start));
    Figure::grid(format!("regimes-{start}"), title, 75.0, 1, &panels).with_width(160.0)
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
