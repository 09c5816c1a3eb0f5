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

/// Names of the figures of [`signal_figures`].
pub const SIGNAL_FIGURES: [&str; 13] = [
    "events",
    "waveform",
    "spectrum",
    "spectrogram",
    "delay",
    "portrait",
    "recurrence",
    "measures",
    "section",
    "return_times",
    "divergence",
    "zero_one",
    "regime",
];

/// The figures of a report, in the order of [`SIGNAL_FIGURES`].
pub fn signal_figures(report: &SignalAnalysis) -> Vec<Figure> {
    let view = SignalFigures::new(report);
    vec![
        view.events(),
        view.waveform(),
        view.spectrum(),
        view.spectrogram(),
        view.delay(),
        view.portrait(),
        view.recurrence(),
        view.measures(),
        view.section(),
        view.return_times(),
        view.divergence(),
        view.zero_one(),
        view.regime(),
    ]
}

/// The report and the units of its figures.
struct SignalFigures<'a> {
    report: &'a SignalAnalysis,
    /// Unit of the samples.
    unit: Unit,
    /// Unit of times.
    time_unit: Unit,
    /// Unit of frequencies.
    frequency_unit: Unit,
}

impl<'a> SignalFigures<'a> {
    fn new(report: &'a SignalAnalysis) -> Self {
        let samples = &report.signal.samples;
        let largest = samples.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let seconds = samples.len() as f64 / report.signal.rate;
        let highest = if report.signal.rate >= 4000.0 {
            1e3
        } else {
            1.0
        };
        Self {
            report,
            unit: Unit::of(&report.signal.unit, largest),
            time_unit: Unit::of("s", 0.5 * seconds.max(1e-6)),
            frequency_unit: Unit::of("Hz", highest),
        }
    }

    fn title(&self, words: &str) -> String {
        format!("{words} of {}", self.report.signal.name)
    }

    fn time(&self, sample: f64) -> f64 {
        let signal = &self.report.signal;
        (signal.start + sample / signal.rate) * self.time_unit.factor
    }

    /// Samples in the displayed unit. They are not copied, because a signal can fill the memory.
    fn scaled<'s>(&'s self, samples: &'s [f64]) -> impl Iterator<Item = f64> + 's {
        samples.iter().map(|x| x * self.unit.factor)
    }

    /// The figure of an analysis that was skipped, with the reason.
    fn skipped(&self, name: &str, title: &str, reason: SkipReason) -> Figure {
        let rows = vec![vec![skipped_panel("skipped", reason)]];
        Figure::new(name, self.title(title), 60.0, rows)
    }

    /// Highest frequency shown, Hz: above all lines and events, or the Nyquist frequency.
    fn top(&self) -> f64 {
        let nyquist = 0.5 * self.report.signal.rate;
        let lines = self.report.tones.lines.iter().map(|l| l.line.frequency);
        let events = self.report.events().iter();
        let events = events.map(|event| event.harmonics as f64 * event.frequency_high_hz);
        match lines.chain(events).fold(0.0, f64::max) {
            highest if highest > 0.0 => (1.25 * highest).min(nyquist),
            _ => nyquist,
        }
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
        let values = values.iter().enumerate();
        return values.map(|(k, &v)| [at(k), v]).collect();
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
