//! The figure of coexisting attractors: how many kicks lead to each, and what each looks like.

use super::panel::{Axis, Bar, Mark, Panel};
use super::style::FAINT;
use super::sweep::color_of;
use super::{Figure, FigureError};
use crate::study::basins::Attractor;
use crate::study::sweep::SweepPoint;

/// The most attractors that are shown.
const MOST: usize = 4;

/// Shares of the attractors as bars, and the phase portraits of the commonest. `title` says of which
/// scene.
///
/// # Errors
/// [`FigureError`].
pub fn basins_figure(
    title: &str,
    points: &[SweepPoint],
    attractors: &[Attractor],
) -> Result<Figure, FigureError> {
    let shown = &attractors[..attractors.len().min(MOST)];
    let bars = shown.iter().map(|attractor| Bar {
        value: 100.0 * attractor.share,
        words: words(attractor),
        color: color_of(attractor.regime),
    });
    let mut bars: Vec<Bar> = bars.collect();
    let others: usize = attractors[shown.len()..]
        .iter()
        .map(|a| a.members.len())
        .sum();
    let told: usize = attractors.iter().map(|a| a.members.len()).sum();
    let rest = [
        (others, "other attractors"),
        (points.len() - told, "undecided"),
    ];
    for (count, words) in rest.into_iter().filter(|(count, _)| *count > 0) {
        let share = 100.0 * count as f64 / points.len() as f64;
        bars.push(Bar {
            value: share,
            words: format!("{share:.0} % {words}"),
            color: FAINT,
        });
    }
    let kicks = match points.len() {
        1 => "one kick".to_owned(),
        count => format!("{count} kicks"),
    };
    let shares = Panel {
        title: format!("shares of {kicks}"),
        x: Axis::linear("share, %", [0.0, 100.0]),
        y: Axis::linear("", [0.0, bars.len().max(1) as f64]),
        marks: vec![Mark::Bars { bars }],
    };
    let portraits = shown.iter().map(|attractor| portrait(points, attractor));
    let mut rows = vec![vec![shares]];
    let portraits: Vec<Panel> = portraits.collect();
    if !portraits.is_empty() {
        rows.push(portraits);
    }
    Figure::new("basins", title, [1200, 700], &rows)
}

/// What an attractor is, in words.
fn words(attractor: &Attractor) -> String {
    let [low, high] = attractor.interval.map(|share| 100.0 * share);
    let tone = match attractor.frequency {
        Some(hz) => format!(
            ", {:.3} kHz, {:.3} µm",
            1e-3 * hz,
            1e6 * attractor.amplitude
        ),
        None => String::new(),
    };
    format!(
        "{:.0} % ({low:.0} to {high:.0}) {}{tone}",
        100.0 * attractor.share,
        attractor.regime
    )
}

fn portrait(points: &[SweepPoint], attractor: &Attractor) -> Panel {
    let member = attractor.members.first().and_then(|&k| points.get(k));
    let response = member.and_then(|point| point.outcome.as_ref().ok());
    let portrait = response.and_then(|response| response.portrait.as_ref());
    let trail: Vec<[f64; 2]> = portrait.map_or_else(Vec::new, |portrait| {
        let pairs = portrait.displacement.iter().zip(&portrait.velocity);
        pairs
            .map(|(&u, &v)| [1e6 * f64::from(u), 1e3 * f64::from(v)])
            .collect()
    });
    Panel {
        title: match attractor.frequency {
            Some(hz) => format!("{}, {:.3} kHz", attractor.regime, 1e-3 * hz),
            None => attractor.regime.to_string(),
        },
        x: Axis::around("displacement, µm", trail.iter().map(|p| p[0])),
        y: Axis::around("velocity, mm/s", trail.iter().map(|p| p[1])),
        marks: vec![Mark::Line {
            points: trail,
            color: color_of(attractor.regime),
            label: String::new(),
        }],
    }
}
