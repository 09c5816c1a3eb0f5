//! Figures of a sweep: bifurcation diagram, exponents and spectral lines over one parameter, or a map of
//! regimes over two. Fig. 11 of the paper.

use std::ops::Range;

use strum::VariantArray as _;

use super::axis::readable;
use super::color::{colormap, colormap_index};
use super::figure::regime_legend;
use super::{Axis, Color, Figure, Layer, Marker, Panel, Rgb};
use crate::analysis::{regime::Regime, stats::range};
use crate::dynamics::Exponent;
use crate::study::response::SettledResponse;
use crate::study::sweep::{self, Start, SweepPlan, SweepPoint};

/// Number of exponents in a figure.
const EXPONENTS: usize = 3;
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

/// The panels over one parameter.
struct ParameterPanels<'a> {
    axis: Axis,
    /// The starts shown.
    starts: Vec<Start>,
    /// Start, place on the axis, and response of each point, also of starts that are not shown.
    found: Vec<(Start, f64, &'a SettledResponse)>,
    /// Parameters between two points of a start shown at which the motion doubles.
    doublings: Vec<f64>,
}

/// All figures of a sweep: `bifurcation` over one parameter, with all starts in each panel; `regimes-START`
/// for each start of a sweep over two parameters. Points that are not computed yet are omitted.
pub fn sweep_figures(plan: &SweepPlan, points: &[SweepPoint]) -> Vec<Figure> {
    if let [_] = &plan.axes[..] {
        let shared = ParameterPanels::new(plan, points, &plan.starts);
        let mut rows = vec![vec![shared.maxima()], vec![shared.lines()]];
        rows.extend(shared.exponents(EXPONENTS).map(|panel| vec![panel]));
        let starts: Vec<String> = plan.starts.iter().map(Start::to_string).collect();
        let starts = match plan.starts[..] {
            [start] => start_label(start).to_owned(),
            _ => format!("starts {}", starts.join(", ")),
        };
        let title = format!("{}: {starts}", plan.subject.name);
        let height = ROW_MM * rows.len() as f64;
        return vec![Figure::new("bifurcation", title, height, rows)];
    }
    let starts = plan.starts.iter();
    starts.map(|start| map(plan, *start, points)).collect()
}

/// Fig. 11: exponents, bifurcation diagram and spectral lines over the tilt.
pub fn bifurcation(plan: &SweepPlan, points: &[SweepPoint]) -> Figure {
    let shared = ParameterPanels::new(plan, points, &plan.starts);
    // The caption names the panels by their letters.
    let panels = [
        ("a", shared.exponents(EXPONENTS)),
        ("b", Some(shared.maxima())),
        ("c", Some(shared.lines())),
    ];
    let rows = panels.into_iter().filter_map(|(letter, panel)| {
        let panel = panel?;
        let title = format!("{letter}: {}", panel.title);
        Some(vec![Panel { title, ..panel }])
    });
    let rows: Vec<Vec<Panel>> = rows.collect();
    let height = ROW_MM * rows.len() as f64;
    let starts: Vec<&str> = plan.starts.iter().copied().map(start_label).collect();
    let starts = starts.join(", ");
    let title = format!("Fig. 11: Lyapunov exponents and bifurcation diagram, {starts}");
    Figure::new("figure-11", title, height, rows)
}

/// The bifurcation diagram of one start, on axes that are the same for all starts; recordings use it.
pub fn maxima(plan: &SweepPlan, points: &[SweepPoint], start: Start) -> Panel {
    ParameterPanels::new(plan, points, &[start]).maxima()
}

/// The exponents of one start, on axes that are the same for all starts; `None` without any. Recordings use it.
pub fn exponents(plan: &SweepPlan, points: &[SweepPoint], start: Start) -> Option<Panel> {
    ParameterPanels::new(plan, points, &[start]).exponents(usize::MAX)
}

/// Name of the way in which points are started.
pub fn start_label(start: Start) -> &'static str {
    match start {
        Start::Fresh => "fresh starts",
        Start::Upward => "upward continuation",
        Start::Downward => "downward continuation",
    }
}

/// The points of one start with a response.
fn found(
    points: &[SweepPoint],
    start: Start,
) -> impl Iterator<Item = (&[f64], &SettledResponse)> + Clone {
    let of_start = points
        .iter()
        .filter(move |point| point.place.start == start);
    of_start.filter_map(|point| Some((&point.place.values[..], point.found()?)))
}

/// The axis of a parameter.
fn parameter_axis(axis: &sweep::Axis) -> Axis {
    Axis::cells(readable(&axis.name, axis.unit()), &axis.values)
}

impl<'a> ParameterPanels<'a> {
    /// The panels of the starts shown, side by side within a step of the parameter.
    fn new(plan: &SweepPlan, points: &'a [SweepPoint], starts: &[Start]) -> Self {
        let axis = parameter_axis(&plan.axes[0]);
        let [low, high] = axis.range;
        let step = (high - low) / plan.axes[0].values.len().max(1) as f64;
        let apart = OFFSET * step / starts.len() as f64;
        let middle = 0.5 * (starts.len() as f64 - 1.0);
        let found = plan.starts.iter().flat_map(|&start| {
            let place = starts.iter().position(|shown| *shown == start);
            let shift = place.map_or(0.0, |k| apart * (k as f64 - middle));
            found(points, start).map(move |(values, response)| (start, values[0] + shift, response))
        });
        let doublings = sweep::transitions(points).into_iter();
        let doublings = doublings.filter(|t| t.doubling.is_some() && starts.contains(&t.start));
        Self {
            axis,
            starts: starts.to_vec(),
            found: found.collect(),
            doublings: doublings.map(|t| 0.5 * (t.from + t.to)).collect(),
        }
    }

    /// The marker of a start, if there are several.
    fn marker(&self, start: Start) -> Marker {
        match start {
            Start::Upward if self.starts.len() > 1 => Marker::Up,
            Start::Downward if self.starts.len() > 1 => Marker::Down,
            _ => Marker::Dot,
        }
    }

    /// Legend entries of the starts, if there are several.
    fn start_legend(&self) -> Vec<Layer> {
        let starts = self.starts.iter().filter(|_| self.starts.len() > 1);
        let entry = |start: &Start| Layer::legend_entry(start.to_string(), Color::Ink);
        let keys = starts.map(|start| entry(start).with_marker(self.marker(*start)));
        keys.collect()
    }

    /// Points with the markers of their starts; `of` returns the ordinates of a response.
    fn points<I: IntoIterator<Item = f64>>(
        &self,
        radius: f64,
        color: Color,
        of: impl Fn(&'a SettledResponse) -> I,
    ) -> Vec<Layer> {
        let layers = self.starts.iter().map(|shown| {
            let found = self.found.iter().filter(|(start, ..)| start == shown);
            let points = found.flat_map(|(_, x, found)| of(found).into_iter().map(|y| [*x, y]));
            let points = Layer::points(points.collect(), radius, color);
            points.with_marker(self.marker(*shown))
        });
        layers.filter(Layer::has_points).collect()
    }

    /// A vertical line at each doubling, the last with the legend entry.
    fn doublings(&self) -> impl Iterator<Item = Layer> {
        let places = self.doublings.iter().enumerate();
        places.map(|(k, place)| {
            let is_last = k + 1 == self.doublings.len();
            let line = Layer::vertical_line(*place, Color::Ink);
            line.with_label(if is_last { "doubling" } else { "" })
        })
    }

    /// The maxima of the displacement in the colour of the regime.
    fn maxima(&self) -> Panel {
        let all = self
            .found
            .iter()
            .flat_map(|(.., found)| maxima_or_zero(found));
        let y = Axis::with_margin("maximum", all).of("m");
        let points = Regime::VARIANTS.iter().flat_map(|&regime| {
            // The few points of a periodic motion are larger, so that they are visible.
            [(false, 0.7), (true, 1.7)]
                .into_iter()
                .flat_map(move |(few, radius)| {
                    self.points(radius, Color::Regime(regime), move |response| {
                        let chosen =
                            response.regime == regime && has_few(&response.maxima_m) == few;
                        maxima_or_zero(response).filter(move |_| chosen)
                    })
                })
        });
        let points: Vec<Layer> = points.collect();
        let shows = |regime| {
            points
                .iter()
                .any(|layer| layer.color == Color::Regime(regime))
        };
        let mut layers: Vec<Layer> = regime_legend(shows).collect();
        layers.extend(self.start_legend());
        layers.extend(self.doublings());
        layers.extend(points);
        let title = "local maxima of the displacement";
        Panel::new(title, self.axis.clone(), y, layers)
    }

    /// The largest exponents, at most `most`, with their intervals; `None` without any.
    fn exponents(&self, most: usize) -> Option<Panel> {
        let kth = |response: &SettledResponse, k: usize| -> Option<Exponent> {
            response.exponents.as_ref()?.exponents.get(k).copied()
        };
        let all = |k: usize| {
            let found = self.found.iter();
            found.filter_map(move |(start, x, response)| Some((*start, *x, kth(response, k)?)))
        };
        all(0).next()?;
        let mut layers = vec![Layer::horizontal_line(0.0)];
        let numbers = || (0..most).take_while(|k| all(*k).next().is_some());
        let entry = |k| Layer::legend_entry(format!("λ{}", k + 1), Color::Exponent(k));
        layers.extend(numbers().map(entry));
        layers.extend(self.start_legend());
        // The largest exponent is drawn last with the smallest marker, so that equal exponents remain
        // visible.
        for k in (0..numbers().count()).rev() {
            let color = Color::Exponent(k);
            let shown = all(k).filter(|(start, ..)| self.starts.contains(start));
            let spans = shown.map(|(_, x, exponent)| [x, exponent.low(), exponent.high()]);
            layers.push(Layer::intervals(spans, color));
            let radius = 1.6 + 0.8 * k as f64;
            let points = self.points(radius, color, |found| kth(found, k).map(|e| e.value));
            let id = format!("exponent-{}", k + 1);
            layers.extend(points.into_iter().map(|points| points.with_id(&*id)));
        }
        let shown = numbers().flat_map(all).map(|(.., exponent)| exponent);
        let y = Axis::with_margin("exponent, 1/s", exponent_axis_values(shown).chain([0.0]));
        let title = "largest Lyapunov exponents with 95 % intervals";
        Some(Panel::new(title, self.axis.clone(), y, layers))
    }

    /// The frequencies of the spectral lines; stronger lines have larger points.
    fn lines(&self) -> Panel {
        // From strong to weak: amplitudes relative to the strongest, radius, colour.
        let kinds = [
            (0.5..f64::INFINITY, 2.4, Color::Ink),
            (0.1..0.5, 1.6, Color::Faint),
            (FAINTEST..0.1, 1.0, Color::Regime(Regime::Undetermined)),
        ];
        let frequencies = |response: &'a SettledResponse, shares: Range<f64>| {
            let strongest = response
                .lines
                .first()
                .map_or(f64::INFINITY, |line| line.amplitude);
            let lines = response.lines.iter();
            let lines = lines.filter(move |line| shares.contains(&(line.amplitude / strongest)));
            lines.map(|line| line.frequency)
        };
        let mut layers: Vec<Layer> = Vec::new();
        layers.extend(kinds.iter().map(|(shares, _, color)| {
            Layer::legend_entry(format!("from {:.0} %", 100.0 * shares.start), *color)
        }));
        layers.extend(self.start_legend());
        layers.extend(self.doublings());
        for (shares, radius, color) in kinds {
            layers.extend(self.points(radius, color, |found| frequencies(found, shares.clone())));
        }
        let shown = self.found.iter();
        let shown = shown.flat_map(|(.., found)| frequencies(found, FAINTEST..f64::INFINITY));
        let [_, highest] = range(shown.chain([100.0]));
        let y = Axis::linear("frequency", [0.0, 1.08 * highest]).of("Hz");
        let title = "spectral lines by amplitude relative to the strongest";
        Panel::new(title, self.axis.clone(), y, layers)
    }
}

/// The values that an axis of exponents must contain: the exponents and the near parts of their intervals.
fn exponent_axis_values(exponents: impl Iterator<Item = Exponent>) -> impl Iterator<Item = f64> {
    let ends = exponents.flat_map(|e| {
        let low = e.low().max(e.value - INTERVAL);
        [e.value, low, e.high().min(e.value + INTERVAL)]
    });
    ends.filter(|value| value.is_finite() && *value > SMALLEST_EXPONENT)
}

/// The maxima of a response, m; a joint at rest has one, at zero.
fn maxima_or_zero(response: &SettledResponse) -> impl Iterator<Item = f64> + '_ {
    let rests = response.maxima_m.is_empty().then_some(0.0);
    response.maxima_m.iter().copied().chain(rests)
}

/// Whether the maxima take only a few distinct values.
fn has_few(maxima: &[f64]) -> bool {
    let [low, high] = range(maxima.iter().copied());
    let size = high.abs().max(low.abs());
    let mut sorted = maxima.to_vec();
    sorted.sort_by(f64::total_cmp);
    let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    gaps.map(|gap| gap.min(0.01 * size)).sum::<f64>() < 0.05 * size
}

/// Maps of the regime and of the largest exponent over two parameters.
fn map(plan: &SweepPlan, start: Start, points: &[SweepPoint]) -> Figure {
    let axes = [&plan.axes[0], &plan.axes[1]];
    let [columns, rows] = axes.map(|axis| axis.values.len());
    let [x, y] = axes.map(parameter_axis);
    let points = points.iter().filter(|point| point.place.start == start);
    let found = points.filter_map(|point| Some((&point.place, point.found()?)));
    let image = |palette: &[Rgb], color: &dyn Fn(&SettledResponse) -> Option<u8>| {
        // The first axis varies fastest.
        let mut cells = vec![None; columns * rows];
        for (place, response) in found.clone() {
            cells[place.index % (columns * rows)] = color(response);
        }
        Layer::cells([&x, &y], columns, &cells, palette.iter().copied())
    };
    let panel = |title: String, layers| Panel::new(title, x.clone(), y.clone(), layers);
    let colors = Regime::VARIANTS.iter();
    let colors: Vec<_> = colors
        .map(|regime| Color::Regime(*regime).on_light())
        .collect();
    // The palette is in the order of the variants.
    let regimes = image(&colors, &|response| Some(response.regime as u8));
    let keys = regime_legend(|regime| found.clone().any(|(_, found)| found.regime == regime));
    let unsettled = found.clone().filter(|(_, response)| !response.settled);
    let unsettled = unsettled.map(|(place, _)| [place.values[0], place.values[1]]);
    let crosses = Layer::points(unsettled.collect(), 2.0, Color::Ink).with_marker(Marker::Cross);
    let crosses = crosses.with_label("not in steady state");
    let crosses = Some(crosses).filter(Layer::has_points);
    let layers = [regimes].into_iter().chain(keys).chain(crosses);
    let mut panels = vec![panel("type of motion".to_owned(), layers.collect())];
    let largest = |response: &SettledResponse| {
        let spectrum = response.exponents.as_ref()?;
        spectrum.exponents.first().map(|e| e.value)
    };
    let values = || found.clone().filter_map(|(_, response)| largest(response));
    let [_, most] = range(values().chain([1.0]));
    if values().next().is_some() {
        let image = image(&colormap()[..255], &|response| {
            largest(response).map(|value| colormap_index(value.max(0.0) / most).min(254))
        });
        let title = format!("largest exponent: pale is 0 or negative, black {most:.0} 1/s");
        panels.push(panel(title, vec![image]));
    }
    let title = format!("{}: {}", plan.subject.name, start_label(start));
    let mut figure = Figure::grid(format!("regimes-{start}"), title, 75.0, 1, panels);
    figure.size_mm[0] = 160.0;
    figure
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
