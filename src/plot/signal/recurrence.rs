//! Recurrence plot, and recurrence quantification over time.

use super::SignalFigures;
use crate::analysis::{Measures, RecurrencePeriods};
use crate::plot::axis::extent;
use crate::plot::unit::Unit;
use crate::plot::{Axis, Color, Figure, Layer, Panel, response};

impl SignalFigures<'_> {
    pub fn recurrence(&self) -> Figure {
        let recurrence = match self.report.recurrence.get() {
            Ok(recurrence) => recurrence,
            Err(reason) => return self.skipped("recurrence", "Recurrence plot", reason),
        };
        let picture = &recurrence.picture;
        let mut panel = response::recurrence(Some(picture), true);
        let marks = period_marks(&recurrence.periods, picture.window, panel.x.range);
        panel.layers.extend(marks);
        let share = 100.0 * picture.rate;
        let panel = panel.with_title(format!("recurrence rate {share:.2} % in this plot"));
        let rows = vec![vec![panel]];
        Figure::new("recurrence", self.title("Recurrence plot"), 115.0, rows).with_width(108.0)
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

/// The diagonals at the recurrence periods that fit in a plot of a window (s), above the line of identity.
fn period_marks(periods: &RecurrencePeriods, window: f64, [start, end]: [f64; 2]) -> Vec<Layer> {
    let inside = periods.0.iter().filter(|found| found.period < window);
    let marks = inside.enumerate().map(|(k, found)| {
        let offset = (end - start) * found.period / window;
        let line = vec![[start, start + offset], [end - offset, end]];
        let label = format!("{}: {}", found.kind, Unit::write(found.period, "s"));
        let line = Layer::line(line, Color::Series(k)).dashed();
        line.with_label(label)
    });
    marks.collect()
}
