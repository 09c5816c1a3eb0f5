//! Recurrence plot, and recurrence quantification over time.

use super::{Picture, SignalFigures};
use crate::analysis::recurrence::{Measures, RecurrencePeriods};
use crate::plot::axis::extent;
use crate::plot::unit::Unit;
use crate::plot::{Axis, Color, Layer, Panel, response};

impl SignalFigures<'_> {
    pub fn recurrence(&self) -> Picture {
        let recurrence = self.report.recurrence.get()?;
        let picture = &recurrence.picture;
        let mut panel = response::recurrence(Some(picture), true);
        let marks = period_marks(&recurrence.recurrence_periods, picture.window);
        panel.layers.extend(marks);
        let share = 100.0 * picture.rate;
        let panel = panel.with_title(format!("recurrence rate {share:.2} % in this plot"));
        Ok((115.0, vec![vec![panel]]))
    }

    pub fn measures(&self) -> Picture {
        let windows = &self.report.recurrence.get()?.windows;
        let line = |label, color, value: &dyn Fn(&Measures) -> Option<f64>| {
            let points = windows.iter();
            let points = points.filter_map(|at| Some([at.time_s, value(&at.measures)?]));
            Layer::line(points.collect(), color).with_label(label)
        };
        let most = |layers: &[Layer]| {
            let points = layers.iter().flat_map(Layer::points_of);
            extent(points.map(|p| p[1]))[1]
        };
        let times = extent(windows.iter().map(|at| at.time_s));
        let [rates, lines, recurrences] = [0, 2, 3].map(Color::Series);
        let shares = Panel::new(
            "RR, DET and LAM",
            self.time_axis(times),
            Axis::linear("", [0.0, 1.05]),
            vec![
                line("RR", rates, &|m| Some(m.recurrence_rate)),
                line("DET", lines, &|m| m.determinism),
                line("LAM", recurrences, &|m| m.laminarity),
            ],
        );
        let lengths = vec![
            line("L", lines, &|m| m.mean_diagonal),
            line("TT", recurrences, &|m| m.trapping_time),
            line("T²", Color::Series(4), &|m| m.recurrence_time_2),
        ];
        let lengths = Panel::new(
            "mean line lengths L and TT, recurrence time T²",
            self.time_axis(times),
            Axis::linear("duration", [0.0, 1.08 * most(&lengths)]).of("s"),
            lengths,
        );
        let entropy = vec![line("", Color::Ink, &|m| m.entropy)];
        let entropy = Panel::new(
            "entropy of the diagonal line lengths",
            self.time_axis(times),
            Axis::linear("nats", [0.0, 1.1 * most(&entropy)]),
            entropy,
        );
        Ok((145.0, vec![vec![shares], vec![lengths], vec![entropy]]))
    }
}

/// The diagonals at the recurrence periods that fit in a plot of a window (s), above the line of identity.
fn period_marks(periods: &RecurrencePeriods, window: f64) -> Vec<Layer> {
    let inside = periods.0.iter().filter(|found| found.period < window);
    let marks = inside.enumerate().map(|(k, found)| {
        let line = vec![[-window, found.period - window], [-found.period, 0.0]];
        let label = format!("{}: {}", found.kind, Unit::write(found.period, "s"));
        let line = Layer::line(line, Color::Series(k)).dashed();
        line.with_label(label)
    });
    marks.collect()
}
