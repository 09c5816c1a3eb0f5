//! Delay embedding: delay and dimension, delay portrait, Poincaré section.

use super::{MOST_POINTS, SignalFigures};
use crate::analysis::return_map;
use crate::plot::{Axis, Color, Figure, Layer, Panel, false_neighbours, mutual_information};

impl SignalFigures<'_> {
    pub fn delay(&self) -> Figure {
        let delay = match self.report.embedding.get() {
            Ok(embedding) => &embedding.choice,
            Err(reason) => return self.skipped("delay", "Delay and dimension", reason),
        };
        let mutual = mutual_information(delay, "samples", 1.0);
        let mutual = mutual.with_top_label(format!("τ = {}", delay.lag));
        let neighbours = false_neighbours(delay);
        let neighbours = neighbours.with_top_label(format!("m = {}", delay.dimension));
        let rows = vec![vec![mutual, neighbours]];
        Figure::new("delay", self.title("Delay and dimension"), 76.0, rows)
    }

    pub fn portrait(&self) -> Figure {
        let lag = match self.report.embedding.get() {
            Ok(embedding) => embedding.choice.lag,
            Err(reason) => return self.skipped("portrait", "Delay portrait", reason),
        };
        let samples = &self.report.analysed().samples;
        let count = samples.len().saturating_sub(lag);
        let newest = count.saturating_sub(2 * MOST_POINTS)..count;
        let points = newest.map(|k| [k, k + lag].map(|k| samples[k] * self.unit.factor));
        let points: Vec<[f64; 2]> = points.collect();
        let axis = |name: &str| Axis::with_margin(self.unit.after(name), self.scaled(samples));
        let panel = Panel::new(
            format!("delay {lag} samples, the last {}", points.len()),
            axis("y(t)"),
            axis("y(t + τ)"),
            vec![Layer::line(points, Color::Ink).with_line_width(0.6)],
        );
        let rows = vec![vec![panel.square()]];
        Figure::new("portrait", self.title("Delay portrait"), 108.0, rows).with_width(108.0)
    }

    pub fn section(&self) -> Figure {
        let section = match self.report.section.get() {
            Ok(section) => section,
            Err(reason) => return self.skipped("section", "Poincaré section", reason),
        };
        let scaled = |c: usize| {
            let passages = section.passages.iter();
            passages.map(move |passage| passage.at[c] * self.unit.factor)
        };
        let (first, third): (Vec<f64>, Vec<f64>) = (scaled(0).collect(), scaled(1).collect());
        let points: Vec<[f64; 2]> = first.iter().zip(&third).map(|(&a, &b)| [a, b]).collect();
        let radius = if points.len() > 1000 { 0.7 } else { 1.4 };
        let axis = |name: &str, values: &[f64]| {
            Axis::with_margin(self.unit.after(name), values.iter().copied())
        };
        let panel = |title: String, x, y, points| {
            let points = Layer::points(points, radius, Color::Ink);
            Panel::new(title, x, y, vec![points]).square()
        };
        let section = panel(
            format!("{} intersections", points.len()),
            axis("y(t)", &first),
            axis("y(t + 2τ)", &third),
            points,
        );
        let map = panel(
            "return map".to_owned(),
            axis("y(t) at an intersection", &first),
            axis("y(t) at the next", &first),
            return_map(&first),
        );
        let title = self.title("Poincaré section y(t + τ) = mean");
        Figure::new("section", title, 96.0, vec![vec![section, map]])
    }
}
