//! The deforming body: the surface of ball and beam. Each vertex is displaced by the magnified sum of mode
//! shapes, and coloured by its true displacement. If the surface of the body is not known, only its axis of
//! rotation is drawn.

use crate::record::sdk::{Arrows3D, Color, Mesh3D, Points3D, Radius};

use super::paths;
use super::stream::{RecordingStream, nanos};
use super::style;
use crate::pipeline::message::{Frame, JointInfo, vertex_normals};
use crate::plot::{self, FullScale, Rgb, Unit};
use crate::scene::RecordSpec;

/// Vertices per batch, summed over its pictures.
const BATCH_VERTICES: usize = 40_000;
/// Smallest full scale of the colours, m.
const SMALLEST: f64 = 1e-9;

/// The body and its pictures that are not sent yet.
#[derive(Debug)]
pub struct Body {
    /// Vertices at rest, relative to the ball centre, m.
    rest: Vec<[f64; 3]>,
    deformation_scale: f64,
    /// Interval between pictures, and time of the next picture, s.
    every: f64,
    next: f64,
    scale: FullScale,
    map: [Rgb; 256],
    /// Mode shapes one after the other, `3 vertices` numbers each, 1/sqrt(kg). Single precision is sufficient
    /// for pictures.
    shapes: Vec<f32>,
    /// Displacements of the vertices, m; `3 vertices` numbers.
    moved: Vec<f32>,
    times: Vec<i64>,
    positions: Vec<[f32; 3]>,
    colors: Vec<Color>,
    /// Largest displacement since the last update of the scale, m.
    peak: f64,
}

impl Body {
    /// Draws the static elements.
    pub fn new(rec: &RecordingStream, joint: &JointInfo, spec: RecordSpec) -> Self {
        let outline = &joint.outline;
        if !outline.vertices.is_empty() {
            let normals = vertex_normals(&outline.vertices, &outline.triangles);
            let surface = Mesh3D::update_fields()
                .with_triangle_indices(outline.triangles.iter().copied())
                .with_vertex_normals(in_single(&normals));
            rec.log_static(paths::BODY, &surface);
        }
        draw_rotation(rec, joint);
        Self {
            rest: outline.vertices.clone(),
            deformation_scale: spec.deformation_scale,
            every: 1.0 / spec.body_rate,
            next: 0.0,
            scale: FullScale::new(SMALLEST),
            map: style::steel(),
            shapes: outline.shapes_by_mode().collect(),
            moved: vec![0.0; 3 * outline.vertices.len()],
            times: Vec::new(),
            positions: Vec::new(),
            colors: Vec::new(),
            peak: 0.0,
        }
    }

    /// Adds a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) {
        if self.rest.is_empty() {
            return;
        }
        if let Some(shown) = frame.shown {
            self.every = 1.0 / shown.pictures;
            // After a change to a lower playback speed, the next picture must not wait for the old interval.
            self.next = self.next.min(frame.t0 + self.every);
        }
        let rows = frame.q.chunks_exact(frame.modes);
        for (k, q) in rows.enumerate() {
            // A tolerance of half a sample, so that rounding never skips a picture.
            if frame.time(k) + 0.5 * frame.dt < self.next {
                continue;
            }
            while self.next <= frame.time(k) + 0.5 * frame.dt {
                self.next += self.every;
            }
            self.times.push(nanos(frame.time(k)));
            displace(&self.shapes, q, &mut self.moved);
            let full = self.scale.get() as f32;
            let mut peak = 0.0f32;
            for (rest, moved) in self.rest.iter().zip(self.moved.chunks_exact(3)) {
                let size = moved.iter().map(|c| c * c).sum::<f32>().sqrt();
                peak = peak.max(size);
                self.positions.push(std::array::from_fn(|i| {
                    (1e3 * (rest[i] + self.deformation_scale * f64::from(moved[i]))) as f32
                }));
                self.colors
                    .push(style::rgb(style::shade(&self.map, size / full)));
            }
            self.peak = self.peak.max(f64::from(peak));
        }
        if self.positions.len() >= BATCH_VERTICES {
            self.send(rec);
        }
        // The scale is updated at the end of a frame, so colours lag by one frame when it changes.
        if !frame.is_empty() {
            if self.scale.update(self.peak, SMALLEST) || frame.index == 0 {
                self.draw_legend(rec, frame.end());
            }
            self.peak *= 0.9;
        }
    }

    /// Sends pending pictures.
    pub fn send(&mut self, rec: &RecordingStream) {
        if self.times.is_empty() {
            return;
        }
        let vertices = self.rest.len();
        let columns = Mesh3D::update_fields()
            .with_vertex_positions(self.positions.drain(..))
            .with_vertex_colors(self.colors.drain(..))
            .columns(std::iter::repeat_n(vertices, self.times.len()));
        rec.send_rows(paths::BODY, &self.times, columns);
        self.times.clear();
    }

    /// Writes the meaning of the brightest colour next to the beam.
    fn draw_legend(&self, rec: &RecordingStream, time: f64) {
        let lowest = self.rest.iter().map(|v| v[2]).fold(0.0, f64::min);
        let full = self.scale.get();
        let words = format!("grey at rest, yellow {}", Unit::write(full, "m"));
        let legend = Points3D::new([[0.0, 0.0, (1e3 * 1.08 * lowest) as f32]])
            .with_labels([words])
            .with_colors([plot::Color::Faint])
            .with_radii([Radius::new_ui_points(0.0)]);
        rec.log(paths::BODY_LEGEND, time, &legend);
    }
}

/// Eq. (7) at all vertices: sum of mode shapes times modal coordinates, m.
fn displace(shapes: &[f32], q: &[f64], moved: &mut [f32]) {
    moved.fill(0.0);
    for (shape, &q) in shapes.chunks_exact(moved.len()).zip(q) {
        for (sum, part) in moved.iter_mut().zip(shape) {
            *sum += part * q as f32;
        }
    }
}

/// Vectors in single precision.
pub(super) fn in_single(vectors: &[[f64; 3]]) -> impl Iterator<Item = [f32; 3]> {
    vectors.iter().map(|v| v.map(|c| c as f32))
}

/// Draws the axis of rotation of the ball.
fn draw_rotation(rec: &RecordingStream, joint: &JointInfo) {
    let speed = joint.rotation.iter().map(|c| c * c).sum::<f64>().sqrt();
    if speed == 0.0 {
        return;
    }
    let reach = 1e3 * 1.9 * joint.ball_radius / speed;
    let along = joint.rotation.map(|c| (reach * c) as f32);
    let range = style::format_range(joint.rotation_span, |factor| style::short(factor * speed));
    let arrow = Arrows3D::from_vectors([along.map(|c| 2.0 * c)])
        .with_origins([along.map(|c| -c)])
        .with_colors([style::ROTATION])
        .with_radii([0.8])
        .with_labels([format!("rotation {range} rad/s")]);
    rec.log_static(paths::ROTATION, &arrow);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::SurfaceMesh;

    #[test]
    fn displacement_sums_shapes() {
        // Two vertices, two modes.
        let outline = SurfaceMesh {
            shapes: vec![[1.0, 0.0, 2.0], [0.0, -3.0, 1.0], [4.0; 3], [-8.0; 3]],
            modes: 2,
            ..SurfaceMesh::default()
        };
        let mut moved = [f32::NAN; 6];
        let shapes: Vec<f32> = outline.shapes_by_mode().collect();
        displace(&shapes, &[2.0, 0.5], &mut moved);
        assert_eq!(moved, [2.0, -1.5, 4.5, 4.0, 4.0, 4.0]);
    }
}
