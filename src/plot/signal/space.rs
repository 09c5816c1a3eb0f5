//! Delay embedding: delay and dimension, delay portrait, Poincaré section.

use super::{MOST_POINTS, Picture, SignalFigures};
use crate::plot::axis::extent;
use crate::plot::run::range_shown;
use crate::plot::section::SectionAxes;
use crate::plot::{Color, Layer, Panel, false_neighbours, mutual_information};

impl SignalFigures<'_> {
    pub fn delay(&self) -> Picture {
        let delay = &self.report.embedding.get()?.choice;
        let lag = format!("τ = {}", delay.lag);
        let mutual = mutual_information(delay, (1.0, "samples"), &lag);
        let neighbours = false_neighbours(delay, &format!("m = {}", delay.dimension));
        Ok((76.0, vec![vec![mutual, neighbours]]))
    }

    pub fn portrait(&self) -> Picture {
        let lag = self.report.embedding.get()?.choice.lag;
        let samples = &self.report.analysed().samples;
        let count = samples.len().saturating_sub(lag);
        let newest = count.saturating_sub(2 * MOST_POINTS)..count;
        let points: Vec<[f64; 2]> = newest.map(|k| [samples[k], samples[k + lag]]).collect();
        let title = format!("delay {lag} samples, the last {}", points.len());
        let [x, y] = ["y(t)", "y(t + τ)"].map(|name| self.samples_axis(name));
        let curve = Layer::line(points, Color::Ink).with_size(0.6);
        let panel = Panel::new(title, x, y, vec![curve]);
        Ok((108.0, vec![vec![panel.square()]]))
    }

    pub fn section(&self) -> Picture {
        let section = self.report.section.get()?;
        let points: Vec<[f64; 2]> = section
            .crossings
            .iter()
            .map(|crossing| crossing.at)
            .collect();
        let mut axes = self.section_axes();
        axes.fit(points.iter());
        let map = axes.return_map(&points, Color::Ink);
        let section = axes.section(&points, Color::Ink);
        let section = section.with_title(format!("{} intersections", points.len()));
        Ok((96.0, vec![vec![section, map]]))
    }

    /// The axes of a section about the middle of the samples.
    fn section_axes(&self) -> SectionAxes {
        let span = extent(self.report.analysed().samples.iter().copied());
        SectionAxes::delayed("y", &self.report.signal.unit, range_shown(span))
    }

    pub fn return_times(&self) -> Picture {
        let crossings = self.report.section.get()?.crossings.iter();
        let times: Vec<f64> = crossings.map(|crossing| crossing.time_s).collect();
        let panel = self.section_axes().return_times(&times, Color::Ink);
        Ok((88.0, vec![vec![panel]]))
    }
}
