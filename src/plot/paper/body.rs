//! Fig. 1 and 2: ball and beam, contact patch, mode shapes.

use crate::fem::{ModeKind, SurfaceMesh};
use crate::joint::{AssemblyError, BallJoint, Model};
use crate::plot::{Axis, Color, Figure, Layer, Panel};

/// Numbers of rings and of meridians of the wireframe.
const ALONG: usize = 40;
const ROUND: usize = 16;

/// Largest drawn displacement of a mode shape, m.
const LARGEST: f64 = 15e-3;
/// The same for torsion, which would distort the beam at the larger value.
const LARGEST_TORSION: f64 = 7e-3;

/// Projection onto the page: an oblique view with the beam axis vertical.
const VIEW: [[f64; 3]; 2] = [[0.866, -0.5, 0.0], [0.12, 0.21, 0.97]];

/// Fig. 1: configuration at a tilt (rad), and pre-stress on the contact patch.
///
/// # Errors
/// [`AssemblyError`] if the modes come from a file, so the geometry of the body is unknown.
pub fn configuration(ball: &BallJoint, model: &Model, tilt: f64) -> Result<Figure, AssemblyError> {
    let mesh = ball.body()?.outline(ALONG, ROUND);
    let radius = ball.ball_radius();
    let direction = ball.direction(tilt);
    let scaled = |v: [f64; 3], by: f64| v.map(|x| by * x);
    // The load presses the ball against the socket along `direction`, from outside.
    let ends = [3.4, 1.05].map(|by| place(scaled(direction, by * radius)));
    let newtons = ball.spec().load;
    let load = Layer::line(arrow(ends), Color::Accent).with_label(format!("load {newtons} N"));
    let rotation = ball.spec().rotation;
    let size = rotation.iter().map(|w| w * w).sum::<f64>().sqrt();
    let tip = scaled(rotation, 2.6 * radius / size.max(f64::MIN_POSITIVE));
    let turning = Layer::line(arrow([[0.0; 3], tip].map(place)), Color::Series(0))
        .with_label(format!("rotation {size:.3} rad/s"));
    let configuration = Panel::new(
        format!("load tilted by {:.1}°", tilt.to_degrees()),
        Axis::linear("mm", [-105.0, 105.0]),
        Axis::linear("mm", [-225.0, 65.0]),
        vec![
            wires(&mesh, Color::Ink, |_, at| at),
            load.with_size(1.6),
            turning.with_size(1.6),
        ],
    );
    let title = "Fig. 1: configuration, and pre-stress on the contact patch";
    let row = vec![configuration, pre_stress(ball, model, direction)];
    Ok(Figure::new("figure-1", title, 112.0, vec![row]))
}

/// Pre-stress of the contact nodes over the distance from the centre of the patch, compared with Hertz.
fn pre_stress(ball: &BallJoint, model: &Model, direction: [f64; 3]) -> Panel {
    let distance = |position: &[f64; 3]| {
        let along: f64 = position.iter().zip(direction).map(|(a, b)| a * b).sum();
        let square: f64 = position.iter().map(|x| x * x).sum();
        (square - along * along).max(0.0).sqrt()
    };
    let nodes = model.positions.iter().zip(&model.pre_stress);
    let nodes = nodes.map(|(position, p)| [1e3 * distance(position), 1e-6 * p]);
    let radius = ball.patch_radius();
    // Hertz: the mean pressure is two thirds of the pressure at the centre.
    let middle = 1.5 * ball.spec().load / (std::f64::consts::PI * radius * radius);
    let curve = (0..=200).map(|k| {
        let s = f64::from(k) / 200.0;
        let pressure = middle * (1.0 - s * s).max(0.0).sqrt();
        [1e3 * radius * s, 1e-6 * pressure]
    });
    Panel::new(
        format!("pre-stress on the patch, up to {:.2} MPa", 1e-6 * middle),
        Axis::linear("distance from the centre, mm", [0.0, 1.05e3 * radius]),
        Axis::linear("pre-stress, MPa", [0.0, 1.1e-6 * middle]),
        vec![
            Layer::line(curve.collect(), Color::Faint).with_label("Hertz"),
            Layer::points(nodes.collect(), 1.8, Color::Accent)
                .with_label(format!("{} contact nodes", model.nodes())),
        ],
    )
}

/// Fig. 2: mode shapes, one of each bending pair, drawn over the undeformed body.
///
/// # Errors
/// [`AssemblyError`] if the modes come from a file, so the geometry of the body is unknown.
pub fn mode_shapes(ball: &BallJoint) -> Result<Figure, AssemblyError> {
    let body = ball.body()?;
    let mesh = body.outline(ALONG, ROUND);
    let panel = |title: String, layers| {
        let x = Axis::linear("mm", [-60.0, 60.0]);
        Panel::new(title, x, Axis::linear("mm", [-230.0, 45.0]), layers)
    };
    let rest = wires(&mesh, Color::Ink, |_, at| at);
    let mut panels = vec![panel("undeformed".to_owned(), vec![rest])];
    for (mode, name) in body.families() {
        let shape = |vertex| mesh.shapes_at(vertex)[mode];
        let size = |vertex| shape(vertex).iter().map(|x| x * x).sum::<f64>();
        let sizes = (0..mesh.vertices.len()).map(size);
        let largest = sizes.fold(f64::MIN_POSITIVE, f64::max).sqrt();
        let (color, drawn) = match body.modes()[mode].kind {
            ModeKind::BendingX | ModeKind::BendingY => (Color::Series(0), LARGEST),
            ModeKind::Torsion => (Color::Series(2), LARGEST_TORSION),
            ModeKind::Axial => (Color::Series(3), LARGEST),
        };
        let moved = wires(&mesh, color, |vertex, at| {
            std::array::from_fn(|i| at[i] + drawn / largest * shape(vertex)[i])
        });
        let title = format!("{name}, {:.0} Hz", ball.frequencies_hz()[mode]);
        let rest = wires(&mesh, Color::Pale, |_, at| at);
        panels.push(panel(title, vec![rest, moved]));
    }
    let title = "Fig. 2: mode shapes";
    Ok(Figure::grid("figure-2", title, 78.0, 4, &panels))
}

/// Rings and meridians of the surface, with each vertex displaced by `moved`.
fn wires(mesh: &SurfaceMesh, color: Color, moved: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> Layer {
    let at = |ring: usize, j: usize| {
        let vertex = 1 + ring * ROUND + j % ROUND;
        place(moved(vertex, mesh.vertices[vertex]))
    };
    let rings = (0..ALONG).step_by(3);
    let rings = rings.map(|ring| (0..=ROUND).map(|j| at(ring, j)).collect());
    let meridians = (0..ROUND).step_by(2);
    let meridians = meridians.map(|j| (0..ALONG).map(|ring| at(ring, j)).collect());
    Layer::lines(rings.chain(meridians).collect(), color).with_size(0.5)
}

/// Projection of a point in space (m) onto the page (mm).
fn place(at: [f64; 3]) -> [f64; 2] {
    VIEW.map(|axis| 1e3 * axis.iter().zip(at).map(|(a, b)| a * b).sum::<f64>())
}

/// An arrow as a polyline.
fn arrow([from, to]: [[f64; 2]; 2]) -> Vec<[f64; 2]> {
    let along = [to[0] - from[0], to[1] - from[1]];
    let barb = |side: f64| {
        [
            to[0] - 0.2 * along[0] + side * 0.1 * along[1],
            to[1] - 0.2 * along[1] - side * 0.1 * along[0],
        ]
    };
    vec![from, to, barb(1.0), to, barb(-1.0)]
}
