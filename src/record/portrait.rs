//! The attractor: phase portrait (u, v) and delay embedding, each a trail that fades with age.

use std::collections::VecDeque;

use rerun::{Color, LineStrips2D, LineStrips3D, Points2D, Points3D, Radius};

use super::{
    due::Due,
    error::RecordError,
    paths::{self, Root},
    plot::Plot,
    stream::{self, Moment, RecordingStream},
    style::{self, FullScale, Quantity, Unit, short},
};
use crate::{
    pipeline::message::{Frame, Subject},
    plot::Axis,
};

/// Length of a joint's trail, s: eighty periods of a 4 kHz squeak, and some five of the beat of two
/// tones a quarter of a kHz apart, so that a torus has closed before it fades.
pub const TRAIL: f64 = 20e-3;
/// The present point is logged every this many samples.
const POINT_EVERY: usize = 10;
/// Side of the field, pixels.
const SIDE: f32 = 400.0;
/// Smallest full scales: displacement in m and velocity in m/s.
const SMALLEST: [f64; 2] = [1e-12, 1e-8];
/// Pieces of the phase portrait's trail, at most, about.
const FADES: f64 = 100.0;
/// Pieces of the delay trail, each of one colour.
const PIECES: usize = 8;

/// The phase portrait of the probe.
#[derive(Debug)]
pub struct Portrait {
    /// Length of the trail, s.
    length: f64,
    /// Colours of the trail by status; the first one where there is none.
    colors: Vec<Color>,
    /// The last frames, oldest first.
    trail: VecDeque<Piece>,
    scales: [FullScale; 2],
    drawn: bool,
    due: Due,
}

/// A stretch of the trail: a frame, or several short ones.
#[derive(Debug)]
struct Piece {
    /// Displacement in m, velocity in m/s.
    points: Vec<[f64; 2]>,
    /// Stretches of one status: the number of points and the status.
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

    /// Goes on with the piece that follows.
    fn append(&mut self, next: Self) {
        self.points.extend(next.points);
        self.stretches.extend(next.stretches);
    }
}

impl Portrait {
    /// Starts empty; the axes are drawn with the first frame. The trail is `length` (s) long, and
    /// has one of the colours by the status of the samples.
    pub fn new(length: f64, colors: Vec<Color>) -> Self {
        Self {
            length,
            colors,
            trail: VecDeque::new(),
            scales: SMALLEST.map(FullScale::new),
            drawn: false,
            due: Due::default(),
        }
    }

    /// What the view must show, whatever the scale.
    pub fn bounds() -> super::plot::Bounds {
        Field::new([1.0, 1.0]).plot.bounds()
    }

    /// Takes a frame: the trail is drawn anew once a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        if frame.is_empty() {
            return Ok(());
        }
        self.lengthen(frame);
        self.due.follow(frame);
        if !self.due.is_due(frame.end()) {
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

    /// Adds a frame to the trail, and drops what is too old.
    fn lengthen(&mut self, frame: &Frame) {
        let wanted = (self.length / frame.dt).ceil();
        let piece = Piece::new(frame);
        match self.trail.back_mut() {
            // Many short pieces of one colour each would show no better how the trail fades.
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
            // Each stretch runs on to the first point of the next, without a gap.
            let next = self.trail.get(k + 1).and_then(|piece| piece.points.first());
            let mut start = 0;
            for &(length, status) in &piece.stretches {
                let (stretch, rest) = piece.points[start..].split_at(length);
                let points = stretch.iter().chain(rest.first().or(next));
                strips.push(points.map(|p| field.at(*p)).collect::<Vec<_>>());
                colors.push(fade(self.colors[usize::from(status)], k + 1, pieces));
                start += length;
            }
        }
        let trail = LineStrips2D::new(strips)
            .with_colors(colors)
            .with_radii([Radius::new_ui_points(0.7)]);
        stream::log_at(rec, paths::PORTRAIT_TRAIL, frame.t0, &trail)
    }
}

/// A plot of the phase plane, and the units of its axes.
pub(super) struct Field {
    pub plot: Plot,
    pub units: [Unit; 2],
}

impl Field {
    /// The phase plane with given full scales (m and m/s).
    pub fn new(scales: [f64; 2]) -> Self {
        let units = [
            Quantity::Length.unit(scales[0]),
            Quantity::Speed.unit(scales[1]),
        ];
        let axis = |name: &str, full: f64, unit: &Unit| {
            let full = unit.per_si * full;
            Axis::linear(format!("{name}, {}", unit.symbol), [-full, full])
        };
        let plot = Plot {
            width: SIDE,
            height: SIDE,
            head: 0.0,
            x: axis("displacement", scales[0], &units[0]),
            y: axis("velocity", scales[1], &units[1]),
            grid: true,
        };
        Self { plot, units }
    }

    /// The picture position of a displacement (m) and a velocity (m/s).
    fn at(&self, point: [f64; 2]) -> [f32; 2] {
        let [x, y] = self.values(point);
        self.plot.at(x, y)
    }

    /// A displacement (m) and a velocity (m/s) in the units of the axes.
    pub fn values(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [length, speed] = &self.units;
        [length.per_si * u, speed.per_si * v]
    }
}

/// The present point moves finely within the frame.
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

/// A colour in piece `k` (1 oldest) of `count`.
pub fn fade(color: Color, k: usize, count: usize) -> Color {
    let age = k as f32 / count as f32;
    style::faded(color, 0.18 + 0.82 * age.powi(2))
}

/// Looks of the present point, for all times.
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
    quantity: Quantity,
    /// The value drawn in the middle of the cube.
    middle: f64,
    /// The smallest full scale to either side.
    smallest: f64,
    scale: FullScale,
    drawn: bool,
}

impl Embedding {
    /// Starts empty. A displacement swings about zero; a signal may have any mean.
    pub fn new(subject: &Subject) -> Self {
        let (middle, smallest) = match subject {
            Subject::Joint(_) | Subject::Small(_) => (0.0, SMALLEST[0]),
            Subject::Signal(signal) => style::range_shown(signal.span),
        };
        Self {
            letter: style::letter(subject),
            quantity: Quantity::displacement(subject),
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
            .with_colors((0..count).map(|k| fade(style::SIGNAL, k + 1, count)))
            .with_radii([Radius::new_ui_points(0.8)]);
        stream::log_at(rec, paths::EMBEDDING_TRAIL, time, &trail)
    }

    /// What the axes are and what they span, such as `u(t), ±0.8 µm`.
    fn names(&self) -> [String; 3] {
        let mut range = format!("±{}", self.quantity.words(self.scale.get()));
        if self.middle != 0.0 {
            range = format!("{} {range}", short(self.middle));
        }
        delay_names(self.letter, &range)
    }
}

/// Names of the axes of delay vectors: what is delayed, and what each axis spans.
pub fn delay_names(letter: &str, range: &str) -> [String; 3] {
    ["t", "t - τ", "t - 2τ"].map(|when| format!("{letter}({when}), {range}"))
}

/// Edges of the cube, and at their ends what the axes are.
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
