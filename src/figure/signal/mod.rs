//! The figures of the report on a signal.

mod chaos;
mod recurrence;
mod space;
mod tones;

use super::panel::{Mark, extent};
use super::style::Rgb;
use super::{Figure, FigureError};
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
///
/// # Errors
/// [`FigureError`].
pub fn signal_figures(report: &SignalReport) -> Result<Vec<Figure>, FigureError> {
    let view = View::new(report);
    Ok(vec![
        view.waveform()?,
        view.spectrum()?,
        view.spectrogram()?,
        view.delay()?,
        view.portrait()?,
        view.recurrence()?,
        view.measures()?,
        view.section()?,
        view.divergence()?,
        view.zero_one()?,
        view.regime()?,
    ])
}

/// A unit to print numbers in.
struct Unit {
    name: String,
    per_own: f64,
}

impl Unit {
    /// For values up to `largest` in `unit`: with a prefix where the unit takes one, else with a
    /// power of ten.
    fn of(unit: &str, largest: f64) -> Self {
        const PLAIN: [&str; 9] = ["m", "m/s", "m/s²", "m/s^2", "Pa", "V", "A", "N", "s"];
        const PREFIXES: [&str; 6] = ["n", "µ", "m", "", "k", "M"];
        let large = largest.is_finite() && largest > 0.0;
        let step = if large {
            (largest.log10() / 3.0).floor() as i32
        } else {
            0
        };
        if PLAIN.contains(&unit) {
            let step = step.clamp(-3, 2);
            return Self {
                name: format!("{}{unit}", PREFIXES[(step + 3) as usize]),
                per_own: 10_f64.powi(-3 * step),
            };
        }
        if (-1..=1).contains(&step) {
            return Self {
                name: unit.to_owned(),
                per_own: 1.0,
            };
        }
        let power = format!("1e{}", 3 * step).replace('-', "−");
        Self {
            name: format!("{power} {unit}").trim_end().to_owned(),
            per_own: 10_f64.powi(-3 * step),
        }
    }

    /// A name with the unit behind it, if there is one.
    fn after(&self, name: &str) -> String {
        if self.name.is_empty() {
            name.to_owned()
        } else {
            format!("{name}, {}", self.name)
        }
    }
}

/// The report with what all figures need of it.
struct View<'a> {
    report: &'a SignalReport,
    /// Unit of the signal.
    unit: Unit,
    /// Unit of times along the signal.
    along: Unit,
    /// Frequencies are in kHz rather than in Hz.
    kilo: bool,
}

impl<'a> View<'a> {
    fn new(report: &'a SignalReport) -> Self {
        let samples = &report.signal.samples;
        let largest = samples.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let seconds = samples.len() as f64 / report.signal.rate;
        Self {
            report,
            unit: Unit::of(&report.signal.unit, largest),
            along: Unit::of("s", 0.5 * seconds.max(1e-6)),
            kilo: report.signal.rate >= 4000.0,
        }
    }

    fn title(&self, words: &str) -> String {
        format!("{words} — {}", self.report.signal.name)
    }

    fn time(&self, sample: f64) -> f64 {
        let signal = &self.report.signal;
        (signal.start + sample / signal.rate) * self.along.per_own
    }

    fn samples(&self) -> impl Iterator<Item = f64> + '_ {
        self.report
            .signal
            .samples
            .iter()
            .map(|x| x * self.unit.per_own)
    }

    fn frequency(&self, hz: f64) -> f64 {
        if self.kilo { 1e-3 * hz } else { hz }
    }

    fn frequency_name(&self) -> &'static str {
        if self.kilo {
            "frequency, kHz"
        } else {
            "frequency, Hz"
        }
    }

    /// The highest frequency worth showing, Hz: all lines, or all there is.
    fn top(&self) -> f64 {
        let nyquist = 0.5 * self.report.signal.rate;
        let lines = self.report.tones.lines.iter().map(|l| l.line.frequency);
        let highest = lines.fold(0.0, f64::max);
        if highest > 0.0 {
            (1.25 * highest).min(nyquist)
        } else {
            nyquist
        }
    }
}

fn line(points: Vec<[f64; 2]>, color: Rgb, label: &str) -> Mark {
    Mark::Line {
        points,
        color,
        label: label.to_owned(),
    }
}

fn dots(points: Vec<[f64; 2]>, radius: f64, color: Rgb, label: &str) -> Mark {
    Mark::Dots {
        points,
        radius,
        color,
        label: label.to_owned(),
    }
}

fn words(at: [f64; 2], words: &str) -> Mark {
    Mark::Words {
        at,
        words: words.to_owned(),
    }
}

/// A curve as it looks: with more samples than can be told apart, the smallest and the largest of
/// each stretch.
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
