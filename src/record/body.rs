//! The deforming body: the surface of ball and beam, each vertex moved by the exaggerated sum
//! of mode shapes and coloured by how far it has really moved. Of a body whose surface is not known
//! only the axis that it turns about is drawn.

use rerun::{Arrows3D, Color, Mesh3D, Points3D, Radius};

use super::{
    error::RecordError,
    paths,
    stream::{self, RecordingStream},
    style::{self, ColorMap, FullScale, Quantity},
};
use crate::pipeline::message::{Frame, JointInfo, Outline, vertex_normals};

/// Vertices sent in one go, over all pictures of the batch.
const BATCH_VERTICES: usize = 40_000;
/// Smallest full scale of the colours, m.
const SMALLEST: f64 = 1e-9;

/// Everything about the body.
#[derive(Debug)]
pub struct Body {
    /// Vertices at rest, from the ball's centre, m.
    rest: Vec<[f64; 3]>,
    exaggeration: f64,
    /// Time between pictures, s; and the time of the next.
    every: f64,
    next: f64,
    scale: FullScale,
    map: ColorMap,
    /// Mode shapes, one after the other: `3 vertices` numbers a mode, 1/sqrt(kg). Single
    /// precision is plenty for a picture.
    shapes: Vec<f32>,
    /// Displacement of the vertices, m; `3 vertices` numbers.
    moved: Vec<f32>,
    times: Vec<i64>,
    positions: Vec<[f32; 3]>,
    colors: Vec<Color>,
    /// Largest displacement since the scale was last looked at, m.
    peak: f64,
}

impl Body {
    /// Draws what never changes. `rate` is pictures a simulated second.
    pub fn new(
        rec: &RecordingStream,
        joint: &JointInfo,
        rate: f64,
        exaggeration: f64,
    ) -> Result<Self, RecordError> {
        let outline = &joint.outline;
        if !outline.vertices.is_empty() {
            rec.log_static(
                paths::BODY,
                &Mesh3D::update_fields()
                    .with_triangle_indices(outline.triangles.iter().copied())
                    .with_vertex_normals(in_single(&vertex_normals(
                        &outline.vertices,
                        &outline.triangles,
                    ))),
            )?;
        }
        draw_rotation(rec, joint)?;
        Ok(Self {
            rest: outline.vertices.clone(),
            exaggeration,
            every: 1.0 / rate,
            next: 0.0,
            scale: FullScale::new(SMALLEST),
            map: ColorMap::steel(),
            shapes: by_mode(outline, joint.modes.len()),
            moved: vec![0.0; 3 * outline.vertices.len()],
            times: Vec::new(),
            positions: Vec::new(),
            colors: Vec::new(),
            peak: 0.0,
        })
    }

    /// Takes a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        if self.rest.is_empty() {
            return Ok(());
        }
        if let Some(shown) = frame.shown {
            self.every = 1.0 / shown.pictures;
            // The pictures of a slower pace do not wait for the next one of the faster pace before.
            self.next = self.next.min(frame.t0 + self.every);
        }
        let rows = frame.q.chunks_exact(frame.modes);
        for (k, q) in rows.enumerate() {
            // Half a sample of slack, so that rounding never skips a picture.
            if frame.time(k) + 0.5 * frame.dt < self.next {
                continue;
            }
            while self.next <= frame.time(k) + 0.5 * frame.dt {
                self.next += self.every;
            }
            self.times.push(stream::nanos(frame.time(k)));
            displace(&self.shapes, q, &mut self.moved);
            let full = self.scale.get() as f32;
            let mut peak = 0.0f32;
            for (rest, moved) in self.rest.iter().zip(self.moved.chunks_exact(3)) {
                let size = moved.iter().map(|c| c * c).sum::<f32>().sqrt();
                peak = peak.max(size);
                self.positions.push(std::array::from_fn(|i| {
                    (1e3 * (rest[i] + self.exaggeration * f64::from(moved[i]))) as f32
                }));
                let [r, g, b] = self.map.at(size / full);
                self.colors.push(style::rgb(r, g, b));
            }
            self.peak = self.peak.max(f64::from(peak));
        }
        if self.positions.len() >= BATCH_VERTICES {
            self.send(rec)?;
        }
        // The scale follows at the border of frames: the colours lag one frame when it changes.
        if !frame.is_empty() {
            if self.scale.update(self.peak, SMALLEST) || frame.index == 0 {
                self.draw_legend(rec, frame.end())?;
            }
            self.peak *= 0.9;
        }
        Ok(())
    }

    /// Sends what is left.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.send(rec)
    }

    fn send(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        if self.times.is_empty() {
            return Ok(());
        }
        let vertices = self.rest.len();
        let columns = Mesh3D::update_fields()
            .with_vertex_positions(self.positions.drain(..))
            .with_vertex_colors(self.colors.drain(..))
            .columns(std::iter::repeat_n(vertices, self.times.len()));
        stream::send_rows(rec, paths::BODY, &self.times, columns)?;
        self.times.clear();
        Ok(())
    }

    /// Says beside the beam what the brightest colour stands for.
    fn draw_legend(&self, rec: &RecordingStream, time: f64) -> Result<(), RecordError> {
        let lowest = self.rest.iter().map(|v| v[2]).fold(0.0, f64::min);
        let full = self.scale.get();
        let words = format!("grey still, yellow moves {}", Quantity::Length.words(full));
        let legend = Points3D::new([[0.0, 0.0, (1e3 * 1.08 * lowest) as f32]])
            .with_labels([words])
            .with_colors([style::AXIS])
            .with_radii([Radius::new_ui_points(0.0)]);
        stream::log_at(rec, paths::BODY_LEGEND, time, &legend)
    }
}

/// Mode shapes in the order in which they are summed: all vertices of a mode in a row.
fn by_mode(outline: &Outline, modes: usize) -> Vec<f32> {
    (0..modes)
        .flat_map(|mode| outline.shapes.iter().skip(mode).step_by(modes))
        .flat_map(|shape| shape.map(|c| c as f32))
        .collect()
}

/// Eq. (7) at all vertices: the sum of mode shapes times modal coordinates, m.
fn displace(shapes: &[f32], q: &[f64], moved: &mut [f32]) {
    moved.fill(0.0);
    for (shape, &q) in shapes.chunks_exact(moved.len()).zip(q) {
        for (sum, part) in moved.iter_mut().zip(shape) {
            *sum += part * q as f32;
        }
    }
}

/// Vectors as they are drawn.
pub(super) fn in_single(vectors: &[[f64; 3]]) -> impl Iterator<Item = [f32; 3]> {
    vectors.iter().map(|v| v.map(|c| c as f32))
}

/// The axis that the ball turns about.
fn draw_rotation(rec: &RecordingStream, joint: &JointInfo) -> Result<(), RecordError> {
    let speed = joint.rotation.iter().map(|c| c * c).sum::<f64>().sqrt();
    if speed == 0.0 {
        return Ok(());
    }
    let reach = 1e3 * 1.9 * joint.ball_radius / speed;
    let along = joint.rotation.map(|c| (reach * c) as f32);
    let arrow = Arrows3D::from_vectors([along.map(|c| 2.0 * c)])
        .with_origins([along.map(|c| -c)])
        .with_colors([style::ROTATION])
        .with_radii([0.8])
        .with_labels([format!(
            "turns at {} rad/s",
            style::span(joint.rotation_span, |factor| style::short(factor * speed))
        )]);
    rec.log_static(paths::ROTATION, &arrow)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacement_sums_shapes() {
        // Two vertices, two modes.
        let outline = Outline {
            shapes: vec![[1.0, 0.0, 2.0], [0.0, -3.0, 1.0], [4.0; 3], [-8.0; 3]],
            ..Outline::default()
        };
        let mut moved = [f32::NAN; 6];
        displace(&by_mode(&outline, 2), &[2.0, 0.5], &mut moved);
        assert_eq!(moved, [2.0, -1.5, 4.5, 4.0, 4.0, 4.0]);
    }
}
