//! The figures of a sweep: bifurcation diagram, exponents and lines over a parameter, or a map of
//! regimes over two. Fig. 11 of the paper.

use super::axis::{Axis, extent};
use super::color::{Color, Rgb, magnitude, magnitudes};
use super::figure::{Figure, Image, Layer, Marker, Panel, Swatch};
use super::unit::Unit;
use crate::analysis::{Regime, range};
use crate::dynamics::Exponent;
use crate::study::response::Response;
use crate::study::sweep::{self, Start, SweepPlan, SweepPoint};

/// Exponents on show.
const EXPONENTS: usize = 3;
/// Nothing is known.
const UNKNOWN: Rgb = [245, 246, 247];
/// Lines weaker than this share of the strongest are not drawn.
const FAINTEST: f64 = 0.02;
/// By how much the points of different starts stand apart, as a share of a step.
const APART: f64 = 0.36;
/// Intervals (1/s) of exponents are shown so far to either side, and no exponent below the last: one that
/// was hardly averaged would hide all others.
const INTERVAL: f64 = 40.0;
const LOWEST_EXPONENT: f64 = -250.0;
/// Height of a row of panels, mm.
const ROW_MM: f64 = 50.0;

/// A response and where it was found.
#[derive(Clone, Copy)]
struct Found<'a> {
    values: &'a [f64],
    start: Start,
    response: &'a Response,
}

/// What the panels over one parameter share: its axis, the responses, and how starts are told apart.
struct Over<'a> {
    axis: Axis,
    /// The starts on show and the shift of each along the axis.
    starts: Vec<(Start, f64)>,
    found: Vec<Found<'a>>,
}

/// All figures of a sweep: `bifurcation` over one parameter, with all starts in each panel;
/// `regimes-START` for each start of one over two. Points that are not there yet are left out.
pub fn sweep_figures(plan: &SweepPlan, points: &[SweepPoint]) -> Vec<Figure> {
    if let [_] = &plan.axes[..] {
        let over = Over::new(plan, points);
        let mut rows = vec![vec![over.maxima()]];
        if over
            .found
            .iter()
            .any(|found| found.response.exponents.is_some())
        {
            rows.push(vec![over.exponents()]);
        }
        rows.push(vec![over.lines()]);
        let starts: Vec<&str> = plan.starts.iter().map(|start| words(*start)).collect();
        let title = format!("{}: {}", plan.scene.name, starts.join(", "));
        let height = ROW_MM * rows.len() as f64;
        return vec![Figure::new("bifurcation", title, height, rows)];
    }
    let starts = plan.starts.iter();
    starts
        .map(|&start| map(plan, start, &found(points, start)))
        .collect()
}

/// Fig. 11: exponents, bifurcation diagram and lines over the tilt.
pub fn bifurcation(plan: &SweepPlan, points: &[SweepPoint]) -> Figure {
    let over = Over::new(plan, points);
    let panels = [over.exponents(), over.maxima(), over.lines()];
    let rows = panels.into_iter().zip(["a", "b", "c"]);
    let rows = rows.map(|(panel, letter)| {
        let title = format!("{letter}  {}", panel.title);
        vec![Panel { title, ..panel }]
    });
    let starts: Vec<&str> = plan.starts.iter().map(|start| words(*start)).collect();
    let title = format!(
        "Fig. 11: Lyapunov exponents and bifurcation diagram, {}",
        starts.join(", ")
    );
    Figure::new("figure-11", title, 3.0 * ROW_MM, rows.collect())
}

/// The maxima of the points that were started in one way, on the same axes for all ways: the bifurcation
/// diagram of a recording.
pub fn maxima(plan: &SweepPlan, points: &[SweepPoint], start: Start) -> Panel {
    let mut over = Over::new(plan, points);
    over.starts = vec![(start, 0.0)];
    over.maxima()
}

/// How points are started, in words.
pub fn words(start: Start) -> &'static str {
    match start {
        Start::Cold => "each started cold",
        Start::Up => "continued up",
        Start::Down => "continued down",
    }
}

/// The form of the points of a start.
fn marker(start: Start) -> Marker {
    match start {
        Start::Cold => Marker::Dot,
        Start::Up => Marker::Up,
        Start::Down => Marker::Down,
    }
}

/// The responses that were started in one way.
fn found(points: &[SweepPoint], start: Start) -> Vec<Found<'_>> {
    let of_start = points.iter().filter(|point| point.place.start == start);
    let found = of_start.filter_map(|point| {
        Some(Found {
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

/// The axis of a parameter, with half a step to either side.
fn along(axis: &sweep::Axis) -> Axis {
    let [low, high] = range(axis.values().iter().copied());
    let half = half_step(axis);
    Axis::linear(axis.label(), [low - half, high + half])
}

impl<'a> Over<'a> {
    fn new(plan: &SweepPlan, points: &'a [SweepPoint]) -> Self {
        let axis = &plan.axes[0];
        let apart = 2.0 * APART * half_step(axis) / plan.starts.len() as f64;
        let middle = 0.5 * (plan.starts.len() as f64 - 1.0);
        let starts = (0..).zip(&plan.starts);
        Self {
            axis: along(axis),
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

    /// Entries of the legend that tell the starts apart.
    fn keys(&self) -> Vec<Layer> {
        let starts = self.starts.iter().filter(|_| self.starts.len() > 1);
        let keys =
            starts.map(|(start, _)| Layer::key(words(*start), Color::Ink).marked(marker(*start)));
        keys.collect()
    }

    /// Points in the forms of their starts, side by side; `of` gives the heights at a response.
    fn points<I: IntoIterator<Item = f64>>(
        &self,
        radius: f64,
        color: Color,
        of: impl Fn(&Found<'a>) -> I,
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
            Layer::points(points.collect(), radius, color).marked(form)
        });
        layers.filter(Layer::has_points).collect()
    }

    /// The maxima of the displacement, each column in the colour of its regime.
    fn maxima(&self) -> Panel {
        let all = self.found.iter().flat_map(|found| tops(found.response));
        let [low, high] = extent(all);
        let unit = Unit::of("m", low.abs().max(high.abs()));
        let mut keys = Vec::new();
        let mut layers = Vec::new();
        for regime in Regime::ALL {
            let color = Color::Regime(regime);
            let before = layers.len();
            // A tone has but a few points, which are drawn to be seen.
            for (few, radius) in [(false, 0.7), (true, 1.7)] {
                layers.extend(self.points(radius, color, |found| {
                    let response = found.response;
                    let chosen = response.regime == regime && has_few(&response.maxima) == few;
                    let tops = tops(response).map(|top| unit.factor * top);
                    tops.filter(move |_| chosen)
                }));
            }
            if layers.len() > before {
                keys.push(Layer::key(regime.to_string(), color));
            }
        }
        keys.extend(self.keys());
        keys.extend(layers);
        let drawn = [low, high].map(|top| unit.factor * top);
        Panel::new(
            "local maxima of the displacement",
            self.axis.clone(),
            Axis::around(unit.after("maximum"), drawn.into_iter()),
            keys,
        )
    }

    /// The largest exponents with their intervals.
    fn exponents(&self) -> Panel {
        let kth = |found: &Found<'a>, k: usize| -> Option<Exponent> {
            found.response.exponents.as_ref()?.exponents.get(k).copied()
        };
        let mut layers = vec![Layer::level(0.0)];
        let there = |k: &usize| self.found.iter().any(|found| kth(found, *k).is_some());
        let numbers: Vec<usize> = (0..EXPONENTS).filter(there).collect();
        let keys = numbers
            .iter()
            .map(|k| Layer::key(format!("λ{}", k + 1), Color::Exponent(*k)));
        layers.extend(keys);
        layers.extend(self.keys());
        // The largest comes last and smallest: where all are zero, each is seen round the one before.
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
            "largest Lyapunov exponents with their 95 % intervals",
            self.axis.clone(),
            Axis::around("exponent, 1/s", exponent_ends(shown).chain([0.0])),
            layers,
        )
    }

    /// The frequencies of the lines; the stronger, the larger the point.
    fn lines(&self) -> Panel {
        // From strong to weak: amplitude over the strongest one's, radius, colour.
        let kinds = [
            (0.5, 2.4, Color::Ink),
            (0.1, 1.6, Color::Faint),
            (FAINTEST, 1.0, Color::Regime(Regime::Unsure)),
        ];
        let strongest = |response: &Response| {
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
            keys.push(Layer::key(
                format!("from {:.0} % of the strongest", 100.0 * least),
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
        keys.extend(self.keys());
        keys.extend(layers);
        Panel::new(
            "lines of the spectrum",
            self.axis.clone(),
            Axis::linear("frequency, kHz", [0.0, 1.08 * highest]),
            keys,
        )
    }
}

/// The values that an axis of some exponents must show: they and the nearer parts of their intervals.
pub fn exponent_ends(exponents: impl Iterator<Item = Exponent>) -> impl Iterator<Item = f64> {
    let ends = exponents.flat_map(|e| {
        let low = e.low().max(e.value - INTERVAL);
        [e.value, low, e.high().min(e.value + INTERVAL)]
    });
    ends.filter(|value| value.is_finite() && *value > LOWEST_EXPONENT)
}

/// The maxima of a response, m; a joint that rests has one, at zero.
fn tops(response: &Response) -> impl Iterator<Item = f64> + '_ {
    let rests = response.maxima.is_empty().then_some(0.0);
    response.maxima.iter().copied().chain(rests)
}

/// Whether maxima are hardly more than a handful of values.
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

/// Regime and largest exponent over two parameters.
fn map(plan: &SweepPlan, start: Start, found: &[Found<'_>]) -> Figure {
    let axes = [&plan.axes[0], &plan.axes[1]];
    let [columns, rows] = axes.map(|axis| axis.values().len());
    let [x, y] = axes.map(along);
    // The pixel that belongs to a point; the upper row first.
    let pixel = |found: &Found<'_>| {
        let place = |k: usize| axes[k].values().iter().position(|v| *v == found.values[k]);
        Some((rows - 1 - place(1)?) * columns + place(0)?)
    };
    let image = |palette: Vec<Rgb>, color: &dyn Fn(&Response) -> Option<u8>| {
        // The last colour is that of what is unknown.
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
            palette: palette.map(Swatch::plain).collect(),
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
    let keys = there.map(|regime| Layer::key(regime.to_string(), Color::Regime(regime)));
    let unsettled = found.iter().filter(|point| !point.response.settled);
    let stars = unsettled.map(|point| Layer::text([point.values[0], point.values[1]], "*"));
    let stars: Vec<Layer> = stars.collect();
    let title = match stars.is_empty() {
        true => "type of motion",
        false => "type of motion (* not settled)",
    };
    let layers = [regimes].into_iter().chain(keys).chain(stars).collect();
    let mut panels = vec![panel(title.to_owned(), layers)];
    let largest = |response: &Response| {
        let spectrum = response.exponents.as_ref()?;
        spectrum.exponents.first().map(|e| e.value)
    };
    let values = found.iter().filter_map(|point| largest(point.response));
    let [_, most] = range(values.chain([1.0]));
    if found.iter().any(|point| largest(point.response).is_some()) {
        // One colour is left for what is unknown.
        let shades = magnitudes()[..255].to_vec();
        let image = image(shades, &|response| {
            largest(response).map(|value| magnitude(value.max(0.0) / most).min(254))
        });
        let title = format!("largest Lyapunov exponent: pale is 0 and below, black {most:.0} 1/s");
        panels.push(panel(title, vec![image]));
    }
    let title = format!("{}: {}", plan.scene.name, words(start));
    Figure::grid(format!("regimes-{start}"), title, 75.0, 1, &panels).with_width(160.0)
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
