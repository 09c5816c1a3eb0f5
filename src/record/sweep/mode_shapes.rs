//! Fig. 2 in three dimensions: the natural modes of ball and beam side by side, with magnified displacements,
//! coloured by displacement.

use crate::record::sdk::{LineStrips3D, Mesh3D, Points3D, Radius};

use crate::fem::ModeKind;
use crate::joint::BallJoint;
use crate::pipeline::message::vertex_normals;
use crate::plot::Color;
use crate::record::blueprint::tree::{Part, View};
use crate::record::body::in_single;
use crate::record::stream::RecordingStream;
use crate::record::style;

/// Numbers of rings and of meridians of the surface.
const OUTLINE: [usize; 2] = [60, 24];

/// Largest drawn displacement, mm, and that of torsion, which would distort the beam at the larger value.
const LARGEST: f64 = 15.0;
const LARGEST_TURN: f64 = 6.0;
/// Distance between modes, mm.
const APART: f64 = 75.0;

/// The tab of the modes, from the front and slightly from above.
pub fn tab(ball: &BallJoint) -> Option<Part> {
    let distance = 60.0 * ball.body().ok()?.families().len().max(6) as f64;
    let middle = [0.0, 0.0, -95.0];
    let eye = [0.0, -0.98, 0.2].map(|c: f64| c * distance);
    let from = [eye[0], eye[1], eye[2] + middle[2]];
    let name = "Natural modes (yellow: largest displacement)";
    let view = View::of("3D", name, "mode_shapes").with_eye(from, middle, [0.0, 0.0, 1.0]);
    Some(Part::tab("Mode shapes", vec![Part::View(view)]))
}

/// Draws all modes; they do not depend on the parameter.
pub fn draw(rec: &RecordingStream, ball: &BallJoint) {
    let Some(body) = rec.check(ball.body()) else {
        return;
    };
    let outline = body.outline(OUTLINE[0], OUTLINE[1]);
    let families = body.families();
    let map = style::steel();
    let lowest = outline.vertices.iter().map(|v| v[2]).fold(0.0, f64::min);
    let mut names = Vec::new();
    let mut axes = Vec::new();
    for (place, (mode, name)) in families.iter().enumerate() {
        let shape = || (0..outline.vertices.len()).map(|vertex| outline.shapes_at(vertex)[*mode]);
        let sizes = shape().map(|u| u.iter().map(|c| c * c).sum::<f64>().sqrt());
        let sizes: Vec<f64> = sizes.collect();
        let largest = sizes.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let drawn = match body.modes()[*mode].kind {
            ModeKind::Torsion => LARGEST_TURN,
            _ => LARGEST,
        };
        let across = APART * (place as f64 - 0.5 * (families.len() as f64 - 1.0));
        let moved = outline
            .vertices
            .iter()
            .zip(shape())
            .map(|(rest, u)| std::array::from_fn(|i| rest[i] + 1e-3 * drawn / largest * u[i]));
        let vertices: Vec<[f64; 3]> = moved.collect();
        let normals = vertex_normals(&vertices, &outline.triangles);
        let drawn = vertices.iter();
        let drawn = drawn.map(|[x, y, z]| [1e3 * x + across, 1e3 * y, 1e3 * z].map(|c| c as f32));
        let colors = sizes.iter();
        let colors = colors.map(|size| style::rgb(style::shade(&map, (size / largest) as f32)));
        let mesh = Mesh3D::new(drawn)
            .with_triangle_indices(outline.triangles.iter().copied())
            .with_vertex_normals(in_single(&normals))
            .with_vertex_colors(colors);
        rec.log_static(format!("mode_shapes/mode_{place:02}"), &mesh);
        axes.push([[across, 0.0, 1e3 * lowest], [across, 0.0, 0.0]].map(|p| p.map(|c| c as f32)));
        // Labels have a single line.
        let frequency = ball.frequencies_hz()[*mode];
        let lines = [name.clone(), format!("{frequency:.0} Hz")];
        for (words, below) in lines.into_iter().zip([1.14, 1.2]) {
            names.push(([across as f32, 0.0, (1e3 * below * lowest) as f32], words));
        }
    }
    let axes = LineStrips3D::new(axes)
        .with_colors([Color::Faint])
        .with_radii([Radius::new_ui_points(0.6)]);
    rec.log_static("mode_shapes/axes", &axes);
    let names = Points3D::new(names.iter().map(|(at, _)| *at))
        .with_labels(names.iter().map(|(_, words)| words.as_str()))
        .with_show_labels(true)
        .with_colors([Color::Faint])
        .with_radii([Radius::new_ui_points(0.0)]);
    rec.log_static("mode_shapes/names", &names);
}
