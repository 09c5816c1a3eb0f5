//! The attractor: phase portrait (u, v) and delay embedding, each a trail that fades with age.

use std::collections::VecDeque;

use crate::record::sdk::{LineStrips2D, LineStrips3D, Points2D, Points3D, Radius};

use super::panel_view::PanelView;
use super::paths::{self, Root};
use super::plot::Plot;
use super::stream::{Moment, RecordingStream, nanos};
use super::style::{self, short};
use crate::pipeline::message::{Frame, Subject};
use crate::plot::response::{SMALLEST, interpolated, phase_portrait};
use crate::plot::{Color, FullScale, RedrawTimer, Unit, letter, range_shown, shown, units};

/// Length of a joint's trail, s: 80 periods of a 4 kHz squeak, and about five of the beat of two tones 0.25
/// kHz apart, so that the trail covers a torus before it fades.
pub const TRAIL: f64 = 20e-3;
/// Interval of the logged current points, samples.
const POINT_EVERY: usize = 10;
/// Number of pieces of the trail of the phase portrait, each with an age.
const FADES: usize = 20;
/// Number of pieces of the delay trail, each with one colour.
const PIECES: usize = 8;

/// The phase portrait of the probe.
#[derive(Debug)]
pub struct Portrait {
    /// Length of the trail, s.
    length: f64,
    /// Colours of the trail by status; the first one if there is no status.
    colors: Vec<Color>,
    /// Displacement (m), velocity (m/s) and status of the last samples, oldest first.
    trail: VecDeque<([f64; 2], u8)>,
    scales: [FullScale; 2],
    view: PanelView,
    redraw: RedrawTimer,
    /// Spacing of the samples, s.
    dt: f64,
}

impl Portrait {
    /// Draws the style of the current point and starts empty; the axes are drawn with the first frame. The trail is `length`
    /// (s) long and coloured by the status of the samples.
    pub fn new(rec: &RecordingStream, length: f64, colors: Vec<Color>) -> Self {
        let style = Points2D::update_fields()
            .with_colors([Color::Compared])
            .with_radii([Radius::new_ui_points(4.0)])
            .with_draw_order(1.0);
        rec.log_static(paths::PORTRAIT_NOW, &style);
        Self {
            length,
            colors,
            trail: VecDeque::new(),
            scales: SMALLEST.map(FullScale::new),
            view: PanelView::of("portrait", &Root::of_run()),
            redraw: RedrawTimer::default(),
            dt: 0.0,
        }
    }

    /// Adds a frame; the trail is redrawn once per frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) {
        if frame.is_empty() {
            return;
        }
        self.dt = frame.dt;
        let status = frame.status.iter().copied().chain(std::iter::repeat(0));
        let samples = frame.displacement.iter().zip(&frame.velocity).zip(status);
        let samples = samples.map(|((&u, &v), status)| ([u, v], status));
        self.trail.extend(samples);
        let wanted = (self.length / frame.dt).ceil() as usize;
        let piece = wanted.div_ceil(FADES);
        // Whole pieces, so that a point stays in its piece: pieces that shift compress badly.
        let surplus = self.trail.len().saturating_sub(wanted) / piece * piece;
        self.trail.drain(..surplus);
        if !self.redraw.is_due(frame.end(), frame.shown) {
            return;
        }
        for (c, scale) in self.scales.iter_mut().enumerate() {
            let sizes = self.trail.iter().map(|(point, _)| point[c].abs());
            scale.update(sizes.fold(0.0, f64::max), SMALLEST[c]);
        }
        let reach = self.scales.map(FullScale::get);
        let panel = phase_portrait(&[], Some(reach), Color::Run);
        let plot = self.view.draw_axes(rec, frame.t0.into(), &panel);
        self.draw_trail(rec, &plot, frame.t0, piece);
        draw_point(rec, &plot, frame);
    }

    /// Keeps the trail for figures.
    pub fn finish(&self, rec: &RecordingStream) {
        let samples = self.trail.iter().map(|(point, _)| *point);
        rec.keep("phase_portrait", || {
            let motion = interpolated(&Vec::from_iter(samples), self.dt);
            phase_portrait(&motion, None, Color::Run).square()
        });
    }

    fn draw_trail(&mut self, rec: &RecordingStream, plot: &Plot, time: f64, piece: usize) {
        let points = &*self.trail.make_contiguous();
        let pieces = points.chunks(piece);
        let count = pieces.len();
        let mut strips = Vec::new();
        let mut colors = Vec::new();
        let mut end = 0;
        for (k, piece) in pieces.enumerate() {
            for run in piece.chunk_by(|a, b| a.1 == b.1) {
                // Each run ends at the first point of the next one, so that there is no gap.
                let start = end;
                end += run.len();
                let run_and_next = &points[start..(end + 1).min(points.len())];
                let strip = run_and_next.iter().map(|([u, v], _)| plot.at(*u, *v));
                strips.push(strip.collect::<Vec<_>>());
                let color = self.colors[usize::from(run[0].1)];
                colors.push(style::fade(color, k + 1, count));
            }
        }
        let trail = LineStrips2D::new(strips)
            .with_colors(colors)
            .with_radii([Radius::new_ui_points(0.7)]);
        rec.log(paths::PORTRAIT_TRAIL, time, &trail);
    }
}

/// Logs the current point several times within the frame.
fn draw_point(rec: &RecordingStream, plot: &Plot, frame: &Frame) {
    let chosen = (0..frame.len()).step_by(POINT_EVERY);
    let times: Vec<i64> = chosen.clone().map(|k| nanos(frame.time(k))).collect();
    let positions = chosen.map(|k| plot.at(frame.displacement[k], frame.velocity[k]));
    let columns = Points2D::update_fields()
        .with_positions(positions)
        .columns_of_unit_batches();
    rec.send_rows(paths::PORTRAIT_NOW, &times, columns);
}

/// The delay embedding, Eq. (25), in a cube of side 2.
#[derive(Debug)]
pub struct Embedding {
    letter: &'static str,
    unit: String,
    /// Value at the centre of the cube.
    middle: f64,
    /// Smallest full scale.
    smallest: f64,
    scale: FullScale,
    drawn: bool,
}

impl Embedding {
    /// Starts empty. A displacement oscillates about zero; a signal can have any mean.
    pub fn new(subject: &Subject) -> Self {
        let [middle, smallest] = match subject {
            Subject::Joint(_) | Subject::Small(_) => [0.0, SMALLEST[0]],
            Subject::Signal(signal) => range_shown(signal.span),
        };
        Self {
            letter: letter(subject),
            unit: units(subject)[0].to_owned(),
            middle,
            smallest,
            scale: FullScale::new(smallest),
            drawn: false,
        }
    }

    /// Draws the trail (points in m, oldest first) at a time (s).
    pub fn draw(&mut self, rec: &RecordingStream, time: f64, points: &[[f32; 3]]) {
        let middle = self.middle as f32;
        let sizes = points.iter().flatten().map(|c| (c - middle).abs());
        let largest = sizes.fold(0.0, f32::max);
        let changed = self.scale.update(f64::from(largest), self.smallest);
        if changed || !self.drawn {
            self.drawn = true;
            draw_cube(rec, &Root::of_run(), time.into(), &self.names());
        }
        let unit = self.scale.get().recip() as f32;
        let length = points.len().div_ceil(PIECES).max(1);
        let pieces = points.chunks(length).enumerate().map(|(k, piece)| {
            let points = piece.iter().chain(points.get((k + 1) * length));
            points.map(|p| p.map(|c| unit * (c - middle)))
        });
        let count = pieces.len();
        let trail = LineStrips3D::new(pieces)
            .with_colors((0..count).map(|k| style::fade(Color::Run, k + 1, count)))
            .with_radii([Radius::new_ui_points(0.8)]);
        rec.log(paths::EMBEDDING_TRAIL, time, &trail);
    }

    /// Names and ranges of the axes, such as `u(t), ±0.8 µm`.
    fn names(&self) -> [String; 3] {
        let mut range = format!("±{}", Unit::write(self.scale.get(), &self.unit));
        if self.middle != 0.0 {
            range = format!("{} {range}", short(self.middle));
        }
        delay_names(self.letter, &range)
    }
}

/// Names of the axes of delay vectors: symbol, delay and range.
pub fn delay_names(letter: &str, range: &str) -> [String; 3] {
    ["t", "t − τ", "t − 2τ"].map(|when| format!("{letter}({when}), {range}"))
}

/// Draws the edges of the cube and the names of its axes.
pub fn draw_cube(rec: &RecordingStream, root: &Root, at: Moment, names: &[String; 3]) {
    let mut edges = Vec::new();
    for axis in 0..3 {
        for (a, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let end = |along: f32| -> [f32; 3] {
                let mut point = [along; 3];
                point[(axis + 1) % 3] = a;
                point[(axis + 2) % 3] = b;
                point
            };
            edges.push([end(-1.0), end(1.0)]);
        }
    }
    let edges = LineStrips3D::new(edges)
        .with_colors([Color::Grid])
        .with_radii([Radius::new_ui_points(0.8)]);
    let axes = root.at(paths::EMBEDDING);
    rec.log(paths::axis_lines(&axes), at, &edges);
    let labels = Points3D::new([[0.0, -1.1, -1.1], [1.1, 0.0, -1.1], [1.1, 1.1, 0.0]])
        .with_labels(names.iter().map(|name| shown(name)))
        .with_show_labels(true)
        .with_colors([Color::Faint])
        .with_radii([Radius::new_ui_points(0.0)]);
    rec.log(paths::axis_labels(&axes), at, &labels);
}
