//! Fig. 4 to 10: one motion from all sides, how it is embedded, and motions over the tilt.

use crate::analysis::{DelayChoice, RecurrenceImage};
use crate::joint::{Cause, ExplainedMode};
use crate::plot::response::{
    self, LAG, SMALLEST, SectionPlane, SpectrumPlane, between_samples, largest,
};
use crate::plot::{Axis, Color, Figure, Layer, Panel};

use crate::study::response::{Portrait, Response};

/// The highest frequency of a spectrum, Hz, and its decades.
const HIGHEST: f64 = 15e3;
const DECADES: i32 = 6;
/// Panels a row.
const ROW: usize = 4;

/// Fig. 4 to 7: growth of the linear modes, time series, phase plot, spectrum, delay reconstruction
/// and recurrence plot of the motion at a tilt (degrees), whose linear modes are `modes`.
pub fn motion(
    number: usize,
    tilt_deg: f64,
    response: &Response,
    modes: &[ExplainedMode],
) -> Figure {
    let title = format!(
        "Fig. {number}: {} at {tilt_deg}°, {:.0} % sure",
        response.regime,
        100.0 * response.confidence
    );
    let mut panels = vec![growth(modes)];
    if let Some(portrait) = &response.portrait {
        let color = response::color(response);
        let strongest = response
            .lines
            .first()
            .map_or(SMALLEST[0], |line| line.amplitude);
        let plane = SpectrumPlane::new(strongest, DECADES, HIGHEST);
        panels.extend([
            response::series(portrait, color),
            response::phase(&between_samples(portrait), None, color),
            plane.panel(portrait.bin, &portrait.spectrum, &response.lines),
            response::reconstruction(portrait, color),
            response::recurrence(recurrence(portrait).as_ref(), false),
        ]);
    }
    for (panel, letter) in panels.iter_mut().zip(["a", "b", "c", "d", "e", "f"]) {
        panel.title = format!("{letter}  {}", panel.title);
    }
    Figure::grid(format!("figure-{number}"), title, 66.0, 3, &panels)
}

/// The recurrence plot of what moves.
fn recurrence(portrait: &Portrait) -> Option<RecurrenceImage> {
    let mut pairs = portrait.displacement.windows(2);
    let moves = pairs.any(|pair| pair[0] != pair[1]);
    portrait.recurrence().ok().flatten().filter(|_| moves)
}

/// Growth of each oscillating mode, and what feeds and damps it: the shares add up to the growth.
fn growth(modes: &[ExplainedMode]) -> Panel {
    const WIDTH: f64 = 0.45;
    const DAMPING: [Cause; 4] = [
        Cause::Direction,
        Cause::Structure,
        Cause::ContactDamping,
        Cause::Convection,
    ];
    let feeds = [
        (&[Cause::Slope][..], Color::Series(6), "slope"),
        (&[Cause::Coupling], Color::Series(0), "coupling"),
        (&DAMPING, Color::Pale, "damping"),
    ];
    let mut layers = vec![Layer::level(0.0)];
    // Bars that feed stand upon each other, and so do those that damp.
    let mut ends = vec![[0.0_f64; 2]; modes.len()];
    for (causes, color, label) in feeds {
        let spans = modes.iter().zip(&mut ends).map(|(mode, ends)| {
            let of = mode.causes.iter().filter(|c| causes.contains(&c.cause));
            let share: f64 = of.map(|cause| cause.share).sum();
            let end = &mut ends[usize::from(share < 0.0)];
            let from = *end;
            *end += share;
            [1e-3 * mode.frequency_hz, from, *end]
        });
        layers.push(Layer::columns(&spans.collect::<Vec<_>>(), WIDTH, color).named(label));
    }
    let unstable = modes.iter().filter(|mode| mode.growth > 0.0).count();
    for (growing, color) in [(true, Color::Accent), (false, Color::Ink)] {
        let chosen = modes.iter().filter(|mode| (mode.growth > 0.0) == growing);
        let points = chosen.map(|mode| [1e-3 * mode.frequency_hz, mode.growth]);
        layers.push(Layer::points(points.collect(), 2.4, color));
    }
    let highest = modes.iter().map(|mode| mode.growth).fold(100.0, f64::max);
    let growth = [-0.4 * highest, 1.25 * highest];
    Panel::new(
        format!("{unstable} unstable modes"),
        Axis::linear("frequency, kHz", [0.0, 13.0]),
        Axis::linear("growth (dots) and its causes, 1/s", growth),
        layers,
    )
}

/// Fig. 8: mutual information and share of false neighbours of the motion at a tilt (degrees), sampled
/// every `dt` (s).
pub fn embedding(tilt_deg: f64, choice: &DelayChoice, dt: f64) -> Figure {
    let microseconds = |samples: usize| 1e6 * dt * samples as f64;
    let mutual = choice.mutual.bits.iter().enumerate();
    let mutual: Vec<[f64; 2]> = mutual.map(|(k, bits)| [microseconds(k), *bits]).collect();
    let most = mutual.iter().map(|p| p[1]).fold(0.1, f64::max);
    let delay = microseconds(choice.lag);
    let information = Panel::new(
        format!("a  average mutual information: delay {delay:.0} µs"),
        Axis::linear("delay, µs", [0.0, mutual.last().map_or(1.0, |p| p[0])]),
        Axis::linear("information, bit", [0.0, 1.05 * most]),
        vec![
            Layer::line(mutual, Color::Ink),
            Layer::upright(delay, Color::Accent).named(format!("{} samples", choice.lag)),
        ],
    );
    let shares = choice.neighbours.share.iter().zip(1..);
    let shares = shares.map(|(share, k)| [f64::from(k), 100.0 * share]);
    let shares: Vec<[f64; 2]> = shares.collect();
    let neighbours = Panel::new(
        format!(
            "b  false nearest neighbours: dimension {}",
            choice.dimension
        ),
        Axis::counting("dimension", shares.len()),
        Axis::linear("false neighbours, %", [0.0, 105.0]),
        vec![
            Layer::line(shares.clone(), Color::Faint),
            Layer::points(shares, 2.4, Color::Ink),
            Layer::upright(choice.dimension as f64, Color::Accent)
                .named(format!("m = {}", choice.dimension)),
        ],
    );
    let title = format!("Fig. 8: choice of delay and dimension at {tilt_deg}°");
    Figure::new("figure-8", title, 80.0, vec![vec![information, neighbours]])
}

/// What is written above the motion at a tilt (degrees).
fn title((tilt, response): &(f64, &Response)) -> String {
    format!("{tilt}°, {}", response.regime)
}

/// Fig. 9: recurrence plots of 5 ms at each of some tilts (degrees).
pub fn recurrence_plots(points: &[(f64, &Response)]) -> Figure {
    let panels = points.iter().filter_map(|point| {
        let found = recurrence(point.1.portrait.as_ref()?);
        Some(response::recurrence(found.as_ref(), false).titled(title(point)))
    });
    let panels: Vec<Panel> = panels.collect();
    Figure::grid("figure-9", "Fig. 9: recurrence plots", 54.0, ROW, &panels)
}

/// Fig. 10: Poincaré maps at each of some tilts (degrees), all on the same axes.
pub fn sections(points: &[(f64, &Response)]) -> Figure {
    let found: Vec<&Response> = points.iter().map(|(_, response)| *response).collect();
    let size = found.iter().map(|response| largest(response)[0]);
    let plane = SectionPlane::new(&found, "u", size.fold(SMALLEST[0], f64::max));
    let panels = points
        .iter()
        .map(|point| plane.panel(Some(point.1)).titled(title(point)));
    let panels: Vec<Panel> = panels.collect();
    let microseconds = 1e6 * LAG;
    let title = format!("Fig. 10: Poincaré maps at u(t + τ) = 0, τ = {microseconds:.0} µs");
    Figure::grid("figure-10", title, 54.0, ROW, &panels)
}
