//! Mode shapes along the free surface, interpolated by the shape functions of the elements.
//!
//! The meridian of the surface is a chain of element edges. A point on it is located in two steps: the
//! edge by bisection in a monotonic coordinate (the polar angle on the ball, the height on the beam),
//! and the position on the edge by inverting the isoparametric map. The surface is that of the elements:
//! at order 1 the ball is a stack of cones, and a direction intersects their chords.

use super::Section;
use super::element::{EdgeBasis, EdgeNodes};

/// A point of a meridian: the nodes of an edge of the section and its shape functions at the point.
pub(super) struct SurfacePoint<'a> {
    nodes: &'a [usize],
    basis: EdgeBasis,
}

impl SurfacePoint<'_> {
    /// Interpolates a quantity that is given at the nodes of the section.
    pub(super) fn interpolate<const N: usize>(&self, nodal: &[[f64; N]]) -> [f64; N] {
        weighted(&self.basis.value, self.nodes, nodal)
    }
}

/// Sum of the values at some nodes weighted by the shape functions; extra weights are ignored.
fn weighted<const N: usize>(weights: &[f64], nodes: &[usize], nodal: &[[f64; N]]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (weight, &node) in weights.iter().zip(nodes) {
        for (s, v) in sum.iter_mut().zip(nodal[node]) {
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
    /// The nodes of the section from the pole or the free end to the corner.
    pub(super) nodes: Vec<usize>,
    is_ball: bool,
    edge: EdgeNodes,
    /// Parameters of the boundaries of the edges.
    boundaries: Vec<f64>,
}

impl Surface {
    /// The surface through these nodes of a section.
    pub(super) fn new(section: &Section, nodes: Vec<usize>, is_ball: bool) -> Self {
        let ends = nodes.iter().step_by(section.order);
        let parameter = |&node| {
            let [r, z]: [f64; 2] = section.nodes[node];
            if is_ball { r.atan2(z) } else { z }
        };
        Self {
            boundaries: ends.map(parameter).collect(),
            edge: EdgeNodes::of_order(section.order),
            nodes,
            is_ball,
        }
    }

    /// The parameter at the corner between ball and beam, where both surfaces end.
    pub(super) fn limit(&self) -> f64 {
        self.boundaries[self.boundaries.len() - 1]
    }

    /// The point of the ball at a polar angle (rad); `None` if the beam is there.
    pub(super) fn locate(&self, section: &Section, polar: f64) -> Option<SurfacePoint<'_>> {
        (0.0..=self.limit() + ANGLE_TOLERANCE)
            .contains(&polar)
            .then(|| self.point(section, polar))
    }

    /// The point at a fraction of the distance to the corner, from the pole or from the free end.
    pub(super) fn at_fraction(&self, section: &Section, fraction: f64) -> SurfacePoint<'_> {
        let first = self.boundaries[0];
        self.point(section, first + fraction * (self.limit() - first))
    }

    fn point(&self, section: &Section, parameter: f64) -> SurfacePoint<'_> {
        let boundaries = &self.boundaries;
        let edge = boundaries[1..boundaries.len() - 1].partition_point(|&b| b <= parameter);
        let nodes = &self.nodes[edge * section.order..=(edge + 1) * section.order];
        let [low, high] = [boundaries[edge], boundaries[edge + 1]];
        let mut xi = 2.0 * (parameter - low) / (high - low) - 1.0;
        let mut basis = self.edge.basis(xi);
        if !self.is_ball {
            // Straight edges are mapped linearly.
            return SurfacePoint { nodes, basis };
        }
        let (sin, cos) = parameter.sin_cos();
        // Nodes are placed at their fractions of the angle. The initial guess differs only by the error
        // of the polynomial approximation of the arc (at order 4, 1e-5 for a third of a radian);
        // Newton's method squares that.
        for _ in 0..MAX_CORRECTIONS {
            let [r, z] = weighted(&basis.value, nodes, &section.nodes);
            let [r_xi, z_xi] = weighted(&basis.slope, nodes, &section.nodes);
            let correction = (r * cos - z * sin) / (r_xi * cos - z_xi * sin);
            xi -= correction;
            basis = self.edge.basis(xi);
            if correction.abs() < CORRECTION_TOLERANCE {
                break;
            }
        }
        SurfacePoint { nodes, basis }
    }
}
