//! Spectrum of the probe's velocity, and its spectrogram over the whole run.

use rerun::{Image, LineStrips2D, Points2D, Radius, RecordingStream, Transform3D};

use super::{
    error::RecordError,
    paths,
    plot::{Axis, Plot},
    stream,
    style::{self, ColorMap, short},
};
use crate::pipeline::message::{Header, Peak};

/// Peaks that get a label; more would cover one another.
const LABELLED: usize = 6;
/// Lines that the names of peaks take turns on, and the height of one, pixels.
const NAME_LINES: usize = 3;
const NAME_HEIGHT: f32 = 20.0;
/// Levels at the two ends of the colour map, dB relative to 1 mm/s.
const LEVELS: [f32; 2] = [-50.0, 25.0];
/// Pixels of the spectrogram along time, in all and a tile.
const WIDTH: usize = 640;
const TILE: usize = 16;
/// Pixels along frequency.
const HEIGHT: usize = 190;
/// New pixels after which the present tile is logged again.
const REFRESH: usize = 4;

/// Highest frequency on show, Hz: a fifth above the highest mode, to whole 5 kHz.
fn highest_frequency(header: &Header) -> f64 {
    let modes = header.modes.iter().map(|mode| mode.frequency_hz);
    (1.2 * modes.fold(0.0, f64::max) / 5e3).ceil().max(1.0) * 5e3
}

/// The plot of the spectrum: 0.001 to 100 mm/s over frequency in kHz.
pub fn spectrum_plot(header: &Header) -> Plot {
    Plot {
        width: 400.0,
        height: 190.0,
        x: Axis::linear("frequency, kHz", 0.0, 1e-3 * highest_frequency(header), 6),
        y: Axis::decades("amplitude of the velocity, mm/s", -3, 2),
        grid: true,
    }
}

/// Draws a spectrum: bins `bin` (Hz) apart from 0 Hz, amplitudes in m/s.
pub fn draw_spectrum(
    rec: &RecordingStream,
    plot: &Plot,
    time: f64,
    bin: f64,
    amplitude: &[f64],
    peaks: &[Peak],
) -> Result<(), RecordError> {
    let shown = amplitude
        .iter()
        .enumerate()
        .map(|(k, a)| (1e-3 * bin * k as f64, 1e3 * a))
        .take_while(|(frequency, _)| *frequency <= plot.x.high);
    let curve = shown.map(|(frequency, a)| plot.at(frequency, a));
    let curve = LineStrips2D::new([curve.collect::<Vec<_>>()])
        .with_colors([style::SIGNAL])
        .with_radii([Radius::new_ui_points(0.9)]);
    stream::log_at(rec, paths::SPECTRUM_CURVE, time, &curve)?;

    let shown = peaks
        .iter()
        .filter(|peak| 1e-3 * peak.frequency <= plot.x.high);
    let mut peaks: Vec<_> = shown.take(LABELLED).collect();
    peaks.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    let positions = peaks
        .iter()
        .map(|peak| plot.at(1e-3 * peak.frequency, 1e3 * peak.amplitude));
    let marks = Points2D::new(positions)
        .with_colors([style::ACCENT])
        .with_radii([Radius::new_ui_points(2.5)]);
    stream::log_at(rec, paths::SPECTRUM_PEAKS, time, &marks)?;

    // Neighbours get their names on different lines, so that these do not cover one another.
    let anchor = |k: usize, peak: &Peak| {
        let [x, _] = plot.at(1e-3 * peak.frequency, 1.0);
        [x, (k % NAME_LINES) as f32 * NAME_HEIGHT]
    };
    let anchors = || peaks.iter().enumerate().map(|(k, peak)| anchor(k, peak));
    let names = Points2D::new(anchors())
        .with_labels(peaks.iter().map(|peak| peak_label(peak)))
        .with_show_labels(true)
        .with_colors(vec![style::ACCENT; peaks.len()])
        .with_radii([Radius::new_ui_points(0.0)]);
    stream::log_at(rec, paths::SPECTRUM_NAMES, time, &names)?;
    let stems = anchors().zip(&peaks).map(|([x, y], peak)| {
        let [_, tip] = plot.at(1e-3 * peak.frequency, 1e3 * peak.amplitude);
        [[x, y + NAME_HEIGHT], [x, tip]]
    });
    let stems = LineStrips2D::new(stems)
        .with_colors([style::faded(style::ACCENT, 0.5)])
        .with_radii([Radius::new_ui_points(0.5)]);
    stream::log_at(rec, paths::SPECTRUM_STEMS, time, &stems)
}

/// Frequency, and what it is where that is known.
fn peak_label(peak: &Peak) -> String {
    let frequency = format!("{:.2} kHz", 1e-3 * peak.frequency);
    if peak.label.is_empty() {
        frequency
    } else {
        format!("{} = {frequency}", peak.label)
    }
}

/// The spectrogram of the whole run, on a picture of fixed size.
///
/// The picture is cut into tiles along time, each its own entity, so that only the tile that
/// grows is logged again. A pixel shows the highest level of the columns that fall into it; where
/// columns are rarer than pixels, each holds until the next.
#[derive(Debug)]
pub struct Spectrogram {
    duration: f64,
    plot: Plot,
    map: ColorMap,
    /// Levels of the present tile, dB, `TILE x HEIGHT`, one column of pixels after the other.
    levels: Vec<f32>,
    /// First pixel of the present tile not yet logged, and the first not yet filled, both
    /// counted over the whole picture.
    logged: usize,
    filled: usize,
    /// Time of the newest column, s.
    time: f64,
}

impl Spectrogram {
    /// Draws axes and places the tiles.
    pub fn new(rec: &RecordingStream, header: &Header) -> Result<Self, RecordError> {
        let plot = spectrogram_plot(header);
        plot.draw(rec, paths::SPECTROGRAM_AXES, None)?;
        for tile in 0..WIDTH / TILE {
            let at = Transform3D::from_translation([(tile * TILE) as f32, 0.0, 0.0]);
            rec.log_static(paths::spectrogram_tile(tile), &at)?;
        }
        Ok(Self {
            duration: header.duration,
            plot,
            map: ColorMap::inferno(),
            levels: vec![f32::NEG_INFINITY; TILE * HEIGHT],
            logged: 0,
            filled: 0,
            time: 0.0,
        })
    }

    /// Takes a column: centre of its window (s), bins `bin` (Hz) apart from 0 Hz, levels in dB
    /// relative to 1 mm/s.
    pub fn push(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        bin: f64,
        level_db: &[f32],
    ) -> Result<(), RecordError> {
        let column = self.resample(bin, level_db);
        let pixel = ((time / self.duration * WIDTH as f64) as usize).min(WIDTH - 1);
        self.time = time;
        if pixel < self.filled {
            self.merge(self.filled - 1, &column);
            return Ok(());
        }
        // Nothing is known before the first column.
        let first = if self.filled == 0 { pixel } else { self.filled };
        for pixel in first..=pixel {
            if pixel / TILE > self.filled.saturating_sub(1) / TILE {
                self.log(rec)?;
                self.levels.fill(f32::NEG_INFINITY);
            }
            self.filled = pixel + 1;
            self.merge(pixel, &column);
        }
        if self.filled - self.logged >= REFRESH {
            self.log(rec)?;
        }
        Ok(())
    }

    /// Logs what is not yet logged.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.log(rec)
    }

    fn merge(&mut self, pixel: usize, column: &[f32]) {
        let start = pixel % TILE * HEIGHT;
        for (level, new) in self.levels[start..][..HEIGHT].iter_mut().zip(column) {
            *level = level.max(*new);
        }
    }

    /// Levels at the pixels' frequencies, highest first, linear between bins.
    fn resample(&self, bin: f64, level_db: &[f32]) -> Vec<f32> {
        let highest = 1e3 * self.plot.y.high;
        (0..HEIGHT)
            .map(|row| {
                let frequency = highest * (1.0 - (row as f64 + 0.5) / HEIGHT as f64);
                let at = frequency / bin;
                let k = at as usize;
                let part = (at - k as f64) as f32;
                match level_db.get(k..k + 2) {
                    Some(&[low, high]) => low + (high - low) * part,
                    _ => f32::NEG_INFINITY,
                }
            })
            .collect()
    }

    fn log(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        if self.filled == self.logged {
            return Ok(());
        }
        let tile = (self.filled - 1) / TILE;
        let mut pixels = Vec::with_capacity(3 * TILE * HEIGHT);
        for row in 0..HEIGHT {
            for column in 0..TILE {
                let level = self.levels[column * HEIGHT + row];
                let share = (level - LEVELS[0]) / (LEVELS[1] - LEVELS[0]);
                pixels.extend(self.map.at(share));
            }
        }
        let image = Image::from_rgb24(pixels, [TILE as u32, HEIGHT as u32]);
        stream::log_at(rec, paths::spectrogram_tile(tile), self.time, &image)?;
        self.logged = self.filled;
        Ok(())
    }
}

/// The plot of the spectrogram: frequency in kHz over time in ms.
pub fn spectrogram_plot(header: &Header) -> Plot {
    Plot {
        width: WIDTH as f32,
        height: HEIGHT as f32,
        x: Axis::linear("time, ms", 0.0, 1e3 * header.duration, 8),
        y: Axis::linear(
            format!(
                "frequency, kHz   (dark {} dB to bright {} dB, 0 dB = 1 mm/s)",
                short(LEVELS[0].into()),
                short(LEVELS[1].into()),
            ),
            0.0,
            1e-3 * highest_frequency(header),
            4,
        ),
        grid: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_are_named() {
        let mut peak = Peak {
            frequency: 4117.0,
            amplitude: 1e-3,
            label: "f1".to_owned(),
        };
        assert_eq!(peak_label(&peak), "f1 = 4.12 kHz");
        peak.label.clear();
        assert_eq!(peak_label(&peak), "4.12 kHz");
    }
}
