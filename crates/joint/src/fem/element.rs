//! The reference element: a quadrilateral of polynomial order `p` on the square `[-1, 1]^2`.
//!
//! The nodes are the tensor product of the `p + 1` Gauss-Lobatto points, which keeps Lagrange
//! interpolation well conditioned at every order. At order 1 they are the corners (bilinear element), at
//! order 2 the corners, edge midpoints and centre (nine-node element). Integration uses the Gauss rule
//! with `p + 1` points per direction, exact to degree `2 p + 1`. The mass of an undistorted element,
//! including the factor `r`, is integrated exactly.
//!
//! Points and weights: Abramowitz and Stegun, Handbook of Mathematical Functions, 1964, tables 25.4 and
//! 25.6; the tests verify them by their defining properties.

/// Maximum order of the Lagrange elements.
pub const MAX_ORDER: usize = 8;
/// Nodes along an edge at the maximum order.
const MAX_EDGE_NODES: usize = MAX_ORDER + 1;

/// Non-negative Gauss-Lobatto points in ascending order; row `p - 1` is for order `p`. They are the end
/// point and the roots of the derivative of the Legendre polynomial of degree `p`.
const LOBATTO: [&[f64]; MAX_ORDER] = [
    &[1.0],
    &[0.0, 1.0],
    &[0.447_213_595_499_957_9, 1.0],
    &[0.0, 0.654_653_670_707_977_1, 1.0],
    &[0.285_231_516_480_645_1, 0.765_055_323_929_464_7, 1.0],
    &[0.0, 0.468_848_793_470_714_23, 0.830_223_896_278_567, 1.0],
    &[
        0.209_299_217_902_478_88,
        0.591_700_181_433_142_3,
        0.871_740_148_509_606_6,
        1.0,
    ],
    &[
        0.0,
        0.363_117_463_826_178_16,
        0.677_186_279_510_737_7,
        0.899_757_995_411_460_2,
        1.0,
    ],
];

/// A point and its weight in a Gauss rule on `[-1, 1]`.
#[derive(Clone, Copy, Debug)]
struct GaussPoint {
    at: f64,
    weight: f64,
}

const fn gauss(at: f64, weight: f64) -> GaussPoint {
    GaussPoint { at, weight }
}

/// Non-negative Gauss points in ascending order; row `p - 1` has the rule with `p + 1` points.
const GAUSS: [&[GaussPoint]; MAX_ORDER] = [
    &[gauss(0.577_350_269_189_625_7, 1.0)],
    &[
        gauss(0.0, 0.888_888_888_888_888_8),
        gauss(0.774_596_669_241_483_4, 0.555_555_555_555_555_6),
    ],
    &[
        gauss(0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        gauss(0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ],
    &[
        gauss(0.0, 0.568_888_888_888_888_9),
        gauss(0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        gauss(0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ],
    &[
        gauss(0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
        gauss(0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        gauss(0.932_469_514_203_152, 0.171_324_492_379_170_36),
    ],
    &[
        gauss(0.0, 0.417_959_183_673_469_4),
        gauss(0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
        gauss(0.741_531_185_599_394_5, 0.279_705_391_489_276_64),
        gauss(0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
    ],
    &[
        gauss(0.183_434_642_495_649_8, 0.362_683_783_378_362),
        gauss(0.525_532_409_916_329, 0.313_706_645_877_887_27),
        gauss(0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
        gauss(0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
    ],
    &[
        gauss(0.0, 0.330_239_355_001_259_8),
        gauss(0.324_253_423_403_808_9, 0.312_347_077_040_002_86),
        gauss(0.613_371_432_700_590_4, 0.260_610_696_402_935_44),
        gauss(0.836_031_107_326_635_8, 0.180_648_160_694_857_4),
        gauss(0.968_160_239_507_626_1, 0.081_274_388_361_574_41),
    ],
];

/// The Gauss rule of an order, with points in ascending order.
fn gauss_rule(order: usize) -> Vec<GaussPoint> {
    let half = GAUSS[order - 1];
    let mirrored = half.iter().rev().filter(|point| point.at > 0.0);
    mirrored
        .map(|&GaussPoint { at, weight }| gauss(-at, weight))
        .chain(half.iter().copied())
        .collect()
}

/// The nodes along an edge and their Lagrange polynomials.
#[derive(Clone, Debug)]
pub struct EdgeNodes {
    points: Vec<f64>,
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
        let half = LOBATTO[order - 1];
        let mirrored = half.iter().rev().filter(|point| **point > 0.0);
        Self {
            points: mirrored.map(|x| -x).chain(half.iter().copied()).collect(),
        }
    }

    /// Positions of the nodes in `[-1, 1]`, ascending.
    pub fn points(&self) -> &[f64] {
        &self.points
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.points.len()
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

/// The Gauss points of an element of the given order, with tabulated shape functions.
pub fn quadrature(order: usize) -> Vec<QuadraturePoint> {
    let rule = gauss_rule(order);
    let edge = EdgeNodes::of_order(order);
    let mut points = Vec::with_capacity(rule.len() * rule.len());
    for vertical in &rule {
        let eta = edge.basis(vertical.at);
        for horizontal in &rule {
            let xi = edge.basis(horizontal.at);
            let tensor = |a: &[f64], b: &[f64]| -> Vec<f64> {
                let rows = b[..edge.len()].iter();
                rows.flat_map(|row| a[..edge.len()].iter().map(move |column| column * row))
                    .collect()
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
    fn gauss_rules_are_exact_to_exactly_their_degree() {
        for order in 1..=MAX_ORDER {
            let exact_to = 2 * order as i32 + 1;
            for power in 0..=exact_to + 1 {
                let rule = gauss_rule(order);
                let sum: f64 = rule.iter().map(|p| p.weight * p.at.powi(power)).sum();
                let exact = if power % 2 == 0 {
                    2.0 / f64::from(power + 1)
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
            assert_eq!(edge.len(), order + 1);
            assert_eq!([edge.points()[0], edge.points()[order]], [-1.0, 1.0]);
            for &x in &edge.points()[1..order] {
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
                    let nodal = edge.points().iter().map(|&at| polynomial(at));
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
            for (i, &at) in edge.points().iter().enumerate() {
                let value = edge.basis(at).value;
                for (j, v) in value[..edge.len()].iter().enumerate() {
                    let exact = if i == j { 1.0 } else { 0.0 };
                    assert!((v - exact).abs() < 1e-15, "order {order}: {v}");
                }
            }
        }
    }
}
