//! Waveform, spectrum, spectrogram.

use super::{Picture, SignalFigures, envelope};
use crate::analysis::{
    levels::LevelReference,
    tones::{Bases, Column},
};
use crate::number::significant;
use crate::plot::axis::extent;
use crate::plot::color::{colormap, colormap_index};
use crate::plot::figure::plain_palette;
use crate::plot::{Axis, Color, Image, Layer, Panel, Unit};

/// Periods shown in the detail panel; without a period, hundredths of the signal.
const CLOSE_PERIODS: f64 = 12.0;
/// Maximum number of labelled spectral lines.
const NAMED_LINES: usize = 8;
/// Range of the spectrum and of the spectrogram below the strongest line, dB.
const DEPTH_DB: f64 = 100.0;
const SPECTROGRAM_DB: f64 = 80.0;
/// Maximum number of rows of a spectrogram.
const ROWS: usize = 600;

impl SignalFigures<'_> {
    pub fn waveform(&self) -> Picture {
        let signal = &self.report.signal;
        let all = &signal.samples;
        let count = all.len();
        let period = match self.report.tones.lines.first() {
            Some(line) => signal.rate / line.line.frequency,
            None => count as f64 / (100.0 * CLOSE_PERIODS),
        };
        let close = ((CLOSE_PERIODS * period).ceil() as usize).clamp(2.min(count), count);
        let panel = |title: &str, from: usize| {
            let curve = envelope(&all[from..], |k| signal.time((from + k) as f64));
            let times = [from as f64, count as f64 - 1.0].map(|sample| signal.time(sample));
            let y = Axis::with_margin("signal", all.iter().copied());
            Panel::new(
                title,
                self.time_axis(times),
                y.written_in(self.unit.clone()),
                vec![Layer::line(curve, Color::Ink).with_size(0.8)],
            )
        };
        let whole = panel("whole signal", 0);
        let end = panel("end of the signal", count - close);
        Ok((112.0, vec![vec![whole], vec![end]]))
    }

    pub fn spectrum(&self) -> Picture {
        let spectrum = &self.report.spectrum;
        let strongest = spectrum.amplitude.iter().copied().fold(0.0, f64::max);
        // Relative to the strongest line, or to a sine of 20 uPa RMS.
        let sound = LevelReference::SoundPressure;
        let is_pressure = self.report.signal.unit == LevelReference::PASCAL;
        let (zero, reference) = if is_pressure {
            (sound.amplitude(strongest), sound.to_string())
        } else {
            let Unit { symbol, factor } = &self.unit;
            let shown = significant(strongest * factor, 3);
            (strongest.max(1e-300), format!("dB re {shown} {symbol}"))
        };
        let level = |a: f64| 20.0 * (a.max(1e-12 * strongest).max(1e-300) / zero).log10();
        let shown = ((self.top() / spectrum.bin).ceil() as usize + 1).min(spectrum.amplitude.len());
        let levels = spectrum.amplitude[..shown].iter().map(|&a| level(a));
        let levels: Vec<f64> = levels.collect();
        let top = level(strongest);
        let lowest = extent(levels.iter().copied())[0].max(top - DEPTH_DB - 20.0);
        let lines = self.report.tones.lines.iter().take(NAMED_LINES);
        let peaks = lines.filter_map(|named| {
            let at = [named.line.frequency, level(named.line.amplitude)];
            (!named.line.label.is_empty()).then(|| (at, named.line.label.clone()))
        });
        let bases = bases(&self.report.tones.naming.bases);
        let floor = 100.0 * self.report.tones.broadband_share;
        let title = format!("{bases}; broadband floor {floor:.2} %");
        let curve = envelope(&levels, |k| k as f64 * spectrum.bin);
        let curve = Layer::line(curve, Color::Ink).with_size(0.8);
        let name = format!("amplitude, {}", reference.trim_end());
        let y = Axis::linear(name, [lowest, top + 20.0]);
        let layers = vec![curve, Layer::peaks(peaks.collect())];
        let panel = Panel::new(title, self.frequency_axis(self.top()), y, layers);
        Ok((88.0, vec![vec![panel]]))
    }

    pub fn spectrogram(&self) -> Picture {
        Ok((88.0, vec![vec![self.spectrogram_panel()]]))
    }

    /// The spectrogram of the whole signal.
    pub fn spectrogram_panel(&self) -> Panel {
        let columns = &self.report.spectrogram;
        let image = columns.first().zip(columns.last()).map(|(first, last)| {
            let shown = ((self.top() / first.bin).ceil() as usize).clamp(1, first.amplitude.len());
            let times = [first.centre, last.centre].map(|sample| self.report.signal.time(sample));
            image(columns, shown, times, [0.0, shown as f64 * first.bin])
        });
        let (x, y, note) = match &image {
            Some(image) => (image.x, image.y[1], ""),
            None => ([0.0, 1.0], 1.0, "the signal is too short for a spectrogram"),
        };
        let panel = Panel::new(
            format!("dark is strong; range {SPECTROGRAM_DB:.0} dB"),
            self.time_axis(x),
            self.frequency_axis(y),
            image.map(Layer::image).into_iter().collect(),
        );
        panel.with_note(note)
    }
}

/// The lowest bins of the columns as an image; each pixel shows the largest amplitude of its bins.
fn image(columns: &[Column], bins: usize, x: [f64; 2], y: [f64; 2]) -> Image {
    let all = columns.iter().flat_map(|c| &c.amplitude[..bins]);
    let strongest = all.fold(0.0_f64, |most, &a| most.max(a));
    let height = bins.min(ROWS);
    let pixels = (0..height).rev().flat_map(|row| {
        let first = row * bins / height;
        let bins = first..((row + 1) * bins / height).max(first + 1);
        columns.iter().map(move |column| {
            let most = column.amplitude[bins.clone()].iter().copied();
            let most = most.fold(0.0, f64::max);
            colormap_index(1.0 + 20.0 * (most / strongest).log10() / SPECTROGRAM_DB)
        })
    });
    Image {
        x,
        y,
        size: [columns.len(), height],
        pixels: pixels.collect(),
        palette: plain_palette(colormap()),
    }
}

/// The base frequencies as text.
fn bases(bases: &Bases) -> String {
    let hertz = |f: f64| match f {
        f if f >= 1000.0 => format!("{:.4} kHz", 1e-3 * f),
        f => format!("{f:.3} Hz"),
    };
    match bases {
        Bases::None => "no simple pattern of spectral lines".to_owned(),
        Bases::One { f1 } => format!("f1 = {}", hertz(*f1)),
        Bases::Modulated { f1, fm } => {
            format!("f1 = {}, modulated at fm = {}", hertz(*f1), hertz(*fm))
        }
        Bases::Two { f1, f2 } => format!("f1 = {}, f2 = {}", hertz(*f1), hertz(*f2)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_is_light() {
        let image = |amplitude: Vec<f64>| {
            let column = Column {
                centre: 0.0,
                bin: 1.0,
                amplitude,
            };
            image(&[column], 2, [0.0, 1.0], [0.0, 1.0]).pixels
        };
        assert_eq!(image(vec![0.0, 0.0]), [0, 0]);
        assert_eq!(image(vec![0.0, 1e-20]), [255, 0]);
    }
}
