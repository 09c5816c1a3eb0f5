//! Figure of coexisting attractors: the share of kicks that lead to each, and their phase portraits.

use super::axis::Axis;
use super::color::Color;
use super::figure::{Bar, Figure, Panel};
use super::response;
use crate::study::basins::Attractor;
use crate::study::sweep::SweepPoint;

/// Maximum number of attractors shown.
const MOST: usize = 4;

/// Bars with the share of each attractor, and phase portraits of the most frequent. `title` names the scene.
pub fn basins_figure(title: &str, points: &[SweepPoint], attractors: &[Attractor]) -> Figure {
    let shown = &attractors[..attractors.len().min(MOST)];
    let bars = shown.iter().map(|attractor| Bar {
        value: 100.0 * attractor.share,
        text: words(attractor),
        color: Color::Regime(attractor.regime),
    });
    let mut bars: Vec<Bar> = bars.collect();
    let count = |some: &[Attractor]| some.iter().map(|a| a.members.len()).sum::<usize>();
    let rest = [
        (count(&attractors[shown.len()..]), "other attractors"),
        (points.len() - count(attractors), "unclassified"),
    ];
    for (count, text) in rest.into_iter().filter(|(count, _)| *count > 0) {
        let share = 100.0 * count as f64 / points.len() as f64;
        bars.push(Bar {
            value: share,
            text: format!("{share:.0} % {text}"),
            color: Color::Faint,
        });
    }
    let kicks = match points.len() {
        1 => "one kick".to_owned(),
        count => format!("{count} kicks"),
    };
    let heading = format!("shares of {kicks}");
    let shares = Panel::bars(heading, Axis::linear("share, %", [0.0, 100.0]), bars);
    let portraits = shown.iter().map(|attractor| portrait(points, attractor));
    let rows = [vec![shares], portraits.collect()];
    let rows = rows.into_iter().filter(|row| !row.is_empty()).collect();
    Figure::new("basins", title, 115.0, rows)
}

/// Label of an attractor: share with its 95 % interval, regime, frequency and amplitude.
fn words(attractor: &Attractor) -> String {
    let [low, high] = attractor.interval.map(|share| 100.0 * share);
    let tone = attractor.frequency.map(|hz| {
        let (kilohertz, microns) = (1e-3 * hz, 1e6 * attractor.amplitude);
        format!(", {kilohertz:.3} kHz, {microns:.3} µm")
    });
    format!(
        "{:.0} % ({low:.0} to {high:.0}) {}{}",
        100.0 * attractor.share,
        attractor.regime,
        tone.unwrap_or_default()
    )
}

fn portrait(points: &[SweepPoint], attractor: &Attractor) -> Panel {
    let member = attractor.members.first().and_then(|&k| points.get(k));
    let response = member.and_then(|point| point.outcome.as_ref().ok());
    let portrait = response.and_then(|response| response.portrait.as_ref());
    let trail = portrait.map_or_else(Vec::new, response::samples);
    let title = match attractor.frequency {
        Some(hz) => format!("{}, {:.3} kHz", attractor.regime, 1e-3 * hz),
        None => attractor.regime.to_string(),
    };
    response::phase_portrait(&trail, None, Color::Regime(attractor.regime)).with_title(title)
}
