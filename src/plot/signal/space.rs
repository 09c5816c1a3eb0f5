//! Delay embedding: delay and dimension, delay portrait, Poincaré section.

use super::{MOST_POINTS, SignalFigures};
use crate::plot::axis::extent;
use crate::plot::run::range_shown;
use crate::plot::section::SectionAxes;
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
        let points: Vec<[f64; 2]> = section.passages.iter().map(|passage| passage.at).collect();
        let mut axes = self.section_axes();
        axes.fit(points.iter());
        let map = axes.return_map(&points, Color::Ink);
        let section = axes.section(&points, Color::Ink);
        let section = section.with_title(format!("{} intersections", points.len()));
        let title = self.title("Poincaré section y(t + τ) = mean");
        Figure::new("section", title, 96.0, vec![vec![section, map]])
    }

    /// The axes of a section about the middle of the samples.
    fn section_axes(&self) -> SectionAxes {
        let span = extent(self.report.analysed().samples.iter().copied());
        SectionAxes::delayed("y", &self.report.signal.unit, range_shown(span))
    }

    pub fn return_times(&self) -> Figure {
        let title = "Times between the crossings of the Poincaré section";
        let section = match self.report.section.get() {
            Ok(section) => section,
            Err(reason) => return self.skipped("return_times", title, reason),
        };
        let times: Vec<f64> = section
            .passages
            .iter()
            .map(|passage| passage.time)
            .collect();
        let panel = self.section_axes().return_times(&times, Color::Ink);
        let rows = vec![vec![panel]];
        Figure::new("return_times", self.title(title), 88.0, rows)
    }
}
