//! The spectrogram of the probe's velocity over the whole run.

use crate::record::sdk::{Image, LineStrips2D, Points2D, Radius, Transform3D};

use super::paths;
use super::plot::Plot;
use super::stream::{Moment, RecordingStream, STATIC};
use super::style::{shade, short};
use crate::analysis::levels::LevelReference;
use crate::pipeline::message::{Header, SignalInfo, Subject};
use crate::plot::{
    Axis, Color, INFERNO, Layer, Panel, Rgb, Unit, colormap, full_scale, gradient, shown, units,
};

/// Levels at the ends of the colour map, dB: of a simulation relative to 1 mm/s, of a signal from a file
/// relative to its full scale.
const JOINT_LEVELS: [f32; 2] = [-70.0, 25.0];
const SIGNAL_LEVELS: [f32; 2] = [-95.0, 0.0];
/// Pixels of the spectrogram along time, in total and per tile.
const WIDTH: usize = 640;
const TILE: usize = 16;
/// Pixels along frequency.
const HEIGHT: usize = 190;
/// Draw order of the first tile, and the step to the next one. The viewer draws images with the same order at the same
/// depth, where their edges compete; all tiles are below the axes and the marks.
const TILE_ORDERS: [f32; 2] = [-10.0, 0.01];
/// Number of new pixels after which the current tile is logged again.
const REFRESH: usize = 4;

/// The spectrogram of the whole run in a plot of fixed size.
///
/// Rerun cannot update a part of an image. The image is therefore divided into tiles along time, each a separate entity, so
/// that only the current tile is logged again. A pixel shows the highest level of its columns; if there are fewer columns
/// than pixels, a column extends to the next one.
#[derive(Debug)]
pub struct Spectrogram {
    /// Plot area, with times in s and frequencies in Hz.
    plot: Plot,
    /// Levels at the ends of the colour map, dB, and in words.
    range_db: [f32; 2],
    scale: String,
    /// Whether the run has no planned end, so that another image follows.
    endless: bool,
    map: [Rgb; 256],
    /// Levels, dB, `WIDTH x HEIGHT`, column by column.
    levels: Vec<f32>,
    /// Index of the first pixel that is not logged, and of the first that has no data, along the whole image.
    logged: usize,
    filled: usize,
    /// Time of the latest column, s.
    time: f64,
}

impl Spectrogram {
    /// Draws the axes and places the tiles.
    pub fn new(rec: &RecordingStream, header: &Header) -> Self {
        let (plot, range_db, scale) = spectrogram_plot(header);
        // Static data would override data that are logged later.
        let start = Moment::from(header.start());
        let from = if header.endless { start } else { STATIC };
        plot.draw(rec, paths::SPECTROGRAM, from);
        for tile in 0..WIDTH / TILE {
            let at = Transform3D::from_translation([(tile * TILE) as f32, 0.0, 0.0]);
            rec.log_static(paths::spectrogram_tile(tile), &at);
            let [first, step] = TILE_ORDERS;
            let order = Image::update_fields().with_draw_order(first + step * tile as f32);
            rec.log_static(paths::spectrogram_tile(tile), &order);
        }
        if let Subject::Signal(signal) = &header.subject {
            draw_events(rec, &plot, signal);
        }
        Self {
            plot,
            range_db,
            scale,
            endless: header.endless,
            map: gradient(&INFERNO),
            levels: vec![f32::NEG_INFINITY; WIDTH * HEIGHT],
            logged: 0,
            filled: 0,
            time: 0.0,
        }
    }

    /// Adds a column: centre of its window (s), bins `bin` (Hz) apart from 0 Hz, levels in dB relative to 1
    /// mm/s.
    pub fn push(&mut self, rec: &RecordingStream, time: f64, bin: f64, level_db: &[f32]) {
        let column = self.resample(bin, level_db);
        if self.endless && time >= self.plot.x.range[1] {
            self.turn_over(rec, time);
        }
        let pixel = ((self.plot.x.fraction(time) * WIDTH as f64) as usize).min(WIDTH - 1);
        self.time = time;
        if pixel < self.filled {
            self.merge(self.filled - 1, &column);
            return;
        }
        // There are no data before the first column.
        let first = if self.filled == 0 { pixel } else { self.filled };
        for pixel in first..=pixel {
            if pixel / TILE > self.filled.saturating_sub(1) / TILE {
                self.log(rec);
            }
            self.filled = pixel + 1;
            self.merge(pixel, &column);
        }
        if self.filled - self.logged >= REFRESH {
            self.log(rec);
        }
    }

    /// Logs pixels that are not logged yet.
    pub fn finish(&mut self, rec: &RecordingStream) {
        self.log(rec);
        if self.filled > 0 {
            rec.keep(paths::SPECTROGRAM, || self.panel());
        }
    }

    /// The spectrogram as a panel: dark is strong.
    fn panel(&self) -> Panel {
        let [low, high] = self.range_db;
        let cell = |row: usize, column: usize| {
            let level = self.levels[column * HEIGHT + row];
            let index = 127.0 * ((level - low) / (high - low)).clamp(0.0, 1.0);
            // There are no levels before the first column and after the last.
            level.is_finite().then_some(index as u8)
        };
        let cells = (0..HEIGHT).rev();
        let cells = cells.flat_map(|row| (0..WIDTH).map(move |column| cell(row, column)));
        let colors = colormap().into_iter().step_by(2);
        let (cells, colors): (Vec<_>, Vec<_>) = (cells.collect(), colors.collect());
        let x = self.plot.x.clone();
        let y = Axis::linear("frequency", self.plot.y.range).of("Hz");
        let image = Layer::cells([&x, &y], WIDTH, &cells, &colors);
        Panel::new(format!("dark is strong {}", self.scale), x, y, vec![image])
    }

    /// Starts an empty image of the same duration that contains a time (s).
    fn turn_over(&mut self, rec: &RecordingStream, time: f64) {
        self.log(rec);
        let [start, end] = self.plot.x.range;
        let duration = end - start;
        let start = start + duration * self.plot.x.fraction(time).floor();
        self.plot.x = time_axis(start, duration);
        self.plot.draw(rec, paths::SPECTROGRAM, start.into());
        self.levels.fill(f32::NEG_INFINITY);
        (self.logged, self.filled, self.time) = (0, 0, start);
        for tile in 0..WIDTH / TILE {
            self.log_tile(rec, tile);
        }
    }

    fn merge(&mut self, pixel: usize, column: &[f32]) {
        let start = pixel * HEIGHT;
        for (level, new) in self.levels[start..][..HEIGHT].iter_mut().zip(column) {
            *level = level.max(*new);
        }
    }

    /// Levels at the frequencies of the pixels, highest first, linearly interpolated between bins.
    fn resample(&self, bin: f64, level_db: &[f32]) -> Vec<f32> {
        let [_, highest] = self.plot.y.range;
        let levels = (0..HEIGHT).map(|row| {
            let frequency = highest * (1.0 - (row as f64 + 0.5) / HEIGHT as f64);
            let at = frequency / bin;
            let k = at as usize;
            let part = (at - k as f64) as f32;
            match level_db.get(k..k + 2) {
                Some(&[low, high]) => low + (high - low) * part,
                _ => f32::NEG_INFINITY,
            }
        });
        levels.collect()
    }

    fn log(&mut self, rec: &RecordingStream) {
        if self.filled == self.logged {
            return;
        }
        self.log_tile(rec, (self.filled - 1) / TILE);
        self.logged = self.filled;
    }

    fn log_tile(&self, rec: &RecordingStream, tile: usize) {
        let [low, high] = self.range_db;
        let mut pixels = Vec::with_capacity(3 * TILE * HEIGHT);
        for row in 0..HEIGHT {
            for column in 0..TILE {
                let level = self.levels[(tile * TILE + column) * HEIGHT + row];
                pixels.extend(shade(&self.map, (level - low) / (high - low)));
            }
        }
        let image = Image::from_rgb24(pixels, [TILE as u32, HEIGHT as u32]);
        rec.log(paths::spectrogram_tile(tile), self.time, &image);
    }
}

/// Draws the ridges of tonal events over the spectrogram, with their numbers and levels.
fn draw_events(rec: &RecordingStream, plot: &Plot, signal: &SignalInfo) {
    let ridges = signal.events.iter().map(|event| {
        let points = event.ridge.iter();
        let points = points.map(|p| plot.at(p.time_s, p.frequency_hz));
        points.collect::<Vec<_>>()
    });
    let ridges = LineStrips2D::new(ridges)
        .with_colors([Color::Compared])
        .with_radii([Radius::new_ui_points(0.8)]);
    rec.log_static("spectrogram/events/ridges", &ridges);
    let events = signal.events.iter();
    let starts = events.map(|event| plot.at(event.start_s, event.frequency_at(event.start_s)));
    let numbers = (1..).zip(&signal.events).map(|(number, event)| {
        let level = format!("{:.1} {}", event.level_db, signal.level_reference);
        shown(&format!("{number}: {level}"))
    });
    let numbers = Points2D::new(starts)
        .with_labels(numbers)
        .with_show_labels(true)
        .with_colors([Color::Compared])
        .with_radii([Radius::new_ui_points(2.5)]);
    rec.log_static("spectrogram/events/numbers", &numbers);
}

fn time_axis(start: f64, duration: f64) -> Axis {
    Axis::linear("time", [start, start + duration]).written_in(Unit::of("s", duration))
}

/// The plot of the spectrogram, frequency over time, the levels at the ends of the colour map, dB, and these in words.
fn spectrogram_plot(header: &Header) -> (Plot, [f32; 2], String) {
    let highest = header.highest_frequency();
    let hz = Unit::of("Hz", highest);
    let ([low, high], zero, offset) = match &header.subject {
        Subject::Joint(_) | Subject::Small(_) => (JOINT_LEVELS, "1 mm/s".to_owned(), 0.0),
        Subject::Signal(signal) => {
            let full = full_scale(signal);
            let db = |ratio: f64| (20.0 * ratio.log10()) as f32;
            let (zero, words) = match signal.level_reference {
                reference @ LevelReference::SoundPressure => {
                    (reference.amplitude(full), "20 uPa RMS".to_owned())
                }
                _ => (full, Unit::write(full, units(&header.subject)[1])),
            };
            let levels = SIGNAL_LEVELS.map(|level| level + db(full / zero).ceil());
            // Levels of records are relative to 1e-3 of the unit.
            (levels, words, db(1e3 * zero))
        }
    };
    let [from, to] = [low, high].map(|level| short(level.into()));
    let scale = format!("(colour scale {from} dB to {to} dB, 0 dB = {zero})");
    let plot = Plot {
        width: WIDTH as f32,
        height: HEIGHT as f32,
        top_margin: 0.0,
        x: time_axis(header.start(), header.duration),
        y: Axis::linear("frequency", [0.0, highest]).written_in(Unit {
            symbol: format!("{}   {scale}", hz.symbol),
            ..hz
        }),
        grid: false,
        legend: Vec::new(),
    };
    (plot, [low + offset, high + offset], scale)
}
