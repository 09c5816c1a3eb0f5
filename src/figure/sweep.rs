//! The figures of a sweep: bifurcation diagram, exponents and lines over a parameter, or a map of
//! regimes over two. Fig. 11 of the paper.

use super::panel::{Axis, Mark, Panel};
use super::style::{BLUE, FAINT, GREEN, INK, PURPLE, Rgb, VERMILION, shade};
use super::{Figure, FigureError};
use crate::analysis::{Regime, range};
use crate::dynamics::{Exponent, Sign};
use crate::study::response::Response;
use crate::study::sweep::{self, Start, SweepPlan, SweepPoint};

/// Colours of the largest exponents, in turn.
const EXPONENTS: [Rgb; 3] = [VERMILION, BLUE, GREEN];
/// Nothing is known.
const UNKNOWN: Rgb = [245, 246, 247];
/// Lines weaker than this share of the strongest are not drawn.
const FAINTEST: f64 = 0.02;

/// The colour of a regime; those of one kind of motion are the same in all figures of sweeps.
pub(super) fn color_of(regime: Regime) -> Rgb {
    match regime {
        Regime::Silent => [205, 209, 214],
        Regime::Periodic => BLUE,
        Regime::QuasiPeriodic => GREEN,
        Regime::Chaotic => VERMILION,
        Regime::Transient => PURPLE,
        Regime::Noise => INK,
        Regime::Unsure => [150, 155, 162],
    }
}

/// All figures of a sweep: `bifurcation-START` for each start of a sweep over one parameter;
/// `regimes-START` for each start of one over two. Points that are not there yet are left out.
///
/// # Errors
/// [`FigureError`].
pub fn sweep_figures(plan: &SweepPlan, points: &[SweepPoint]) -> Result<Vec<Figure>, FigureError> {
    let starts = plan.starts.iter().zip(sweep_figure_names(plan));
    let figures = starts.map(|(&start, name)| {
        let found = found(points, start);
        let title = format!("{} — {}", plan.scene.name, words(start));
        match plan.axes.len() {
            1 => diagram(plan, &found, name, &title),
            _ => map(plan, &found, name, &title),
        }
    });
    figures.collect()
}

/// Stems of the names of the figures that [`sweep_figures`] draws.
pub fn sweep_figure_names(plan: &SweepPlan) -> Vec<String> {
    let kind = match plan.axes.len() {
        1 => "bifurcation",
        _ => "regimes",
    };
    let starts = plan.starts.iter();
    starts.map(|start| format!("{kind}-{start}")).collect()
}

/// Fig. 11: bifurcation diagram, exponents and lines over the tilt, of the points that were started in
/// one way.
///
/// # Errors
/// [`FigureError`].
pub fn bifurcation(
    plan: &SweepPlan,
    points: &[SweepPoint],
    start: Start,
) -> Result<Figure, FigureError> {
    let title = format!(
        "Fig. 11 — Lyapunov exponents and bifurcation diagram, {}",
        words(start)
    );
    let (x, found) = (along(&plan.axes[0]), found(points, start));
    let mut rows = [exponents(&x, &found), maxima(&x, &found), lines(&x, &found)];
    for (panel, letter) in rows.iter_mut().zip(["a", "b", "c"]) {
        panel.title = format!("{letter}  {}", panel.title);
    }
    let rows = rows.map(|panel| vec![panel]);
    Figure::new("figure-11", &title, [1000, 870], &rows)
}

/// The responses that were started in one way.
fn found(points: &[SweepPoint], start: Start) -> Vec<Found<'_>> {
    let of_start = points.iter().filter(|point| point.place.start == start);
    let found = of_start.filter_map(|point| {
        let response = point.outcome.as_ref().ok()?;
        let values = &point.place.values[..];
        Some(Found { values, response })
    });
    found.collect()
}

/// A response, and where it was found.
#[derive(Clone, Copy)]
struct Found<'a> {
    values: &'a [f64],
    response: &'a Response,
}

/// How the points were started, in words.
fn words(start: Start) -> &'static str {
    match start {
        Start::Cold => "each point started cold",
        Start::Up => "continued up",
        Start::Down => "continued down",
    }
}

/// The axis of a parameter, with half a step to either side.
fn along(axis: &sweep::Axis) -> Axis {
    let [low, high] = range(axis.values().iter().copied());
    let half = match axis.values().len() {
        0 | 1 => 0.5,
        count => 0.5 * (high - low) / (count - 1) as f64,
    };
    Axis::linear(axis.label(), [low - half, high + half])
}

fn diagram(
    plan: &SweepPlan,
    found: &[Found<'_>],
    name: String,
    title: &str,
) -> Result<Figure, FigureError> {
    let x = along(&plan.axes[0]);
    let mut rows = vec![vec![maxima(&x, found)]];
    if found.iter().any(|point| point.response.exponents.is_some()) {
        rows.push(vec![exponents(&x, found)]);
    }
    rows.push(vec![lines(&x, found)]);
    let height = 60 + 270 * rows.len() as u32;
    Figure::new(name, title, [1000, height], &rows)
}

/// The maxima of the displacement, each column in the colour of its regime.
fn maxima(x: &Axis, found: &[Found<'_>]) -> Panel {
    let mut marks = Vec::new();
    for regime in Regime::ALL {
        let of_regime = || found.iter().filter(|point| point.response.regime == regime);
        let mut label = regime.to_string();
        // A tone has but a few points, which are drawn to be seen.
        for (few, radius) in [(false, 0.8), (true, 2.2)] {
            let columns = of_regime().filter(|point| has_few(&point.response.maxima) == few);
            let points = columns.flat_map(|point| {
                let maxima = point.response.maxima.iter();
                // A joint that rests has one point, at zero.
                let rests = point.response.maxima.is_empty().then_some(&0.0);
                let tops = maxima.chain(rests);
                tops.map(|top| [point.values[0], 1e6 * top])
            });
            let points: Vec<[f64; 2]> = points.collect();
            if !points.is_empty() {
                marks.push(Mark::Dots {
                    points,
                    radius,
                    color: color_of(regime),
                    label: std::mem::take(&mut label),
                });
            }
        }
    }
    let all = found.iter().flat_map(|point| &point.response.maxima);
    let rests = found.iter().any(|point| point.response.maxima.is_empty());
    Panel {
        title: "local maxima of the displacement".to_owned(),
        x: x.clone(),
        y: Axis::around(
            "maximum, µm",
            all.map(|top| 1e6 * top).chain(rests.then_some(0.0)),
        ),
        marks,
    }
}

/// Whether maxima are hardly more than a handful of values.
fn has_few(maxima: &[f64]) -> bool {
    const FEW: usize = 6;
    let [low, high] = range(maxima.iter().copied());
    let size = high.abs().max(low.abs());
    let mut sorted = maxima.to_vec();
    sorted.sort_by(f64::total_cmp);
    let steps = sorted
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > 0.01 * size);
    steps.count() < FEW && {
        let spread: f64 = sorted
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).min(0.01 * size))
            .sum();
        spread < 0.05 * size
    }
}

fn exponents(x: &Axis, found: &[Found<'_>]) -> Panel {
    let mut marks = vec![Mark::Level { y: 0.0 }];
    let mut shown: Vec<Exponent> = Vec::new();
    // The largest comes last and smallest: where all are zero, each is seen round the one before.
    for (k, color) in EXPONENTS.into_iter().enumerate().rev() {
        let kth = found.iter().filter_map(|point| {
            let spectrum = point.response.exponents.as_ref()?;
            let exponent = spectrum.exponents.get(k)?;
            Some((point.values[0], *exponent, spectrum.sign(k)))
        });
        let kth: Vec<(f64, Exponent, Sign)> = kth.collect();
        if kth.is_empty() {
            continue;
        }
        shown.extend(kth.iter().map(|(_, exponent, _)| *exponent));
        marks.push(Mark::Intervals {
            spans: kth
                .iter()
                .map(|(x, e, _)| [*x, e.low(), e.high()])
                .collect(),
            color,
        });
        marks.push(Mark::Dots {
            points: kth.iter().map(|(x, e, _)| [*x, e.value]).collect(),
            radius: 2.2 + 1.1 * k as f64,
            color,
            label: format!("λ{}", k + 1),
        });
    }
    // The interval of a motion that was hardly averaged would hide all others.
    let ends = shown.iter().flat_map(|e| {
        let ends = [
            e.value,
            e.low().max(e.value - 40.0),
            e.high().min(e.value + 40.0),
        ];
        ends.into_iter()
    });
    let ends = ends.filter(|value| *value > -250.0).chain([0.0]);
    Panel {
        title: "largest Lyapunov exponents with their 95 % intervals".to_owned(),
        x: x.clone(),
        y: Axis::around("exponent, 1/s", ends),
        marks,
    }
}

/// The frequencies of the lines; the stronger, the larger the dot.
fn lines(x: &Axis, found: &[Found<'_>]) -> Panel {
    // From strong to weak: amplitude over the strongest one's, radius, colour.
    let kinds = [
        (0.5, 3.4, INK),
        (0.1, 2.2, [90, 96, 104]),
        (FAINTEST, 1.2, FAINT),
    ];
    let mut marks = Vec::new();
    let mut upper = f64::INFINITY;
    for (least, radius, color) in kinds {
        let points: Vec<[f64; 2]> = found
            .iter()
            .flat_map(|point| {
                let lines = &point.response.lines;
                let strongest = lines.first().map_or(f64::INFINITY, |line| line.amplitude);
                let share = move |amplitude: f64| amplitude / strongest;
                let chosen = lines.iter().filter(move |line| {
                    let share = share(line.amplitude);
                    share >= least && share < upper
                });
                chosen.map(|line| [point.values[0], 1e-3 * line.frequency])
            })
            .collect();
        upper = least;
        if !points.is_empty() {
            marks.push(Mark::Dots {
                points,
                radius,
                color,
                label: format!("from {:.0} % of the strongest", 100.0 * least),
            });
        }
    }
    let highest = found.iter().flat_map(|point| {
        let strongest = point
            .response
            .lines
            .first()
            .map_or(0.0, |line| line.amplitude);
        let strong = point.response.lines.iter();
        let strong = strong.filter(move |line| line.amplitude >= FAINTEST * strongest);
        strong.map(|line| 1e-3 * line.frequency)
    });
    let [_, highest] = range(highest.chain([0.1]));
    Panel {
        title: "lines of the spectrum".to_owned(),
        x: x.clone(),
        y: Axis::linear("frequency, kHz", [0.0, 1.08 * highest]),
        marks,
    }
}

/// Regime and largest exponent over two parameters.
fn map(
    plan: &SweepPlan,
    found: &[Found<'_>],
    name: String,
    title: &str,
) -> Result<Figure, FigureError> {
    let [across, along] = [&plan.axes[0], &plan.axes[1]];
    let size = [across.values().len(), along.values().len()];
    // The cell that belongs to a point; the upper row first.
    let cell = |point: &Found<'_>| {
        let place = |values: &[f64], value: f64| values.iter().position(|v| *v == value);
        let column = place(across.values(), point.values[0])?;
        let row = place(along.values(), point.values[1])?;
        Some((size[1] - 1 - row) * size[0] + column)
    };
    let picture = |color: &dyn Fn(&Response) -> Rgb| {
        let mut pixels = vec![UNKNOWN; size[0] * size[1]];
        for point in found {
            if let Some(cell) = cell(point) {
                pixels[cell] = color(point.response);
            }
        }
        pixels
    };
    let spans = [across, along].map(|axis| {
        let [low, high] = range(axis.values().iter().copied());
        let half = 0.5 * (high - low) / (axis.values().len().max(2) - 1) as f64;
        let half = if half > 0.0 { half } else { 0.5 };
        [low - half, high + half]
    });
    let panel = |title: String, pixels: Vec<Rgb>, legend: Vec<Mark>| {
        let mut marks = vec![Mark::Picture {
            x: spans[0],
            y: spans[1],
            size,
            pixels,
        }];
        marks.extend(legend);
        Panel {
            title,
            x: Axis::linear(across.label(), spans[0]),
            y: Axis::linear(along.label(), spans[1]),
            marks,
        }
    };
    let largest = |response: &Response| {
        let spectrum = response.exponents.as_ref()?;
        spectrum.exponents.first().map(|e| e.value)
    };
    let values = found.iter().filter_map(|point| largest(point.response));
    let [_, most] = range(values.chain([1.0]));
    let unsettled = found.iter().filter(|point| !point.response.settled);
    let stars = unsettled.map(|point| Mark::Words {
        at: [point.values[0], point.values[1]],
        words: "*".to_owned(),
    });
    let stars: Vec<Mark> = stars.collect();
    let regimes = Regime::ALL
        .into_iter()
        .filter(|regime| found.iter().any(|point| point.response.regime == *regime));
    // A dot beyond the axes: only its entry in the legend is seen.
    let legend = regimes.map(|regime| Mark::Dots {
        points: Vec::new(),
        radius: 3.0,
        color: color_of(regime),
        label: regime.to_string(),
    });
    let mut rows = vec![vec![panel(
        match stars.is_empty() {
            true => "kind of motion".to_owned(),
            false => "kind of motion (* not settled)".to_owned(),
        },
        picture(&|response| color_of(response.regime)),
        stars.iter().cloned().chain(legend).collect(),
    )]];
    if found.iter().any(|point| largest(point.response).is_some()) {
        rows.push(vec![panel(
            format!("largest Lyapunov exponent: pale is 0 and below, black {most:.0} 1/s"),
            picture(&|response| {
                largest(response).map_or(UNKNOWN, |value| shade(value.max(0.0) / most))
            }),
            Vec::new(),
        )]);
    }
    let height = 60 + 380 * rows.len() as u32;
    Figure::new(name, title, [900, height], &rows)
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
