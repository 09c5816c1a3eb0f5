//! Mode shapes along the free surface, interpolated by the shape functions of the elements.
//!
//! The meridian of the surface is a chain of element edges. A point on it is located in two steps: the
//! edge by bisection in a monotonic coordinate (the polar angle on the ball, the height on the beam),
//! and the position on the edge by inverting the isoparametric map. The surface is that of the elements:
//! at order 1 the ball is a stack of cones, and a direction intersects their chords.

use super::MeridianMode;
use super::bodies::BallOnBeam;
use super::element::{EdgeBasis, EdgeNodes};

/// A point of a meridian: an edge and its shape functions at the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgePoint {
    edge: usize,
    basis: EdgeBasis,
}

/// Positions and amplitudes of all modes at the nodes of a chain of edges, in the order of access.
#[derive(Clone, Debug)]
pub(super) struct ShapeTable {
    edge: EdgeNodes,
    /// `(r, z)` of the nodes: edge by edge.
    positions: Vec<[f64; 2]>,
    /// `[U, V, W]` of the nodes: edge by edge, then field by field.
    amplitudes: Vec<[f64; 3]>,
    fields: usize,
}

impl ShapeTable {
    fn new(chain: &[usize], mesh: &BallOnBeam, fields: &[MeridianMode]) -> Self {
        let order = mesh.section.order;
        let mut table = Self {
            edge: EdgeNodes::of_order(order),
            positions: Vec::new(),
            amplitudes: Vec::new(),
            fields: fields.len(),
        };
        for start in (0..chain.len() - 1).step_by(order) {
            let nodes = &chain[start..=start + order];
            let positions = nodes.iter().map(|&n| mesh.section.nodes[n]);
            table.positions.extend(positions);
            for field in fields {
                let amplitudes = nodes.iter().map(|&n| field.amplitudes[n]);
                table.amplitudes.extend(amplitudes);
            }
        }
        table
    }

    /// Amplitudes `[U, V, W]` of one field, 1/sqrt(kg).
    pub(super) fn amplitudes(&self, point: &EdgePoint, field: usize) -> [f64; 3] {
        let nodes = self.edge.len();
        let start = (point.edge * self.fields + field) * nodes;
        interpolate(&point.basis.value, &self.amplitudes[start..start + nodes])
    }

    /// Position `(r, z)`, m.
    pub(super) fn position(&self, point: &EdgePoint) -> [f64; 2] {
        interpolate(&point.basis.value, self.nodes_of(point.edge))
    }

    /// Positions `(r, z)` of the nodes of an edge, m.
    fn nodes_of(&self, edge: usize) -> &[[f64; 2]] {
        let nodes = self.edge.len();
        &self.positions[edge * nodes..][..nodes]
    }

    /// Boundaries of the edges in a coordinate of `(r, z)`.
    fn boundaries(&self, coordinate: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let last = self.positions.last().copied();
        self.positions
            .iter()
            .step_by(self.edge.len())
            .copied()
            .chain(last)
            .map(coordinate)
            .collect()
    }
}

/// Sum of the nodal values weighted by the shape functions; extra entries of `basis` are ignored.
fn interpolate<const N: usize>(basis: &[f64], nodal: &[[f64; N]]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (weight, value) in basis.iter().zip(nodal) {
        for (s, v) in sum.iter_mut().zip(value) {
            *s += weight * v;
        }
    }
    sum
}

/// Newton's method ends after a correction smaller than this: the next one would be about its square,
/// which is below rounding.
const CORRECTION_TOLERANCE: f64 = 1e-8;
/// Maximum number of corrections; four are sufficient on the coarsest meshes.
const MAX_CORRECTIONS: usize = 8;

/// Tolerance (rad) for directions beyond the corner, for rounding errors.
const ANGLE_TOLERANCE: f64 = 1e-12;

/// The free surface of the ball, parametrised by the polar angle (rad) from the north pole, or that of the beam, by the
/// height (m).
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) table: ShapeTable,
    is_ball: bool,
    /// Parameters of the boundaries of the edges.
    boundaries: Vec<f64>,
}

impl Surface {
    /// The surface of the ball.
    pub(super) fn ball(mesh: &BallOnBeam, fields: &[MeridianMode]) -> Self {
        let table = ShapeTable::new(&mesh.ball, mesh, fields);
        Self {
            is_ball: true,
            boundaries: table.boundaries(|[r, z]| r.atan2(z)),
            table,
        }
    }

    /// The lateral surface of the beam.
    pub(super) fn side(mesh: &BallOnBeam, fields: &[MeridianMode]) -> Self {
        let table = ShapeTable::new(&mesh.side, mesh, fields);
        Self {
            is_ball: false,
            boundaries: table.boundaries(|[_, z]| z),
            table,
        }
    }

    /// The parameter at the corner between ball and beam, where both surfaces end.
    pub(super) fn limit(&self) -> f64 {
        self.boundaries[self.boundaries.len() - 1]
    }

    /// The point of the ball at a polar angle (rad); `None` if the beam is there.
    pub(super) fn locate(&self, polar: f64) -> Option<EdgePoint> {
        (0.0..=self.limit() + ANGLE_TOLERANCE)
            .contains(&polar)
            .then(|| self.point(polar))
    }

    /// The point at a fraction of the distance to the corner, from the pole or from the free end.
    pub(super) fn at_fraction(&self, fraction: f64) -> EdgePoint {
        let first = self.boundaries[0];
        self.point(first + fraction * (self.limit() - first))
    }

    fn point(&self, parameter: f64) -> EdgePoint {
        let boundaries = &self.boundaries;
        let edge = boundaries[1..boundaries.len() - 1].partition_point(|&b| b <= parameter);
        let [low, high] = [boundaries[edge], boundaries[edge + 1]];
        let mut xi = 2.0 * (parameter - low) / (high - low) - 1.0;
        let mut basis = self.table.edge.basis(xi);
        if !self.is_ball {
            // Straight edges are mapped linearly.
            return EdgePoint { edge, basis };
        }
        let nodes = self.table.nodes_of(edge);
        let (sin, cos) = parameter.sin_cos();
        // Nodes are placed at their fractions of the angle. The initial guess differs only by the error
        // of the polynomial approximation of the arc (at order 4, 1e-5 for a third of a radian);
        // Newton's method squares that.
        for _ in 0..MAX_CORRECTIONS {
            let [r, z] = interpolate(&basis.value, nodes);
            let [r_xi, z_xi] = interpolate(&basis.slope, nodes);
            let correction = (r * cos - z * sin) / (r_xi * cos - z_xi * sin);
            xi -= correction;
            basis = self.table.edge.basis(xi);
            if correction.abs() < CORRECTION_TOLERANCE {
                break;
            }
        }
        EdgePoint { edge, basis }
    }
}
