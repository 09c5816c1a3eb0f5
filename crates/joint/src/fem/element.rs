//! The reference element: a quadrilateral of polynomial order `p` on the square `[-1, 1]^2`.
//!
//! The nodes are the tensor product of the `p + 1` Gauss-Lobatto points, which keeps Lagrange
//! interpolation well conditioned at every order. At order 1 they are the corners (bilinear element), at
//! order 2 the corners, edge midpoints and centre (nine-node element). Integration uses the Gauss rule
//! with `p + 1` points per direction, exact to degree `2 p + 1`. The mass of an undistorted element,
//! including the factor `r`, is integrated exactly.

use nalgebra::DMatrix;

/// Maximum order of the Lagrange elements.
pub const MAX_ORDER: usize = 8;
/// Nodes along an edge at the maximum order.
const MAX_EDGE_NODES: usize = MAX_ORDER + 1;

/// The `n`-point Gauss rule on `[-1, 1]` for a weight with the integral 1: points in ascending order with their weights. They
/// are the eigenvalues of the Jacobi matrix and the squared first components of its eigenvectors (Golub and Welsch, Math.
/// Comp. 23 (1969) 221). Its diagonal is given by an index from 0 on, the coupling with the row before from 1 on.
pub(crate) fn gauss_rule(
    n: usize,
    diagonal: impl Fn(f64) -> f64,
    coupling: impl Fn(f64) -> f64,
) -> Vec<[f64; 2]> {
    if n == 0 {
        return Vec::new();
    }
    let jacobi = DMatrix::from_fn(n, n, |row, column| {
        let k = row.max(column) as f64;
        match row.abs_diff(column) {
            0 => diagonal(k),
            1 => coupling(k),
            _ => 0.0,
        }
    });
    let eigen = jacobi.symmetric_eigen();
    let first = eigen.eigenvectors.row(0);
    let pairs = eigen.eigenvalues.iter().zip(first.iter());
    // One step of Newton's method for the characteristic polynomial removes the rounding errors of the eigenvalues.
    let improved = |t: f64| {
        let (mut value, mut slope) = ([1.0, 0.0], [0.0; 2]);
        for k in 0..n {
            let square = if k > 0 {
                coupling(k as f64).powi(2)
            } else {
                0.0
            };
            let factor = t - diagonal(k as f64);
            slope = [value[0] + factor * slope[0] - square * slope[1], slope[0]];
            value = [factor * value[0] - square * value[1], value[0]];
        }
        t - value[0] / slope[0]
    };
    let mut rule: Vec<_> = pairs
        .map(|(t, first)| [improved(*t), first * first])
        .collect();
    rule.sort_by(|a, b| a[0].total_cmp(&b[0]));
    rule
}

/// As [`gauss_rule`], for an even weight: points and weights are symmetric to the last bit.
fn symmetric_rule(n: usize, coupling: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let rule = gauss_rule(n, |_| 0.0, coupling);
    let mirrored = rule.iter().rev();
    let pairs = rule.iter().zip(mirrored);
    pairs
        .map(|([t, w], [u, v])| [0.5 * (t - u), 0.5 * (w + v)])
        .collect()
}

/// The nodes along an edge and their Lagrange polynomials.
#[derive(Clone, Debug)]
pub struct EdgeNodes {
    /// Positions of the nodes in `[-1, 1]`, ascending.
    pub points: Vec<f64>,
}

/// Values and derivatives of the Lagrange polynomials of an edge at one point. Entries beyond the nodes
/// of the edge are unused; the fixed array size avoids an allocation.
#[derive(Clone, Copy, Debug)]
pub struct EdgeBasis {
    /// Values `N_i(xi)`.
    pub value: [f64; MAX_EDGE_NODES],
    /// Derivatives `dN_i / dxi`.
    pub slope: [f64; MAX_EDGE_NODES],
}

impl EdgeNodes {
    /// Nodes of an order from 1 to [`MAX_ORDER`].
    pub fn of_order(order: usize) -> Self {
        // The inner points are the roots of the derivative of the Legendre polynomial, a Jacobi polynomial.
        let inner = symmetric_rule(order - 1, |k| {
            (k * (k + 2.0) / ((2.0 * k + 1.0) * (2.0 * k + 3.0))).sqrt()
        });
        let mut points = vec![-1.0];
        points.extend(inner.iter().map(|[t, _]| t));
        points.push(1.0);
        Self { points }
    }

    /// Evaluates the polynomials at `xi` in `[-1, 1]`.
    pub fn basis(&self, xi: f64) -> EdgeBasis {
        let mut basis = EdgeBasis {
            value: [1.0; MAX_EDGE_NODES],
            slope: [0.0; MAX_EDGE_NODES],
        };
        for (i, &own) in self.points.iter().enumerate() {
            for (j, &other) in self.points.iter().enumerate() {
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

/// The shape functions at one quadrature point of the reference square. Node `(i, j)` of an element,
/// counted along the first and the second local coordinate, has the index `j * (p + 1) + i`.
#[derive(Clone, Debug)]
pub struct QuadraturePoint {
    /// Weight of the point; all weights sum to 4.
    pub weight: f64,
    /// Shape functions.
    pub value: Vec<f64>,
    /// Derivatives along the first local coordinate.
    pub d_xi: Vec<f64>,
    /// Derivatives along the second local coordinate.
    pub d_eta: Vec<f64>,
}

/// The Gauss rule with `order + 1` points for a constant weight, 1/2.
fn legendre_rule(order: usize) -> Vec<[f64; 2]> {
    symmetric_rule(order + 1, |k| k / (4.0 * k * k - 1.0).sqrt())
}

/// The Gauss points of an element of the given order, with tabulated shape functions.
pub fn quadrature(order: usize) -> Vec<QuadraturePoint> {
    let rule = legendre_rule(order);
    let edge = EdgeNodes::of_order(order);
    let mut points = Vec::with_capacity(rule.len() * rule.len());
    for [y, height] in &rule {
        let eta = edge.basis(*y);
        for [x, width] in &rule {
            let xi = edge.basis(*x);
            let tensor = |a: &[f64], b: &[f64]| -> Vec<f64> {
                let [a, b] = [a, b].map(|basis| basis[..edge.points.len()].iter());
                b.flat_map(|row| a.clone().map(move |column| column * row))
                    .collect()
            };
            points.push(QuadraturePoint {
                weight: 4.0 * width * height,
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
    fn gauss_rules_are_exact_to_exactly_their_degree() {
        for order in 1..=MAX_ORDER {
            let exact_to = 2 * order as i32 + 1;
            for power in 0..=exact_to + 1 {
                let rule = legendre_rule(order);
                let sum: f64 = rule
                    .iter()
                    .map(|[at, weight]| weight * at.powi(power))
                    .sum();
                let exact = if power % 2 == 0 {
                    1.0 / f64::from(power + 1)
                } else {
                    0.0
                };
                let error = (sum - exact).abs();
                assert_eq!(
                    error < 2e-15,
                    power <= exact_to,
                    "order {order}, degree {power}: error {error:e}"
                );
            }
        }
    }

    #[test]
    fn inner_nodes_are_roots_of_the_derivative_of_the_legendre_polynomial() {
        for order in 1..=MAX_ORDER {
            let edge = EdgeNodes::of_order(order);
            assert_eq!(edge.points.len(), order + 1);
            assert_eq!([edge.points[0], edge.points[order]], [-1.0, 1.0]);
            for &x in &edge.points[1..order] {
                // (1 - x^2) P_p' = p (P_(p-1) - x P_p), with P_n from Bonnet's recursion.
                let (mut before, mut legendre) = (1.0, x);
                for n in 1..order {
                    let n = n as f64;
                    let next = ((2.0 * n + 1.0) * x * legendre - n * before) / (n + 1.0);
                    (before, legendre) = (legendre, next);
                }
                let residual = before - x * legendre;
                assert!(residual.abs() < 1e-15, "order {order}: {residual:e} at {x}");
            }
        }
    }

    #[test]
    fn the_basis_reproduces_polynomials_of_its_order_and_their_derivatives() {
        for order in 1..=MAX_ORDER {
            let edge = EdgeNodes::of_order(order);
            let power = order as i32;
            let polynomial = |x: f64| 2.0 - x + 0.7 * x.powi(power);
            let slope = |x: f64| -1.0 + 0.7 * f64::from(power) * x.powi(power - 1);
            for x in [-1.0, -0.83, 0.0, 0.4, 1.0] {
                let basis = edge.basis(x);
                let sum = |weights: &[f64]| -> f64 {
                    let nodal = edge.points.iter().map(|&at| polynomial(at));
                    weights.iter().zip(nodal).map(|(w, y)| w * y).sum()
                };
                assert!((sum(&basis.value) - polynomial(x)).abs() < 1e-14);
                assert!((sum(&basis.slope) - slope(x)).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn basis_functions_are_one_at_their_node_and_zero_at_the_others() {
        for order in 1..=MAX_ORDER {
            let edge = EdgeNodes::of_order(order);
            for (i, &at) in edge.points.iter().enumerate() {
                let value = edge.basis(at).value;
                for (j, v) in value[..edge.points.len()].iter().enumerate() {
                    let exact = if i == j { 1.0 } else { 0.0 };
                    assert!((v - exact).abs() < 1e-15, "order {order}: {v}");
                }
            }
        }
    }
}
