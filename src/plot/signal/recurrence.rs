//! Recurrence plot, and recurrence quantification over time.

use super::SignalFigures;
use crate::analysis::{Measures, RecurrencePeriods};
use crate::plot::axis::extent;
use crate::plot::color::{Rgb, colormap, colormap_index};
use crate::plot::unit::Unit;
use crate::plot::{Axis, Color, Figure, Image, Layer, Panel, Swatch};

impl SignalFigures<'_> {
    pub fn recurrence(&self) -> Figure {
        let recurrence = match self.report.recurrence.get() {
            Ok(recurrence) => recurrence,
            Err(reason) => return self.skipped("recurrence", "Recurrence plot", reason),
        };
        let picture = &recurrence.picture;
        let analysed = self.report.analysed();
        let end = analysed.start + (analysed.samples.len() as f64 - 1.0) / analysed.rate;
        let end = end * self.time_unit.factor;
        let span = [end - picture.window * self.time_unit.factor, end];
        let axis = || Axis::linear(self.time_unit.after("time"), span);
        let panel = |title: String, bytes: &[u8], palette: Vec<Rgb>| {
            let rows = bytes.chunks_exact(picture.size.max(1)).rev();
            let image = Image {
                x: span,
                y: span,
                size: [picture.size; 2],
                pixels: rows.flatten().copied().collect(),
                palette: palette.into_iter().map(Swatch::uniform).collect(),
            };
            let layers = Some(Layer::image(image)).filter(|_| picture.size > 0);
            let layers = layers
                .into_iter()
                .chain(self.period_marks(&recurrence.periods, span));
            Panel::new(title, axis(), axis(), layers.collect()).square()
        };
        // Palette index: non-zero is recurrent; a small distance is dark.
        let mut recurrent = vec![Color::Ink.on_light(); 256];
        recurrent[0] = [255; 3];
        let shades = colormap();
        let distance = (0..=255u8).map(|byte| {
            let near = colormap_index(1.0 - f64::from(byte) / 255.0);
            shades[usize::from(near)]
        });
        let share = 100.0 * picture.rate;
        let row = vec![
            panel(
                format!("recurrence rate {share:.2} % in this plot"),
                &picture.recurrent,
                recurrent,
            ),
            panel(
                "distance: dark is close".to_owned(),
                &picture.distance,
                distance.collect(),
            ),
        ];
        Figure::new(
            "recurrence",
            self.title("Recurrence plot"),
            100.0,
            vec![row],
        )
    }

    /// The diagonals at the recurrence periods that fit in the plot, above the line of identity.
    fn period_marks(&self, periods: &RecurrencePeriods, [start, end]: [f64; 2]) -> Vec<Layer> {
        let inside = periods.0.iter().enumerate().filter_map(|(k, found)| {
            let offset = found.period * self.time_unit.factor;
            let label = format!("{}: {:.4} ms", found.kind, 1e3 * found.period);
            let line = vec![[start, start + offset], [end - offset, end]];
            (offset < end - start).then(|| {
                Layer::line(line, Color::Series(k))
                    .dashed()
                    .with_label(label)
            })
        });
        inside.collect()
    }

    pub fn measures(&self) -> Figure {
        let title = "Recurrence quantification over time";
        let along = match self.report.recurrence.get() {
            Ok(recurrence) => &recurrence.along,
            Err(reason) => return self.skipped("measures", title, reason),
        };
        let curve = |value: &dyn Fn(&Measures) -> Option<f64>| -> Vec<[f64; 2]> {
            let points = along.iter();
            let points = points
                .filter_map(|at| Some([at.time * self.time_unit.factor, value(&at.measures)?]));
            points.collect()
        };
        let times = extent(along.iter().map(|at| at.time * self.time_unit.factor));
        let x = || Axis::linear(self.time_unit.after("time"), times);
        let line =
            |points, series, label| Layer::line(points, Color::Series(series)).with_label(label);
        let shares = Panel::new(
            "RR, DET and LAM",
            x(),
            Axis::linear("", [0.0, 1.05]),
            vec![
                line(curve(&|m| Some(m.recurrence_rate)), 0, "RR"),
                line(curve(&|m| m.determinism), 2, "DET"),
                line(curve(&|m| m.laminarity), 3, "LAM"),
            ],
        );
        let lengths = [
            (curve(&|m| m.mean_diagonal), 2, "L"),
            (curve(&|m| m.trapping_time), 3, "TT"),
            (curve(&|m| m.recurrence_time_2), 4, "T²"),
        ];
        let longest = extent(lengths.iter().flat_map(|(c, ..)| c).map(|p| p[1]))[1];
        let unit = Unit::of("s", longest);
        let lengths = lengths.into_iter().map(|(points, series, label)| {
            let points = points.into_iter().map(|[t, s]| [t, s * unit.factor]);
            line(points.collect(), series, label)
        });
        let lengths = Panel::new(
            "mean line lengths L and TT, recurrence time T²",
            x(),
            Axis::linear(unit.after("duration"), [0.0, 1.08 * longest * unit.factor]),
            lengths.collect(),
        );
        let entropy = curve(&|m| m.entropy);
        let most = extent(entropy.iter().map(|p| p[1]))[1];
        let entropy = Panel::new(
            "entropy of the diagonal line lengths",
            x(),
            Axis::linear("nats", [0.0, 1.1 * most]),
            vec![Layer::line(entropy, Color::Ink)],
        );
        let rows = vec![vec![shares], vec![lengths], vec![entropy]];
        Figure::new("measures", self.title(title), 145.0, rows)
    }
}
