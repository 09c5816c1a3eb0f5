//! The attractor: phase portrait (u, v) and delay embedding, each a trail that fades with age.

use std::collections::VecDeque;

use crate::record::sdk::{Color, LineStrips2D, LineStrips3D, Points2D, Points3D, Radius};

use super::{
    error::RecordError,
    panel_view::PanelView,
    paths::{self, Root},
    plot::Plot,
    stream::{self, Moment, RecordingStream},
    style::{self, short},
};
use crate::{
    pipeline::message::{Frame, Subject},
    plot::{
        self, FullScale, RedrawTimer, Unit, letter, range_shown,
        response::{SMALLEST, phase_portrait},
        units,
    },
};

/// Length of a joint's trail, s: 80 periods of a 4 kHz squeak, and about five of the beat of two tones 0.25
/// kHz apart, so that the trail covers a torus before it fades.
pub const TRAIL: f64 = 20e-3;
/// Interval of the logged current points, samples.
const POINT_EVERY: usize = 10;
/// Approximate maximum number of pieces of the trail of the phase portrait.
const FADES: f64 = 100.0;
/// Number of pieces of the delay trail, each with one colour.
const PIECES: usize = 8;

/// The phase portrait of the probe.
#[derive(Debug)]
pub struct Portrait {
    /// Length of the trail, s.
    length: f64,
    /// Colours of the trail by status; the first one if there is no status.
    colors: Vec<Color>,
    /// The last frames, oldest first.
    trail: VecDeque<Piece>,
    scales: [FullScale; 2],
    drawn: bool,
    redraw: RedrawTimer,
}

/// A piece of the trail: one frame or several short ones.
#[derive(Debug)]
struct Piece {
    /// Displacement in m, velocity in m/s.
    points: Vec<[f64; 2]>,
    /// Runs of the same status: number of points and status.
    stretches: Vec<(usize, u8)>,
}

impl Piece {
    fn new(frame: &Frame) -> Self {
        let points = frame.displacement.iter().zip(&frame.velocity);
        let stretches = frame.status.chunk_by(|a, b| a == b);
        let mut stretches: Vec<_> = stretches.map(|same| (same.len(), same[0])).collect();
        if stretches.is_empty() {
            stretches.push((frame.len(), 0));
        }
        Self {
            points: points.map(|(&u, &v)| [u, v]).collect(),
            stretches,
        }
    }

    fn points(&self) -> impl Iterator<Item = &[f64; 2]> {
        self.points.iter()
    }

    /// Appends the next piece.
    fn append(&mut self, next: Self) {
        self.points.extend(next.points);
        self.stretches.extend(next.stretches);
    }
}

impl Portrait {
    /// Starts empty; the axes are drawn with the first frame. The trail is `length` (s) long and coloured by
    /// the status of the samples.
    pub fn new(length: f64, colors: Vec<Color>) -> Self {
        Self {
            length,
            colors,
            trail: VecDeque::new(),
            scales: SMALLEST.map(FullScale::new),
            drawn: false,
            redraw: RedrawTimer::default(),
        }
    }

    /// Adds a frame; the trail is redrawn once per frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        if frame.is_empty() {
            return Ok(());
        }
        self.lengthen(frame);
        self.redraw.set_rate(frame);
        if !self.redraw.is_due(frame.end()) {
            return Ok(());
        }

        let mut changed = !self.drawn;
        self.drawn = true;
        for (c, scale) in self.scales.iter_mut().enumerate() {
            let all = self.trail.iter().flat_map(Piece::points);
            let peak = all.map(|p| p[c].abs()).fold(0.0, f64::max);
            changed |= scale.update(peak, SMALLEST[c]);
        }
        let field = Field::new(self.scales.map(FullScale::get));
        if changed {
            field
                .plot
                .draw(rec, paths::PORTRAIT, Some(frame.t0.into()))?;
        }
        self.draw_trail(rec, &field, frame)?;
        draw_point(rec, &field, frame)
    }

    /// Adds a frame to the trail and removes frames that are too old.
    fn lengthen(&mut self, frame: &Frame) {
        let wanted = (self.length / frame.dt).ceil();
        let piece = Piece::new(frame);
        match self.trail.back_mut() {
            // More pieces, each with its own colour, would not improve the fading.
            Some(last) if (last.points.len() as f64) < wanted / FADES => last.append(piece),
            _ => self.trail.push_back(piece),
        }
        let mut count: usize = self.trail.iter().map(|piece| piece.points.len()).sum();
        while let Some(oldest) = self.trail.front() {
            count -= oldest.points.len();
            if (count as f64) < wanted || count == 0 {
                break;
            }
            self.trail.pop_front();
        }
    }

    fn draw_trail(
        &self,
        rec: &RecordingStream,
        field: &Field,
        frame: &Frame,
    ) -> Result<(), RecordError> {
        let pieces = self.trail.len();
        let mut strips = Vec::new();
        let mut colors = Vec::new();
        for (k, piece) in self.trail.iter().enumerate() {
            // Each run ends at the first point of the next one, so that there is no gap.
            let next = self.trail.get(k + 1).and_then(|piece| piece.points.first());
            let mut start = 0;
            for &(length, status) in &piece.stretches {
                let (stretch, rest) = piece.points[start..].split_at(length);
                let points = stretch.iter().chain(rest.first().or(next));
                strips.push(points.map(|p| field.at(*p)).collect::<Vec<_>>());
                colors.push(style::fade(self.colors[usize::from(status)], k + 1, pieces));
                start += length;
            }
        }
        let trail = LineStrips2D::new(strips)
            .with_colors(colors)
            .with_radii([Radius::new_ui_points(0.7)]);
        stream::log_at(rec, paths::PORTRAIT_TRAIL, frame.t0, &trail)
    }
}

/// The phase plane: the axes of its panel, and the factors to their units.
struct Field {
    plot: Plot,
    factors: [f64; 2],
}

impl Field {
    /// The phase plane with given full scales (m and m/s).
    fn new(scales: [f64; 2]) -> Self {
        let panel = phase_portrait(&[], Some(scales), plot::Color::Run);
        Self {
            factors: [panel.x.range[1] / scales[0], panel.y.range[1] / scales[1]],
            plot: PanelView::of("portrait", &Root::of_run()).plot(&panel),
        }
    }

    /// Position of a displacement (m) and a velocity (m/s) in the plot.
    fn at(&self, [u, v]: [f64; 2]) -> [f32; 2] {
        let [length, speed] = self.factors;
        self.plot.at(length * u, speed * v)
    }
}

/// Logs the current point several times within the frame.
fn draw_point(rec: &RecordingStream, field: &Field, frame: &Frame) -> Result<(), RecordError> {
    let chosen = (0..frame.len()).step_by(POINT_EVERY);
    let times: Vec<i64> = chosen
        .clone()
        .map(|k| stream::nanos(frame.time(k)))
        .collect();
    let positions = chosen.map(|k| field.at([frame.displacement[k], frame.velocity[k]]));
    let columns = Points2D::update_fields()
        .with_positions(positions)
        .columns_of_unit_batches();
    stream::send_rows(rec, paths::PORTRAIT_NOW, &times, columns)
}

/// Logs the static style of the current point.
pub fn style_point(rec: &RecordingStream) -> Result<(), RecordError> {
    let style = Points2D::update_fields()
        .with_colors([style::ACCENT])
        .with_radii([Radius::new_ui_points(4.0)])
        .with_draw_order(1.0);
    rec.log_static(paths::PORTRAIT_NOW, &style)
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
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        time: f64,
        points: &[[f32; 3]],
    ) -> Result<(), RecordError> {
        let middle = self.middle as f32;
        let sizes = points.iter().flatten().map(|c| (c - middle).abs());
        let largest = sizes.fold(0.0, f32::max);
        let changed = self.scale.update(f64::from(largest), self.smallest);
        if changed || !self.drawn {
            self.drawn = true;
            draw_cube(rec, &Root::of_run(), time.into(), &self.names())?;
        }
        let unit = self.scale.get().recip() as f32;
        let length = points.len().div_ceil(PIECES).max(1);
        let pieces: Vec<Vec<[f32; 3]>> = points
            .chunks(length)
            .enumerate()
            .map(|(k, piece)| {
                let next = points.get((k + 1) * length);
                let points = piece.iter().chain(next);
                points.map(|p| p.map(|c| unit * (c - middle))).collect()
            })
            .collect();
        let count = pieces.len();
        let trail = LineStrips3D::new(pieces)
            .with_colors((0..count).map(|k| style::fade(style::SIGNAL, k + 1, count)))
            .with_radii([Radius::new_ui_points(0.8)]);
        stream::log_at(rec, paths::EMBEDDING_TRAIL, time, &trail)
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
    ["t", "t - τ", "t - 2τ"].map(|when| format!("{letter}({when}), {range}"))
}

/// Draws the edges of the cube and the names of its axes.
pub fn draw_cube(
    rec: &RecordingStream,
    root: &Root,
    at: Moment,
    names: &[String; 3],
) -> Result<(), RecordError> {
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
        .with_colors([style::GRID])
        .with_radii([Radius::new_ui_points(0.8)]);
    let axes = root.at(paths::EMBEDDING);
    stream::log_at(rec, paths::axis_lines(&axes), at, &edges)?;
    let labels = Points3D::new([[0.0, -1.1, -1.1], [1.1, 0.0, -1.1], [1.1, 1.1, 0.0]])
        .with_labels(names.iter().map(String::as_str))
        .with_show_labels(true)
        .with_colors([style::AXIS])
        .with_radii([Radius::new_ui_points(0.0)]);
    stream::log_at(rec, paths::axis_labels(&axes), at, &labels)
}
