//! Figure of coexisting attractors: the share of kicks that lead to each, and their phase portraits.

use super::{Axis, Color, Figure, Layer, Panel, response};
use crate::study::basins::Attractor;
use crate::study::sweep::SweepPoint;

/// Maximum number of attractors shown.
const MOST: usize = 4;

/// Bars with the share of each attractor, and phase portraits of the most frequent. `title` names the scene.
pub fn basins_figure(title: &str, points: &[SweepPoint], attractors: &[Attractor]) -> Figure {
    let shown = &attractors[..attractors.len().min(MOST)];
    let count = |some: &[Attractor]| some.iter().map(|a| a.seeds.len()).sum::<usize>();
    let share = |count: usize| 100.0 * count as f64 / points.len() as f64;
    let others = [
        (count(&attractors[shown.len()..]), "other attractors"),
        (points.len() - count(attractors), "unclassified"),
    ];
    let others = others.into_iter().filter(|(count, _)| *count > 0);
    let others = others.map(|(count, name)| (share(count), name.to_owned(), Color::Faint));
    let named = shown.iter().map(|attractor| {
        let color = Color::Regime(attractor.regime);
        (100.0 * attractor.share, name(attractor), color)
    });
    let rows = named.chain(others).map(|(share, name, color)| {
        let name = format!("{share:.0} % {name}");
        (name, vec![([0.0, share], color)])
    });
    let kicks = match points.len() {
        1 => "one kick".to_owned(),
        count => format!("{count} kicks"),
    };
    let heading = format!("shares of {kicks} with 95 % intervals");
    let axis = Axis::linear("share, %", [0.0, 100.0]);
    let mut shares = Panel::bars(&heading, axis, rows.collect());
    let intervals = shown.iter().enumerate().map(|(row, attractor)| {
        let ends = attractor.share_interval.map(|share| 100.0 * share);
        ends.map(|share| [share, shares.y.row(row)]).to_vec()
    });
    let intervals = Layer::lines(intervals.collect(), Color::Ink);
    shares.layers.push(intervals);
    let portraits = shown.iter().map(|attractor| portrait(points, attractor));
    let mut rows = vec![vec![shares], portraits.collect()];
    rows.retain(|row| !row.is_empty());
    Figure::new("basins", title, 115.0, rows)
}

/// Name of an attractor: type of motion and frequency.
fn name(attractor: &Attractor) -> String {
    match attractor.frequency_hz {
        Some(hz) => format!("{}, {:.3} kHz", attractor.regime, 1e-3 * hz),
        None => attractor.regime.to_string(),
    }
}

fn portrait(points: &[SweepPoint], attractor: &Attractor) -> Panel {
    let seed = |point: &SweepPoint| point.place.values[0] as u64;
    let first = attractor.seeds.first();
    let point = points.iter().find(|point| Some(&seed(point)) == first);
    let response = point.and_then(SweepPoint::found);
    let portrait = response.and_then(|response| response.portrait.as_ref());
    let trail = portrait.map_or_else(Vec::new, response::samples);
    let color = Color::Regime(attractor.regime);
    response::phase_portrait(&trail, None, color).with_title(name(attractor))
}
