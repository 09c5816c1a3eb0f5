//! Figures of a sweep: bifurcation diagram, exponents and spectral lines over one parameter, or a map of
//! regimes over two. Fig. 11 of the paper.

use std::ops::Range;

use strum::VariantArray as _;

use super::axis::readable;
use super::color::{colormap, colormap_index};
use super::figure::{lettered, regime_legend};
use super::{Axis, Color, Figure, Layer, Marker, Panel, Rgb};
use crate::analysis::{regime::Regime, stats::range, tones::SpectralLine};
use crate::dynamics::Exponent;
use crate::study::response::SettledResponse;
use crate::study::sweep::{self, Place, Start, SweepPlan, SweepPoint};

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

/// Place of a point on the axis, and its response.
type PlacedResponse<'a> = (f64, &'a SettledResponse);

/// The panels of some starts over one parameter, on axes that are the same for all starts; recordings have those of one
/// start.
pub struct ParameterPanels<'a> {
    axis: Axis,
    /// The starts shown, each with the marker of its points.
    starts: Vec<(Start, Marker, Vec<PlacedResponse<'a>>)>,
    /// The responses of all starts, which determine the axes.
    all: Vec<&'a SettledResponse>,
    /// A line at each parameter between two points of a start shown at which the motion doubles; empty without any.
    doublings: Option<Layer>,
}

/// All figures of a sweep: `bifurcation` over one parameter, with all starts in each panel; `regimes-START`
/// for each start of a sweep over two parameters. Points that are not computed yet are omitted.
pub fn sweep_figures(plan: &SweepPlan, points: &[SweepPoint]) -> Vec<Figure> {
    let starts = plan.starts.iter();
    if plan.axes.len() > 1 {
        return starts.map(|start| map(plan, *start, points)).collect();
    }
    let shared = ParameterPanels::new(plan, points, &plan.starts);
    let panels = [shared.maxima(), shared.lines()].into_iter();
    let panels = panels.chain(shared.exponents(EXPONENTS)).collect();
    let title = format!("{}: {}", plan.subject.name, start_labels(plan));
    vec![Figure::grid("bifurcation", &title, ROW_MM, 1, panels)]
}

/// Fig. 11: exponents, bifurcation diagram and spectral lines over the tilt.
pub fn bifurcation(plan: &SweepPlan, points: &[SweepPoint]) -> Figure {
    let shared = ParameterPanels::new(plan, points, &plan.starts);
    let exponents = shared.exponents(EXPONENTS);
    // The caption names the panels by their letters.
    let first = if exponents.is_some() { 'a' } else { 'b' };
    let panels = exponents.into_iter();
    let panels = panels.chain([shared.maxima(), shared.lines()]);
    let panels = lettered(first, panels);
    let starts = start_labels(plan);
    let title = format!("Fig. 11: Lyapunov exponents and bifurcation diagram, {starts}");
    Figure::grid("figure-11", &title, ROW_MM, 1, panels)
}

fn start_labels(plan: &SweepPlan) -> String {
    let labels: Vec<&str> = plan.starts.iter().copied().map(start_label).collect();
    labels.join(", ")
}

/// Name of the way in which points are started.
pub fn start_label(start: Start) -> &'static str {
    match start {
        Start::Fresh => "fresh starts",
        Start::Upward => "upward continuation",
        Start::Downward => "downward continuation",
    }
}

/// The axis of a parameter.
fn parameter_axis(axis: &sweep::Axis) -> Axis {
    Axis::cells(readable(&axis.name, axis.unit()), &axis.values)
}

impl<'a> ParameterPanels<'a> {
    /// The panels of the starts shown, side by side within a step of the parameter.
    pub fn new(plan: &SweepPlan, points: &'a [SweepPoint], starts: &[Start]) -> Self {
        let axis = parameter_axis(&plan.axes[0]);
        let [low, high] = axis.range;
        let step = (high - low) / plan.axes[0].values.len().max(1) as f64;
        let apart = OFFSET * step / starts.len() as f64;
        let middle = 0.5 * (starts.len() as f64 - 1.0);
        let shown = starts.iter().enumerate().map(|(k, &start)| {
            let points = points.iter();
            let points = points.filter(|point| point.place.start == start);
            let shift = apart * (k as f64 - middle);
            let shown = points.filter_map(|p| Some((p.place.values[0] + shift, p.found()?)));
            let marker = match start {
                Start::Upward if starts.len() > 1 => Marker::Up,
                Start::Downward if starts.len() > 1 => Marker::Down,
                _ => Marker::Dot,
            };
            (start, marker, shown.collect())
        });
        let doublings = sweep::transitions(points).into_iter();
        let doublings = doublings.filter(|t| t.doubling.is_some() && starts.contains(&t.start));
        let doublings = doublings.map(|t| 0.5 * (t.from + t.to));
        let doublings = Layer::vertical_lines(doublings, Color::Ink).with_label("doubling");
        Self {
            axis,
            starts: shown.collect(),
            all: points.iter().filter_map(SweepPoint::found).collect(),
            doublings: Some(doublings).filter(Layer::has_points),
        }
    }

    /// Legend entries of the starts, if there are several.
    fn start_legend(&self) -> impl Iterator<Item = Layer> {
        let starts = self.starts.iter().filter(|_| self.starts.len() > 1);
        let entry = |start: &Start| Layer::legend_entry(start.to_string(), Color::Ink);
        starts.map(move |(start, marker, _)| entry(start).with_marker(*marker))
    }

    /// Points with the markers of their starts; `of` returns the ordinates of a response.
    fn points<I: IntoIterator<Item = f64>>(
        &self,
        radius: f64,
        color: Color,
        of: impl Fn(&'a SettledResponse) -> I,
    ) -> Vec<Layer> {
        let layers = self.starts.iter().map(|(_, marker, shown)| {
            let points = shown.iter();
            let points = points.flat_map(|(x, found)| of(found).into_iter().map(|y| [*x, y]));
            Layer::points(points.collect(), radius, color).with_marker(*marker)
        });
        layers.filter(Layer::has_points).collect()
    }

    /// The maxima of the displacement in the colour of the regime.
    pub fn maxima(&self) -> Panel {
        let all = self.all.iter().flat_map(|found| maxima_or_zero(found));
        let y = Axis::with_margin("maximum", all).of("m");
        let mut points = Vec::new();
        for &regime in Regime::VARIANTS {
            // The few points of a periodic motion are larger, so that they are visible.
            let few = matches!(regime, Regime::Silent | Regime::Periodic);
            let (radius, color) = (if few { 1.7 } else { 0.7 }, Color::Regime(regime));
            points.extend(self.points(radius, color, |response| {
                maxima_or_zero(response).filter(move |_| response.regime == regime)
            }));
        }
        let has = |color| points.iter().any(|layer| layer.color == color);
        let mut layers: Vec<Layer> = regime_legend(|kind| has(Color::Regime(kind))).collect();
        layers.extend(self.start_legend());
        layers.extend(self.doublings.clone());
        layers.extend(points);
        let title = "local maxima of the displacement";
        Panel::new(title, self.axis.clone(), y, layers)
    }

    /// The largest exponents, at most `most`, with their intervals; `None` without any.
    pub fn exponents(&self, most: usize) -> Option<Panel> {
        let kth = |response: &SettledResponse, k: usize| -> Option<Exponent> {
            response.exponents.as_ref()?.exponents.get(k).copied()
        };
        let all = |k: usize| self.all.iter().filter_map(move |found| kth(found, k));
        all(0).next()?;
        let mut layers = vec![Layer::horizontal_line(0.0)];
        let numbers = || (0..most).take_while(|k| all(*k).next().is_some());
        let entry = |k| Layer::legend_entry(format!("λ{}", k + 1), Color::Series(k));
        layers.extend(numbers().map(entry));
        layers.extend(self.start_legend());
        // The largest exponent is drawn last with the smallest marker, so that equal exponents remain
        // visible.
        for k in (0..numbers().count()).rev() {
            let color = Color::Series(k);
            let shown = self.starts.iter().flat_map(|(_, _, shown)| shown);
            let spans = shown.filter_map(|(x, found)| {
                let exponent = kth(found, k)?;
                Some([*x, exponent.low(), exponent.high()])
            });
            layers.push(Layer::intervals(spans, color));
            let radius = 1.6 + 0.8 * k as f64;
            let points = self.points(radius, color, |found| kth(found, k).map(|e| e.value));
            let id = format!("exponent-{}", k + 1);
            layers.extend(points.into_iter().map(|points| points.with_id(&*id)));
        }
        let values = numbers().flat_map(all).flat_map(|exponent| {
            let half = exponent.half_width.min(INTERVAL);
            [-half, 0.0, half].map(|part| exponent.value + part)
        });
        let values = values.filter(|value| *value > SMALLEST_EXPONENT);
        let y = Axis::with_margin("exponent, 1/s", values.chain([0.0]));
        let title = "largest Lyapunov exponents with 95 % intervals";
        Some(Panel::new(title, self.axis.clone(), y, layers))
    }

    /// The frequencies of the spectral lines; stronger lines have larger points.
    fn lines(&self) -> Panel {
        // From strong to weak: amplitudes relative to the strongest, radius, colour.
        let kinds = [
            (0.5..f64::INFINITY, 2.4, Color::Ink),
            (0.1..0.5, 1.6, Color::Faint),
            (FAINTEST..0.1, 1.0, Color::Regime(Regime::Silent)),
        ];
        let frequencies = |response: &'a SettledResponse, shares: Range<f64>| {
            let lines = response.lines.iter();
            let strongest = response.lines.first().map(|line| line.amplitude);
            let share = move |line: &SpectralLine| line.amplitude / strongest.unwrap_or(1.0);
            let lines = lines.filter(move |line| shares.contains(&share(line)));
            lines.map(|line| line.frequency)
        };
        let keys = kinds.iter().map(|(shares, _, color)| {
            Layer::legend_entry(format!("from {:.0} %", 100.0 * shares.start), *color)
        });
        let mut layers: Vec<Layer> = keys.chain(self.start_legend()).collect();
        layers.extend(self.doublings.clone());
        for (shares, radius, color) in kinds {
            layers.extend(self.points(radius, color, |found| frequencies(found, shares.clone())));
        }
        let all = self.all.iter();
        let all = all.flat_map(|found| frequencies(found, FAINTEST..f64::INFINITY));
        let [_, highest] = range(all.chain([100.0]));
        let y = Axis::linear("frequency", [0.0, 1.08 * highest]).of("Hz");
        let title = "spectral lines by amplitude relative to the strongest";
        Panel::new(title, self.axis.clone(), y, layers)
    }
}

/// The maxima of a response, m; a joint at rest has one, at zero.
fn maxima_or_zero(response: &SettledResponse) -> impl Iterator<Item = f64> + '_ {
    let rests = response.maxima_m.is_empty().then_some(0.0);
    response.maxima_m.iter().copied().chain(rests)
}

/// Maps of the regime and of the largest exponent over two parameters.
fn map(plan: &SweepPlan, start: Start, points: &[SweepPoint]) -> Figure {
    let axes = [&plan.axes[0], &plan.axes[1]];
    let [columns, rows] = axes.map(|axis| axis.values.len());
    let [x, y] = axes.map(parameter_axis);
    let points = points.iter().filter(|point| point.place.start == start);
    let found = points.filter_map(|point| Some((&point.place, point.found()?)));
    let found: Vec<(&Place, &SettledResponse)> = found.collect();
    let panel = |title: &str, palette: &[Rgb], color: &dyn Fn(&SettledResponse) -> Option<u8>| {
        // The first axis varies fastest.
        let mut cells = vec![None; columns * rows];
        for (place, response) in &found {
            cells[place.index % (columns * rows)] = color(response);
        }
        let image = Layer::cells([&x, &y], columns, &cells, palette);
        Panel::new(title, x.clone(), y.clone(), vec![image])
    };
    let colors = Regime::VARIANTS.iter();
    let colors: Vec<Rgb> = colors.map(|kind| Color::Regime(*kind).on_light()).collect();
    // The palette is in the order of the variants.
    let index = |response: &SettledResponse| Some(response.regime as u8);
    let mut regimes = panel("type of motion", &colors, &index);
    let is_found = |kind| found.iter().any(|(_, found)| found.regime == kind);
    regimes.layers.extend(regime_legend(is_found));
    let unsettled = found.iter().filter(|(_, response)| !response.settled);
    let unsettled = unsettled.map(|(place, _)| [place.values[0], place.values[1]]);
    let crosses = Layer::points(unsettled.collect(), 2.0, Color::Ink).with_marker(Marker::Cross);
    let crosses = crosses.with_label("not in steady state");
    let crosses = Some(crosses).filter(Layer::has_points);
    regimes.layers.extend(crosses);
    let mut panels = vec![regimes];
    let largest = |response: &SettledResponse| {
        let spectrum = response.exponents.as_ref()?;
        spectrum.exponents.first().map(|e| e.value)
    };
    let values = || found.iter().filter_map(|(_, response)| largest(response));
    let [_, most] = range(values().chain([1.0]));
    if values().next().is_some() {
        let title = format!("largest exponent: pale is 0 or negative, black {most:.0} 1/s");
        panels.push(panel(&title, &colormap()[..255], &|response| {
            largest(response).map(|value| colormap_index(value.max(0.0) / most).min(254))
        }));
    }
    let title = format!("{}: {}", plan.subject.name, start_label(start));
    let mut figure = Figure::grid(&format!("regimes-{start}"), &title, 75.0, 1, panels);
    figure.size_mm[0] = 160.0;
    figure
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
