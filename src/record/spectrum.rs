//! Spectrum of the probe's velocity, and its spectrogram over the whole run.

use rerun::{Image, LineStrips2D, Points2D, Radius, Transform3D};

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths,
    plot::Plot,
    stream::{self, Moment, RecordingStream},
    style::{self, ColorMap, Quantity, Unit, short},
};
use crate::{
    analysis::LevelReference,
    pipeline::message::{Header, SignalInfo, SpectralLine, Subject},
    plot::{Axis, Color, Layer, Panel},
};

/// Size of the plot area of the spectrum, pixels.
const SPECTRUM: [f32; 2] = [400.0, 150.0];
/// Maximum number of labelled peaks; more labels would overlap.
const LABELLED: usize = 6;
/// Levels at the ends of the colour map, dB: of a simulation relative to 1 mm/s, of a signal from a file
/// relative to its full scale.
const JOINT_LEVELS: [f32; 2] = [-70.0, 25.0];
const SIGNAL_LEVELS: [f32; 2] = [-95.0, 0.0];
/// Pixels of the spectrogram along time, in total and per tile.
const WIDTH: usize = 640;
const TILE: usize = 16;
/// Pixels along frequency.
const HEIGHT: usize = 190;
/// Number of new pixels after which the current tile is logged again.
const REFRESH: usize = 4;

/// Half the range of the samples; positive.
fn full_scale(signal: &SignalInfo) -> f64 {
    let [low, high] = signal.span;
    (0.5 * (high - low)).max(style::smallest_shown(signal.span))
}

/// The plot of the spectrum and its units.
#[derive(Debug)]
pub struct SpectrumPlot {
    view: PanelView,
    axes: [Axis; 2],
    /// Unit of the frequencies.
    pub frequency: Unit,
    amplitude: Unit,
}

impl SpectrumPlot {
    /// Amplitudes of 0.0001 to 100 mm/s over frequency; for a signal from a file, seven decades below its full
    /// scale.
    pub fn new(header: &Header) -> Self {
        let amplitude = Quantity::velocity(&header.subject).unit(1.0);
        let (name, decades) = match &header.subject {
            Subject::Joint(_) | Subject::Small(_) => ("velocity amplitude", [-4, 2]),
            Subject::Signal(signal) => {
                let top = full_scale(signal).log10().ceil() as i32;
                ("amplitude", [top - 7, top])
            }
        };
        let highest = header.highest_frequency();
        let frequency = Quantity::Frequency.unit(highest);
        let x = style::with_unit("frequency", &frequency.symbol);
        let y = style::with_unit(name, &amplitude.symbol);
        Self {
            view: PanelView::new(paths::SPECTRUM, SPECTRUM),
            axes: [
                Axis::linear(x, [0.0, frequency.per_si * highest]),
                Axis::decades(y, decades),
            ],
            frequency,
            amplitude,
        }
    }

    /// The plot area and its axes.
    pub fn plot(&self) -> Plot {
        self.view.plot(&self.panel(1.0, &[], &[]))
    }

    /// A spectrum with bins `bin` (Hz) apart and its labelled lines, strongest first.
    fn panel(&self, bin: f64, amplitude: &[f64], peaks: &[SpectralLine]) -> Panel {
        let [x, y] = self.axes.clone();
        let end = x.range[1];
        let at = |hz: f64, a: f64| [self.frequency.per_si * hz, self.amplitude.per_si * a];
        let curve = amplitude.iter().enumerate();
        let curve = curve.map(|(k, a)| at(bin * k as f64, *a));
        let curve = curve.take_while(|point| point[0] <= end).collect();
        let peaks = peaks.iter().map(|peak| {
            let name = peak_label(peak, &self.frequency);
            (at(peak.frequency, peak.amplitude), name)
        });
        let peaks = peaks.filter(|(at, _)| at[0] <= end).take(LABELLED);
        let layers = vec![
            Layer::line(curve, Color::Ink),
            Layer::peaks(peaks.collect()),
        ];
        Panel::new("spectrum", x, y, layers)
    }

    /// Draws a spectrum.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        bin: f64,
        amplitude: &[f64],
        peaks: &[SpectralLine],
    ) -> Result<(), RecordError> {
        let panel = self.panel(bin, amplitude, peaks);
        let plot = self.view.plot(&panel);
        let at = Some(Moment::from(time));
        self.view.draw_layers(rec, at, &plot, &panel.layers)
    }
}

/// Label and frequency of a peak; only the frequency if it has no label.
fn peak_label(peak: &SpectralLine, unit: &Unit) -> String {
    let frequency = unit.per_si * peak.frequency;
    if peak.label.is_empty() {
        format!("{frequency:.2}")
    } else {
        format!("{}: {frequency:.2}", peak.label)
    }
}

/// The spectrogram of the whole run in a plot of fixed size.
///
/// The image is divided into tiles along time, each a separate entity, so that only the current tile is
/// logged again. A pixel shows the highest level of its columns; if there are fewer columns than pixels, a
/// column extends to the next one.
#[derive(Debug)]
pub struct Spectrogram {
    picture: SpectrogramPlot,
    map: ColorMap,
    /// Levels of the current tile, dB, `TILE x HEIGHT`, column by column.
    levels: Vec<f32>,
    /// Index of the first pixel that is not logged, and of the first that has no data, along the whole image.
    logged: usize,
    filled: usize,
    /// Time of the latest column, s.
    time: f64,
}

impl Spectrogram {
    /// Draws the axes and places the tiles.
    pub fn new(rec: &RecordingStream, header: &Header) -> Result<Self, RecordError> {
        let picture = spectrogram_plot(header);
        // Static data would override data that are logged later.
        let from = picture.endless.then(|| Moment::from(picture.start));
        picture.plot.draw(rec, paths::SPECTROGRAM, from)?;
        for tile in 0..WIDTH / TILE {
            let at = Transform3D::from_translation([(tile * TILE) as f32, 0.0, 0.0]);
            rec.log_static(paths::spectrogram_tile(tile), &at)?;
        }
        if let Subject::Signal(signal) = &header.subject {
            draw_events(rec, &picture.plot, header, signal)?;
        }
        Ok(Self {
            picture,
            map: ColorMap::inferno(),
            levels: vec![f32::NEG_INFINITY; TILE * HEIGHT],
            logged: 0,
            filled: 0,
            time: 0.0,
        })
    }

    /// Adds a column: centre of its window (s), bins `bin` (Hz) apart from 0 Hz, levels in dB relative to 1
    /// mm/s.
    pub fn push(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        bin: f64,
        level_db: &[f32],
    ) -> Result<(), RecordError> {
        let column = self.resample(bin, level_db);
        if self.picture.endless && time >= self.picture.start + self.picture.duration {
            self.turn_over(rec, time)?;
        }
        let SpectrogramPlot {
            start, duration, ..
        } = self.picture;
        let share = (time - start) / duration;
        let pixel = ((share * WIDTH as f64) as usize).min(WIDTH - 1);
        self.time = time;
        if pixel < self.filled {
            self.merge(self.filled - 1, &column);
            return Ok(());
        }
        // There are no data before the first column.
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

    /// Logs pixels that are not logged yet.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.log(rec)
    }

    /// Starts an empty image of the same duration that contains a time (s).
    fn turn_over(&mut self, rec: &RecordingStream, time: f64) -> Result<(), RecordError> {
        self.log(rec)?;
        let SpectrogramPlot {
            start, duration, ..
        } = self.picture;
        let start = start + duration * ((time - start) / duration).floor();
        self.picture.begin_at(start);
        let axes = Some(Moment::from(start));
        self.picture.plot.draw(rec, paths::SPECTROGRAM, axes)?;
        self.levels.fill(f32::NEG_INFINITY);
        (self.logged, self.filled, self.time) = (0, 0, start);
        for tile in 0..WIDTH / TILE {
            self.log_tile(rec, tile)?;
        }
        Ok(())
    }

    fn merge(&mut self, pixel: usize, column: &[f32]) {
        let start = pixel % TILE * HEIGHT;
        for (level, new) in self.levels[start..][..HEIGHT].iter_mut().zip(column) {
            *level = level.max(*new);
        }
    }

    /// Levels at the frequencies of the pixels, highest first, linearly interpolated between bins.
    fn resample(&self, bin: f64, level_db: &[f32]) -> Vec<f32> {
        let highest = self.picture.highest;
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
        self.log_tile(rec, (self.filled - 1) / TILE)?;
        self.logged = self.filled;
        Ok(())
    }

    fn log_tile(&self, rec: &RecordingStream, tile: usize) -> Result<(), RecordError> {
        let [low, high] = self.picture.levels;
        let mut pixels = Vec::with_capacity(3 * TILE * HEIGHT);
        for row in 0..HEIGHT {
            for column in 0..TILE {
                let level = self.levels[column * HEIGHT + row];
                pixels.extend(self.map.at((level - low) / (high - low)));
            }
        }
        let image = Image::from_rgb24(pixels, [TILE as u32, HEIGHT as u32]);
        stream::log_at(rec, paths::spectrogram_tile(tile), self.time, &image)
    }
}

/// Draws the ridges of tonal events over the spectrogram, with their numbers and levels.
fn draw_events(
    rec: &RecordingStream,
    plot: &Plot,
    header: &Header,
    signal: &SignalInfo,
) -> Result<(), RecordError> {
    let time = Quantity::Time.unit(header.duration).per_si;
    let frequency = Quantity::Frequency.unit(header.highest_frequency()).per_si;
    let ridges = signal.events.iter().map(|event| {
        let points = event.ridge.iter();
        let points = points.map(|p| plot.at(time * p.time_s, frequency * p.frequency_hz));
        points.collect::<Vec<_>>()
    });
    let ridges = LineStrips2D::new(ridges)
        .with_colors([style::ACCENT])
        .with_radii([Radius::new_ui_points(0.8)]);
    rec.log_static(paths::SPECTROGRAM_RIDGES, &ridges)?;
    let starts = signal.events.iter().map(|event| {
        let start = event.frequency_at(event.start_s);
        plot.at(time * event.start_s, frequency * start)
    });
    let numbers = (1..).zip(&signal.events).map(|(number, event)| {
        format!("{number}: {:.1} {}", event.level_db, signal.level_reference)
    });
    let numbers = Points2D::new(starts)
        .with_labels(numbers)
        .with_show_labels(true)
        .with_colors([style::ACCENT])
        .with_radii([Radius::new_ui_points(2.5)]);
    rec.log_static(paths::SPECTROGRAM_NUMBERS, &numbers)
}

/// The plot of a spectrogram and its scales.
#[derive(Clone, Debug)]
pub struct SpectrogramPlot {
    /// Plot area and axes.
    pub plot: Plot,
    /// Time at the left end, and duration, s.
    start: f64,
    duration: f64,
    /// Whether the run has no planned end, so that another image follows.
    endless: bool,
    /// Frequency at the upper end, Hz.
    highest: f64,
    /// Levels at the ends of the colour map, dB.
    levels: [f32; 2],
}

impl SpectrogramPlot {
    /// Moves the left end to a time, s.
    fn begin_at(&mut self, start: f64) {
        self.start = start;
        self.plot.x = time_axis(start, self.duration);
    }
}

fn time_axis(start: f64, duration: f64) -> Axis {
    let time = Quantity::Time.unit(duration);
    Axis::linear(
        style::with_unit("time", &time.symbol),
        [start, start + duration].map(|end| time.per_si * end),
    )
}

/// The plot of the spectrogram: frequency over time.
pub fn spectrogram_plot(header: &Header) -> SpectrogramPlot {
    let (start, duration) = (header.start(), header.duration);
    let highest = header.highest_frequency();
    let hz = Quantity::Frequency.unit(highest);
    let ([low, high], zero, offset) = match &header.subject {
        Subject::Joint(_) | Subject::Small(_) => (JOINT_LEVELS, "1 mm/s".to_owned(), 0.0),
        Subject::Signal(signal) => {
            let full = full_scale(signal);
            let db = |ratio: f64| (20.0 * ratio.log10()) as f32;
            let (zero, words) = match signal.level_reference {
                reference @ LevelReference::SoundPressure => {
                    (reference.amplitude(full), "20 uPa RMS".to_owned())
                }
                _ => (full, Quantity::velocity(&header.subject).format(full)),
            };
            let levels = SIGNAL_LEVELS.map(|level| level + db(full / zero).ceil());
            // Levels of records are relative to 1e-3 of the unit.
            (levels, words, db(1e3 * zero))
        }
    };
    let plot = Plot {
        width: WIDTH as f32,
        height: HEIGHT as f32,
        top_margin: 0.0,
        x: time_axis(start, duration),
        y: Axis::linear(
            format!(
                "frequency, {}   (colour scale {} dB to {} dB, 0 dB = {zero})",
                hz.symbol,
                short(low.into()),
                short(high.into()),
            ),
            [0.0, hz.per_si * highest],
        ),
        grid: false,
    };
    SpectrogramPlot {
        plot,
        start,
        duration,
        endless: header.endless,
        highest,
        levels: [low + offset, high + offset],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_are_labelled() {
        let mut peak = SpectralLine {
            frequency: 4117.0,
            amplitude: 1e-3,
            label: "f1".to_owned(),
        };
        let kilohertz = Quantity::Frequency.unit(15e3);
        assert_eq!(peak_label(&peak, &kilohertz), "f1: 4.12");
        peak.label.clear();
        assert_eq!(peak_label(&peak, &kilohertz), "4.12");
    }
}
