//! Fig. 1 and 2: ball and beam, the patch, the mode shapes.

use crate::fem::{FamilyMode, ModeKind, SurfaceMesh};
use crate::figure::panel::{Axis, Mark, Panel};
use crate::figure::style::{BLUE, FAINT, GREEN, INK, PALE, Rgb, VERMILION};
use crate::figure::{Figure, FigureError};
use crate::joint::{BallJoint, Model};

/// Rings and meridians of the wire model.
const ALONG: usize = 40;
const ROUND: usize = 16;

/// The largest displacement of a mode shape as drawn, m.
const LARGEST: f64 = 15e-3;
/// That of torsion, which would blow up the beam if drawn so large.
const LARGEST_TORSION: f64 = 7e-3;

/// From where the body is looked at: an oblique view, the beam's axis upright.
const VIEW: [[f64; 3]; 2] = [[0.866, -0.5, 0.0], [0.12, 0.21, 0.97]];

/// Fig. 1: configuration at a tilt (rad) and pre-stress on the contact patch.
///
/// # Errors
/// [`FigureError`].
pub fn configuration(ball: &BallJoint, model: &Model, tilt: f64) -> Result<Figure, FigureError> {
    let mesh = ball.body()?.outline(ALONG, ROUND);
    let radius = ball.ball_radius();
    let mut marks = wires(&mesh, INK, |_, at| at);
    let arrow = |from: [f64; 3], to: [f64; 3], color: Rgb, label: String| Mark::Line {
        points: arrow(place(from), place(to)),
        color,
        label,
    };
    let direction = ball.direction(tilt);
    let scaled = |v: [f64; 3], by: f64| v.map(|x| by * x);
    // The load presses the ball against the socket along `direction`, from outside.
    marks.push(arrow(
        scaled(direction, 3.4 * radius),
        scaled(direction, 1.05 * radius),
        VERMILION,
        format!("load {} N", ball.spec().load),
    ));
    let rotation = ball.spec().rotation;
    let size = rotation.iter().map(|w| w * w).sum::<f64>().sqrt();
    marks.push(arrow(
        [0.0; 3],
        scaled(rotation, 2.6 * radius / size.max(f64::MIN_POSITIVE)),
        BLUE,
        format!("rotation {size:.3} rad/s"),
    ));
    let configuration = Panel {
        title: format!("load tilted by {:.1}°", tilt.to_degrees()),
        x: Axis::linear("mm", [-105.0, 105.0]),
        y: Axis::linear("mm", [-225.0, 65.0]),
        marks,
    };
    Figure::new(
        "figure-1",
        "Fig. 1 — configuration, and pre-stress on the contact patch",
        [1000, 640],
        &[vec![configuration, pre_stress(ball, model, direction)]],
    )
}

/// The pre-stress of the contact nodes over their distance from the middle of the patch, and Hertz'.
fn pre_stress(ball: &BallJoint, model: &Model, direction: [f64; 3]) -> Panel {
    let distance = |position: &[f64; 3]| {
        let along: f64 = position.iter().zip(direction).map(|(a, b)| a * b).sum();
        let square: f64 = position.iter().map(|x| x * x).sum();
        (square - along * along).max(0.0).sqrt()
    };
    let nodes = model.positions.iter().zip(&model.pre_stress);
    let nodes = nodes.map(|(position, p)| [1e3 * distance(position), 1e-6 * p]);
    let radius = ball.patch_radius();
    // The load over the patch's area is two thirds of the pressure in its middle.
    let middle = 1.5 * ball.spec().load / (std::f64::consts::PI * radius * radius);
    let curve = (0..=200).map(|k| {
        let s = f64::from(k) / 200.0;
        [
            1e3 * radius * s,
            1e-6 * middle * (1.0 - s * s).max(0.0).sqrt(),
        ]
    });
    Panel {
        title: format!("pre-stress on the patch, up to {:.2} MPa", 1e-6 * middle),
        x: Axis::linear("distance from the middle, mm", [0.0, 1.05e3 * radius]),
        y: Axis::linear("pre-stress, MPa", [0.0, 1.1e-6 * middle]),
        marks: vec![
            Mark::Line {
                points: curve.collect(),
                color: FAINT,
                label: "Hertz".to_owned(),
            },
            Mark::Dots {
                points: nodes.collect(),
                radius: 2.6,
                color: VERMILION,
                label: format!("{} contact nodes", model.nodes()),
            },
        ],
    }
}

/// Fig. 2: the mode shapes, one of each bending pair, upon the body at rest.
///
/// # Errors
/// [`FigureError`].
pub fn mode_shapes(ball: &BallJoint) -> Result<Figure, FigureError> {
    let body = ball.body()?;
    let mesh = body.outline(ALONG, ROUND);
    let panel = |title: String, marks| Panel {
        title,
        x: Axis::linear("mm", [-60.0, 60.0]),
        y: Axis::linear("mm", [-230.0, 45.0]),
        marks,
    };
    let mut panels = vec![panel("at rest".to_owned(), wires(&mesh, INK, |_, at| at))];
    for FamilyMode { mode, name } in body.families() {
        let size = |vertex| {
            mesh.shapes_at(vertex)[mode]
                .iter()
                .map(|x| x * x)
                .sum::<f64>()
        };
        let largest = (0..mesh.vertices.len())
            .map(size)
            .fold(f64::MIN_POSITIVE, f64::max)
            .sqrt();
        let (color, drawn) = match body.modes()[mode].kind {
            ModeKind::BendingX | ModeKind::BendingY => (BLUE, LARGEST),
            ModeKind::Torsion => (VERMILION, LARGEST_TORSION),
            ModeKind::Axial => (GREEN, LARGEST),
        };
        let mut marks = wires(&mesh, PALE, |_, at| at);
        marks.extend(wires(&mesh, color, |vertex, at| {
            let shape = mesh.shapes_at(vertex)[mode];
            std::array::from_fn(|i| at[i] + drawn / largest * shape[i])
        }));
        let frequency = ball.frequencies_hz()[mode];
        panels.push(panel(format!("{name}, {frequency:.0} Hz"), marks));
    }
    let rows: Vec<Vec<Panel>> = panels.chunks(4).map(<[Panel]>::to_vec).collect();
    let height = 60 + 420 * rows.len() as u32;
    Figure::new("figure-2", "Fig. 2 — mode shapes", [1000, height], &rows)
}

/// Rings and meridians of the surface, each vertex moved by `moved`.
fn wires(mesh: &SurfaceMesh, color: Rgb, moved: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> Vec<Mark> {
    let at = |ring: usize, j: usize| {
        let vertex = 1 + ring * ROUND + j % ROUND;
        place(moved(vertex, mesh.vertices[vertex]))
    };
    let rings = (0..ALONG)
        .step_by(3)
        .map(|ring| (0..=ROUND).map(|j| at(ring, j)).collect());
    let meridians = (0..ROUND)
        .step_by(2)
        .map(|j| (0..ALONG).map(|ring| at(ring, j)).collect());
    let lines: Vec<Vec<[f64; 2]>> = rings.chain(meridians).collect();
    lines
        .into_iter()
        .map(|points| Mark::Wire { points, color })
        .collect()
}

/// A point of space (m) on the picture, mm.
fn place(at: [f64; 3]) -> [f64; 2] {
    VIEW.map(|axis| 1e3 * axis.iter().zip(at).map(|(a, b)| a * b).sum::<f64>())
}

/// A line with a head.
fn arrow(from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
    let along = [to[0] - from[0], to[1] - from[1]];
    let barb = |side: f64| {
        [
            to[0] - 0.2 * along[0] + side * 0.1 * along[1],
            to[1] - 0.2 * along[1] - side * 0.1 * along[0],
        ]
    };
    vec![from, to, barb(1.0), to, barb(-1.0)]
}
