//! Figures of the report on a signal.

mod chaos;
mod events;
mod recurrence;
mod space;
mod tones;

use super::axis::{Axis, extent};
use super::figure::{Figure, Panel};
use super::unit::Unit;
use crate::study::signal::{SignalAnalysis, SkipReason};

/// Maximum number of points of a curve; more cannot be resolved.
const MOST_POINTS: usize = 4000;

/// The rows of a figure and its height, mm.
type Picture = Result<(f64, Vec<Vec<Panel>>), SkipReason>;

/// A figure: name, what it shows, and its picture.
type Drawing<'a> = (
    &'static str,
    &'static str,
    fn(&SignalFigures<'a>) -> Picture,
);

fn drawings<'a>() -> [Drawing<'a>; 13] {
    type View<'a> = SignalFigures<'a>;
    [
        ("events", "Tonal events", View::events),
        ("waveform", "Waveform", View::waveform),
        ("spectrum", "Spectrum", View::spectrum),
        ("spectrogram", "Spectrogram", View::spectrogram),
        ("delay", "Delay and dimension", View::delay),
        ("portrait", "Delay portrait", View::portrait),
        ("recurrence", "Recurrence plot", View::recurrence),
        (
            "measures",
            "Recurrence quantification over time",
            View::measures,
        ),
        ("section", "Poincaré section y(t + τ) = mean", View::section),
        (
            "return_times",
            "Times between the crossings of the Poincaré section",
            View::return_times,
        ),
        (
            "divergence",
            "Divergence of nearby states",
            View::divergence,
        ),
        ("zero_one", "0–1 test for chaos", View::zero_one),
        ("regime", "Type of motion", View::regime),
    ]
}

/// Names of the figures of [`signal_figures`], in their order.
pub fn signal_figure_names() -> [&'static str; 13] {
    drawings().map(|(name, ..)| name)
}

/// The figures of a report.
pub fn signal_figures(report: &SignalAnalysis) -> Vec<Figure> {
    let view = SignalFigures::new(report);
    let figures = drawings().into_iter().map(|(name, title, picture)| {
        let skipped = |reason| (60.0, vec![vec![skipped_panel("skipped", reason)]]);
        let (height, rows) = picture(&view).unwrap_or_else(skipped);
        let title = format!("{title} of {}", report.signal.name);
        Figure::new(name, title, height, rows)
    });
    figures.collect()
}

/// The report whose figures are drawn.
struct SignalFigures<'a> {
    report: &'a SignalAnalysis,
    /// Unit in which the samples are written.
    unit: Unit,
}

impl<'a> SignalFigures<'a> {
    fn new(report: &'a SignalAnalysis) -> Self {
        let samples = &report.signal.samples;
        let largest = samples.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let unit = Unit::of(&report.signal.unit, largest);
        Self { report, unit }
    }

    /// An axis of the samples.
    fn samples_axis(&self, name: &str) -> Axis {
        let samples = self.report.analysed().samples.iter();
        Axis::with_margin(name, samples.copied()).written_in(self.unit.clone())
    }

    /// An axis of times, s, in a unit that suits the duration.
    fn time_axis(&self, times: [f64; 2]) -> Axis {
        let signal = &self.report.signal;
        let seconds = signal.samples.len() as f64 / signal.rate;
        Axis::linear("time", times).written_in(Unit::of("s", 0.5 * seconds.max(1e-6)))
    }

    /// An axis of frequencies up to the highest, Hz.
    fn frequency_axis(&self, highest: f64) -> Axis {
        let is_fast = self.report.signal.rate >= 4000.0;
        let unit = Unit::of("Hz", if is_fast { 1e3 } else { 1.0 });
        Axis::linear("frequency", [0.0, highest]).written_in(unit)
    }

    /// Highest frequency shown, Hz: above all lines and events, or the Nyquist frequency.
    fn top(&self) -> f64 {
        self.report.highest_frequency(1.25)
    }
}

/// A panel without data that says why.
fn skipped_panel(title: &str, reason: SkipReason) -> Panel {
    let axis = || Axis::linear("", [0.0, 1.0]);
    Panel::new(title, axis(), axis(), Vec::new()).with_note(reason.to_string())
}

/// The curve at the resolution of the figure: minimum and maximum of each interval if there are too many
/// samples.
fn envelope(values: &[f64], at: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
    if values.len() <= MOST_POINTS {
        return values
            .iter()
            .enumerate()
            .map(|(k, &v)| [at(k), v])
            .collect();
    }
    let stretch = values.len().div_ceil(MOST_POINTS / 2);
    let pair = |(n, part): (usize, &[f64])| {
        let [low, high] = extent(part.iter().copied());
        let x = at(n * stretch + part.len() / 2);
        [[x, low], [x, high]]
    };
    values.chunks(stretch).enumerate().flat_map(pair).collect()
}

#[cfg(all(test, feature = "figure"))]
mod features_tests;
