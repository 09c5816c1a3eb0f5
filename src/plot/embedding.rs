//! Panels of the choice of a delay embedding, as in Fig. 8 of the paper.

use super::{Axis, Color, Layer, Panel, axis::extent, round_up};
use crate::analysis::delay::DelayChoice;

/// Average mutual information over the delay, with the chosen delay and its legend entry; `step` is the delay of one sample
/// in `unit`: a prefix is added to that of a time.
pub fn mutual_information(choice: &DelayChoice, (step, unit): (f64, &str), label: &str) -> Panel {
    let bits = &choice.mutual.bits;
    let curve = bits.iter().enumerate();
    let curve = curve.map(|(k, bits)| [step * k as f64, *bits]).collect();
    let largest = step * bits.len().saturating_sub(1).max(1) as f64;
    let [_, most] = extent(bits.iter().copied());
    let x = Axis::linear("delay", [0.0, largest]).of(unit);
    let range = [0.0, round_up(most.max(1e-3))];
    let y = Axis::linear("average mutual information, bits", range);
    let chosen = Layer::vertical_lines([step * choice.lag as f64], Color::Accent);
    let layers = vec![Layer::line(curve, Color::Ink), chosen.with_label(label)];
    Panel::new("average mutual information", x, y, layers)
}

/// Share of false nearest neighbours over the dimension, with the chosen dimension and its legend entry.
pub fn false_neighbours(choice: &DelayChoice, label: &str) -> Panel {
    let shares = choice.neighbours.share.iter().zip(1..);
    let shares = shares.map(|(share, k)| [f64::from(k), 100.0 * share]);
    let shares: Vec<[f64; 2]> = shares.collect();
    let x = Axis::integers("embedding dimension m", shares.len());
    let y = Axis::linear("false nearest neighbours, %", [-3.0, 105.0]);
    let layers = vec![
        Layer::line(shares.clone(), Color::Ink),
        Layer::points(shares, 2.4, Color::Ink),
        Layer::vertical_lines([choice.dimension as f64], Color::Accent).with_label(label),
    ];
    Panel::new("false nearest neighbours", x, y, layers)
}
