//! The space it moves in: lag and dimension, portrait, Poincare section.

use super::{MOST_POINTS, View, dots, line};
use crate::analysis::return_map;
use crate::figure::panel::{Axis, Mark, Panel, extent};
use crate::figure::style::{BLUE, VERMILION};
use crate::figure::{Figure, FigureError};

impl View<'_> {
    pub fn delay(&self) -> Result<Figure, FigureError> {
        let delay = &self.report.embedding.choice;
        let bits = &delay.mutual.bits;
        let curve: Vec<[f64; 2]> = bits
            .iter()
            .enumerate()
            .map(|(k, &b)| [k as f64, b])
            .collect();
        let mutual = Panel {
            title: "average mutual information".to_owned(),
            x: Axis::linear("lag, samples", [0.0, bits.len().saturating_sub(1) as f64]),
            y: Axis::linear("bits", [0.0, 1.08 * extent(bits.iter().copied())[1]]),
            marks: vec![
                line(curve, BLUE, ""),
                Mark::Upright {
                    x: delay.lag as f64,
                    words: format!("τ = {}", delay.lag),
                    color: VERMILION,
                },
            ],
        };
        let share = &delay.neighbours.share;
        let curve: Vec<[f64; 2]> = share
            .iter()
            .enumerate()
            .map(|(k, &s)| [k as f64 + 1.0, 100.0 * s])
            .collect();
        let neighbours = Panel {
            title: "false nearest neighbours".to_owned(),
            x: Axis::linear("dimension", [0.5, share.len() as f64 + 0.5]),
            y: Axis::linear("share, %", [-3.0, 105.0]),
            marks: vec![
                line(curve.clone(), BLUE, ""),
                dots(curve, 3.5, BLUE, ""),
                Mark::Upright {
                    x: delay.dimension as f64,
                    words: format!("m = {}", delay.dimension),
                    color: VERMILION,
                },
            ],
        };
        Figure::new(
            "delay",
            &self.title("Lag and dimension"),
            [900, 380],
            &[vec![mutual, neighbours]],
        )
    }

    pub fn portrait(&self) -> Result<Figure, FigureError> {
        let samples = &self.report.signal.samples;
        let lag = self.report.embedding.choice.lag;
        let count = samples.len().saturating_sub(lag);
        let newest = count.saturating_sub(2 * MOST_POINTS);
        let points: Vec<[f64; 2]> = (newest..count)
            .map(|k| [k, k + lag].map(|k| samples[k] * self.unit.per_own))
            .collect();
        let panel = Panel {
            title: format!("lag {lag} samples, the newest {}", points.len()),
            x: Axis::around(self.unit.after("y(t)"), self.samples()),
            y: Axis::around(self.unit.after("y(t + τ)"), self.samples()),
            marks: vec![line(points, BLUE, "")],
        };
        Figure::new(
            "portrait",
            &self.title("Delay portrait"),
            [560, 560],
            &[vec![panel]],
        )
    }

    pub fn section(&self) -> Result<Figure, FigureError> {
        let scaled = |c: usize| {
            let passages = self.report.section.passages.iter();
            passages.map(move |passage| passage.at[c] * self.unit.per_own)
        };
        let (first, third): (Vec<f64>, Vec<f64>) = (scaled(0).collect(), scaled(1).collect());
        let points: Vec<[f64; 2]> = first.iter().zip(&third).map(|(&a, &b)| [a, b]).collect();
        let map = return_map(&first);
        let count = points.len();
        let radius = if count > 1000 { 1.0 } else { 2.0 };
        let map_mark = dots(map, radius, BLUE, "");
        let panel =
            |title: String, [x, y]: [&str; 2], x_values: &[f64], y_values: &[f64], mark| Panel {
                title,
                x: Axis::around(self.unit.after(x), x_values.iter().copied()),
                y: Axis::around(self.unit.after(y), y_values.iter().copied()),
                marks: vec![mark],
            };
        let section = panel(
            format!("{count} passages"),
            ["y(t)", "y(t + 2τ)"],
            &first,
            &third,
            dots(points, radius, BLUE, ""),
        );
        let map = panel(
            "return map".to_owned(),
            ["y(t) at a passage", "y(t) at the next"],
            &first,
            &first,
            map_mark,
        );
        Figure::new(
            "section",
            &self.title("Poincaré section y(t + τ) = mean"),
            [1000, 500],
            &[vec![section, map]],
        )
    }
}
