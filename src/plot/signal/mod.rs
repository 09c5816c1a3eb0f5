//! The figures of the report on a signal.

mod chaos;
mod recurrence;
mod space;
mod tones;

use super::axis::extent;
use super::figure::Figure;
use super::unit::Unit;
use crate::study::signal::SignalReport;

/// Most points of a curve: more cannot be told apart.
const MOST_POINTS: usize = 4000;

/// Stems of the names of the figures that [`signal_figures`] draws.
pub const SIGNAL_FIGURES: [&str; 11] = [
    "waveform",
    "spectrum",
    "spectrogram",
    "delay",
    "portrait",
    "recurrence",
    "measures",
    "section",
    "divergence",
    "zero_one",
    "regime",
];

/// One figure a subject, as [`SIGNAL_FIGURES`] lists them.
pub fn signal_figures(report: &SignalReport) -> Vec<Figure> {
    let view = View::new(report);
    vec![
        view.waveform(),
        view.spectrum(),
        view.spectrogram(),
        view.delay(),
        view.portrait(),
        view.recurrence(),
        view.measures(),
        view.section(),
        view.divergence(),
        view.zero_one(),
        view.regime(),
    ]
}

/// The report with what all figures need of it.
struct View<'a> {
    report: &'a SignalReport,
    /// Unit of the signal.
    unit: Unit,
    /// Unit of times along the signal.
    along: Unit,
    /// Unit of frequencies.
    hertz: Unit,
}

impl<'a> View<'a> {
    fn new(report: &'a SignalReport) -> Self {
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
            along: Unit::of("s", 0.5 * seconds.max(1e-6)),
            hertz: Unit::of("Hz", highest),
        }
    }

    fn title(&self, words: &str) -> String {
        format!("{words} of {}", self.report.signal.name)
    }

    fn time(&self, sample: f64) -> f64 {
        let signal = &self.report.signal;
        (signal.start + sample / signal.rate) * self.along.factor
    }

    /// All samples in their unit on show. A signal may fill the memory: no second copy is made of it.
    fn samples(&self) -> impl Iterator<Item = f64> + '_ {
        let samples = self.report.signal.samples.iter();
        samples.map(|x| x * self.unit.factor)
    }

    /// The highest frequency worth showing, Hz: all lines, or all there is.
    fn top(&self) -> f64 {
        let nyquist = 0.5 * self.report.signal.rate;
        let lines = self.report.tones.lines.iter().map(|l| l.line.frequency);
        match lines.fold(0.0, f64::max) {
            highest if highest > 0.0 => (1.25 * highest).min(nyquist),
            _ => nyquist,
        }
    }
}

/// A curve as it looks: with more samples than can be told apart, the smallest and the largest of
/// each stretch.
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
