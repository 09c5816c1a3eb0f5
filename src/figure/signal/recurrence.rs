//! When it comes back: recurrence plot and its measures along time.

use super::{Unit, View, line};
use crate::analysis::Measures;
use crate::figure::panel::{Axis, Mark, Panel, extent};
use crate::figure::style::{self, BLUE, GREEN, INK, PURPLE, Rgb, VERMILION};
use crate::figure::{Figure, FigureError};
use crate::study::signal::MeasuresAt;

impl View<'_> {
    pub fn recurrence(&self) -> Result<Figure, FigureError> {
        let picture = &self.report.recurrence.picture;
        let end = self.time(self.report.signal.samples.len() as f64 - 1.0);
        let span = [end - picture.window * self.along.per_own, end];
        let rows = |bytes: &[u8], paint: &dyn Fn(u8) -> Rgb| -> Vec<Rgb> {
            let rows = bytes.chunks_exact(picture.size.max(1)).rev();
            rows.flatten().map(|&byte| paint(byte)).collect()
        };
        let recurrent = |byte: u8| if byte > 0 { INK } else { [255; 3] };
        let distance = |byte: u8| style::shade(1.0 - f64::from(byte) / 255.0);
        let panel = |title: String, pixels: Vec<Rgb>| Panel {
            title,
            x: Axis::linear(self.along.after("time"), span),
            y: Axis::linear(self.along.after("time"), span),
            marks: if picture.size == 0 {
                vec![]
            } else {
                vec![Mark::Picture {
                    x: span,
                    y: span,
                    size: [picture.size; 2],
                    pixels,
                }]
            },
        };
        let measures = &self.report.recurrence.measures;
        let title = format!(
            "recurrent: {:.2} % of the pairs",
            100.0 * measures.recurrence_rate
        );
        Figure::new(
            "recurrence",
            &self.title("Recurrence plot"),
            [1000, 520],
            &[vec![
                panel(title, rows(&picture.recurrent, &recurrent)),
                panel(
                    "distance: dark is near".to_owned(),
                    rows(&picture.distance, &distance),
                ),
            ]],
        )
    }

    pub fn measures(&self) -> Result<Figure, FigureError> {
        let along = &self.report.recurrence.along;
        let curve = |value: &dyn Fn(&Measures) -> Option<f64>| -> Vec<[f64; 2]> {
            let point =
                |at: &MeasuresAt| value(&at.measures).map(|v| [at.time * self.along.per_own, v]);
            along.iter().filter_map(point).collect()
        };
        let times = extent(along.iter().map(|at| at.time * self.along.per_own));
        let x = || Axis::linear(self.along.after("time"), times);
        let shares = Panel {
            title: "shares".to_owned(),
            x: x(),
            y: Axis::linear("", [0.0, 1.05]),
            marks: vec![
                line(curve(&|m| Some(m.recurrence_rate)), BLUE, "RR"),
                line(curve(&|m| m.determinism), VERMILION, "DET"),
                line(curve(&|m| m.laminarity), GREEN, "LAM"),
            ],
        };
        let lengths = [
            (curve(&|m| m.mean_diagonal), VERMILION, "L"),
            (curve(&|m| m.trapping_time), GREEN, "TT"),
            (curve(&|m| m.recurrence_time_2), PURPLE, "T²"),
        ];
        let longest = extent(lengths.iter().flat_map(|(c, ..)| c).map(|p| p[1]))[1];
        let unit = Unit::of("s", longest);
        let lengths: Vec<Mark> = lengths
            .into_iter()
            .map(|(points, color, label)| {
                let points = points
                    .into_iter()
                    .map(|[t, s]| [t, s * unit.per_own])
                    .collect();
                line(points, color, label)
            })
            .collect();
        let lengths = Panel {
            title: "mean lengths of lines and gaps".to_owned(),
            x: x(),
            y: Axis::linear(unit.after("duration"), [0.0, 1.08 * longest * unit.per_own]),
            marks: lengths,
        };
        let entropy = curve(&|m| m.entropy);
        let most = extent(entropy.iter().map(|p| p[1]))[1];
        let entropy = Panel {
            title: "entropy of the diagonal lines".to_owned(),
            x: x(),
            y: Axis::linear("nats", [0.0, 1.1 * most]),
            marks: vec![line(entropy, BLUE, "")],
        };
        Figure::new(
            "measures",
            &self.title("Recurrence quantification along time"),
            [900, 760],
            &[vec![shares], vec![lengths], vec![entropy]],
        )
    }
}
