//! The reference element: a quadrilateral of degree 4 on the square `[-1, 1]^2`.
//!
//! Nodes are the tensor product of the five Gauss-Lobatto points, which keeps Lagrange
//! interpolation well conditioned; integration is by the 5 x 5 Gauss rule, exact to degree 9 in
//! each direction, so that the mass of an undistorted element is integrated exactly, the factor
//! `r` included. For smooth modes the frequency error falls like `h^8`.

/// Polynomial degree along an edge.
pub const DEGREE: usize = 4;
/// Nodes along an edge.
pub const EDGE_NODES: usize = DEGREE + 1;
/// Nodes of an element; node `(i, j)` has the index `j * EDGE_NODES + i`.
pub const ELEMENT_NODES: usize = EDGE_NODES * EDGE_NODES;

/// The Gauss-Lobatto points of degree 4: the ends and the roots `0, +-sqrt(3/7)` of `P_4'`.
pub const EDGE_POINTS: [f64; EDGE_NODES] = [
    -1.0,
    -0.654_653_670_707_977_1,
    0.0,
    0.654_653_670_707_977_1,
    1.0,
];

/// The Lagrange polynomials of an edge and their derivatives, at one point.
#[derive(Clone, Copy, Debug)]
pub struct EdgeBasis {
    /// Values `N_i(xi)`.
    pub value: [f64; EDGE_NODES],
    /// Derivatives `dN_i / dxi`.
    pub slope: [f64; EDGE_NODES],
}

impl EdgeBasis {
    /// Evaluates them at `xi` in `[-1, 1]`.
    pub fn at(xi: f64) -> Self {
        let mut basis = Self {
            value: [1.0; EDGE_NODES],
            slope: [0.0; EDGE_NODES],
        };
        for (i, &own) in EDGE_POINTS.iter().enumerate() {
            for (j, &other) in EDGE_POINTS.iter().enumerate() {
                if i != j {
                    let gap = (own - other).recip();
                    let factor = (xi - other) * gap;
                    basis.slope[i] = basis.slope[i] * factor + basis.value[i] * gap;
                    basis.value[i] *= factor;
                }
            }
        }
        basis
    }
}

/// The shape functions at one quadrature point of the reference square.
#[derive(Clone, Debug)]
pub struct QuadraturePoint {
    /// Weight of the point; all weights sum to 4.
    pub weight: f64,
    /// Shape functions.
    pub value: [f64; ELEMENT_NODES],
    /// Derivatives along the first local coordinate.
    pub d_xi: [f64; ELEMENT_NODES],
    /// Derivatives along the second local coordinate.
    pub d_eta: [f64; ELEMENT_NODES],
}

/// A point and weight of the five-point Gauss rule on `[-1, 1]`.
struct GaussPoint {
    at: f64,
    weight: f64,
}

fn gauss_rule() -> [GaussPoint; EDGE_NODES] {
    let root = (10.0_f64 / 7.0).sqrt();
    let point = |sign: f64, branch: f64| GaussPoint {
        at: sign * (5.0 + branch * 2.0 * root).sqrt() / 3.0,
        weight: (322.0 - branch * 13.0 * 70.0_f64.sqrt()) / 900.0,
    };
    let middle = GaussPoint {
        at: 0.0,
        weight: 128.0 / 225.0,
    };
    [
        point(-1.0, 1.0),
        point(-1.0, -1.0),
        middle,
        point(1.0, -1.0),
        point(1.0, 1.0),
    ]
}

/// The 5 x 5 Gauss points with the shape functions tabulated.
pub fn quadrature() -> Vec<QuadraturePoint> {
    let rule = gauss_rule();
    let mut points = Vec::with_capacity(ELEMENT_NODES);
    for vertical in &rule {
        let eta = EdgeBasis::at(vertical.at);
        for horizontal in &rule {
            let xi = EdgeBasis::at(horizontal.at);
            let tensor = |a: &[f64; EDGE_NODES], b: &[f64; EDGE_NODES]| {
                std::array::from_fn(|node| a[node % EDGE_NODES] * b[node / EDGE_NODES])
            };
            points.push(QuadraturePoint {
                weight: horizontal.weight * vertical.weight,
                value: tensor(&xi.value, &eta.value),
                d_xi: tensor(&xi.slope, &eta.value),
                d_eta: tensor(&xi.value, &eta.slope),
            });
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gauss_rule_is_exact_to_degree_nine_and_no_further() {
        for power in 0..=10 {
            let sum: f64 = gauss_rule()
                .iter()
                .map(|p| p.weight * p.at.powi(power))
                .sum();
            let exact = if power % 2 == 0 {
                2.0 / f64::from(power + 1)
            } else {
                0.0
            };
            let error = (sum - exact).abs();
            assert_eq!(error < 1e-14, power <= 9, "degree {power}: error {error:e}");
        }
    }

    #[test]
    fn the_basis_reproduces_quartics_and_their_slopes() {
        let quartic = |x: f64| 2.0 - x + 3.0 * x.powi(3) - 0.7 * x.powi(4);
        let slope = |x: f64| -1.0 + 9.0 * x.powi(2) - 2.8 * x.powi(3);
        for x in [-1.0, -0.83, 0.0, 0.4, 1.0] {
            let basis = EdgeBasis::at(x);
            let sum = |weights: &[f64; EDGE_NODES]| -> f64 {
                weights
                    .iter()
                    .zip(EDGE_POINTS)
                    .map(|(w, at)| w * quartic(at))
                    .sum()
            };
            assert!((sum(&basis.value) - quartic(x)).abs() < 1e-14);
            assert!((sum(&basis.slope) - slope(x)).abs() < 1e-13);
        }
    }

    #[test]
    fn the_inner_points_are_the_roots_of_the_derivative_of_legendres_polynomial() {
        // P_4' = (140 x^3 - 60 x) / 8.
        for x in &EDGE_POINTS[1..DEGREE] {
            assert!((140.0 * x.powi(3) - 60.0 * x).abs() < 1e-13);
        }
    }

    #[test]
    fn the_basis_is_one_at_its_own_node_and_zero_at_the_others() {
        for (i, at) in EDGE_POINTS.into_iter().enumerate() {
            let value = EdgeBasis::at(at).value;
            for (j, v) in value.into_iter().enumerate() {
                assert_eq!(v, if i == j { 1.0 } else { 0.0 });
            }
        }
    }
}
