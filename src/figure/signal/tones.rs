//! What the signal looks and sounds like: waveform, spectrum, spectrogram.

use super::{View, dots, envelope, line, words};
use crate::figure::panel::{Axis, Mark, Panel, extent};
use crate::figure::style::{self, BLUE, VERMILION};
use crate::figure::{Figure, FigureError};

/// Periods (or, without one, hundredths of the signal) that a close view shows.
const CLOSE_PERIODS: f64 = 12.0;
/// Lines of the spectrum that get a name.
const NAMED_LINES: usize = 8;
/// Decibels below the strongest that spectrum and spectrogram reach down to.
const DEPTH_DB: f64 = 100.0;

impl View<'_> {
    pub fn waveform(&self) -> Result<Figure, FigureError> {
        let all = &self.report.signal.samples;
        let count = all.len();
        let period = match self.report.tones.lines.first() {
            Some(line) => self.report.signal.rate / line.line.frequency,
            None => count as f64 / (100.0 * CLOSE_PERIODS),
        };
        let close = ((CLOSE_PERIODS * period).ceil() as usize).clamp(2.min(count), count);
        let panel = |title: &str, from: usize| Panel {
            title: title.to_owned(),
            x: Axis::linear(
                self.along.after("time"),
                [self.time(from as f64), self.time(count as f64 - 1.0)],
            ),
            y: Axis::around(self.unit.after("signal"), self.samples()),
            marks: vec![line(
                envelope(&all[from..], |k| self.time((from + k) as f64))
                    .into_iter()
                    .map(|[x, y]| [x, y * self.unit.per_own])
                    .collect(),
                BLUE,
                "",
            )],
        };
        Figure::new(
            "waveform",
            &self.title("Waveform"),
            [900, 560],
            &[
                vec![panel("the whole signal", 0)],
                vec![panel("its end, closely", count - close)],
            ],
        )
    }

    pub fn spectrum(&self) -> Result<Figure, FigureError> {
        let spectrum = &self.report.spectrum;
        let strongest = spectrum.amplitude.iter().copied().fold(0.0, f64::max);
        let level = |a: f64| 20.0 * (a.max(1e-12 * strongest) / strongest.max(1e-300)).log10();
        let shown = ((self.top() / spectrum.bin).ceil() as usize + 1).min(spectrum.amplitude.len());
        let levels: Vec<f64> = spectrum.amplitude[..shown]
            .iter()
            .map(|&a| level(a))
            .collect();
        let at = |k: usize| self.frequency(k as f64 * spectrum.bin);
        let lowest = extent(levels.iter().copied())[0].max(-DEPTH_DB - 20.0);
        let mut marks = vec![line(envelope(&levels, at), BLUE, "")];
        for named in self.report.tones.lines.iter().take(NAMED_LINES) {
            if named.line.label.is_empty() {
                continue;
            }
            let point = [
                self.frequency(named.line.frequency),
                level(named.line.amplitude),
            ];
            marks.push(dots(vec![point], 3.0, VERMILION, ""));
            marks.push(Mark::Words {
                at: [point[0], point[1] + 7.0],
                words: named.line.label.clone(),
            });
        }
        let unit = &self.unit;
        let name = format!(
            "amplitude, dB re {:.3} {}",
            strongest * unit.per_own,
            unit.name
        );
        let panel = Panel {
            title: format!(
                "{}; {:.2} % of the power in the floor",
                bases(&self.report.tones.naming.bases),
                100.0 * self.report.tones.floor_share
            ),
            x: Axis::linear(self.frequency_name(), [0.0, self.frequency(self.top())]),
            y: Axis::linear(name.trim_end(), [lowest, 16.0]),
            marks,
        };
        Figure::new(
            "spectrum",
            &self.title("Spectrum"),
            [900, 440],
            &[vec![panel]],
        )
    }

    pub fn spectrogram(&self) -> Result<Figure, FigureError> {
        let columns = &self.report.spectrogram;
        let marks = match (columns.first(), columns.last()) {
            (Some(first), Some(last)) => {
                let shown =
                    ((self.top() / first.bin).ceil() as usize).clamp(1, first.amplitude.len());
                let all = columns.iter().flat_map(|c| &c.amplitude[..shown]);
                let strongest = all.fold(1e-300_f64, |most, &a| most.max(a));
                let width = columns.len().min(1600);
                let height = shown.min(600);
                let mut pixels = Vec::with_capacity(width * height);
                for row in (0..height).rev() {
                    let bins = row * shown / height
                        ..((row + 1) * shown / height).max(row * shown / height + 1);
                    for x in 0..width {
                        let column = &columns[x * columns.len() / width];
                        let most = column.amplitude[bins.clone()]
                            .iter()
                            .copied()
                            .fold(0.0, f64::max);
                        let level = 20.0 * (most.max(1e-300) / strongest).log10();
                        pixels.push(style::shade(1.0 + level / (0.8 * DEPTH_DB)));
                    }
                }
                vec![Mark::Picture {
                    x: [self.time(first.centre), self.time(last.centre)],
                    y: [0.0, self.frequency(shown as f64 * first.bin)],
                    size: [width, height],
                    pixels,
                }]
            }
            _ => vec![words(
                [0.1, 0.5],
                "the signal is too short for a spectrogram",
            )],
        };
        let span = match marks.first() {
            Some(Mark::Picture { x, y, .. }) => (*x, *y),
            _ => ([0.0, 1.0], [0.0, 1.0]),
        };
        let panel = Panel {
            title: format!(
                "dark is strong, down to {:.0} dB below the strongest",
                0.8 * DEPTH_DB
            ),
            x: Axis::linear(self.along.after("time"), span.0),
            y: Axis::linear(self.frequency_name(), span.1),
            marks,
        };
        Figure::new(
            "spectrogram",
            &self.title("Spectrogram"),
            [900, 440],
            &[vec![panel]],
        )
    }
}

/// The base frequencies in words.
fn bases(bases: &crate::analysis::Bases) -> String {
    use crate::analysis::Bases;
    let hertz = |f: f64| {
        if f >= 1000.0 {
            format!("{:.4} kHz", 1e-3 * f)
        } else {
            format!("{f:.3} Hz")
        }
    };
    match bases {
        Bases::None => "no simple pattern of lines".to_owned(),
        Bases::One { f1 } => format!("f1 = {}", hertz(*f1)),
        Bases::Two { f1, f2 } => format!("f1 = {}, f2 = {}", hertz(*f1), hertz(*f2)),
    }
}
