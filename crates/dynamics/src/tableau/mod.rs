//! Coefficients of the explicit Runge–Kutta methods.
//!
//! A method of `S` stages advances `y' = g(t, y)` by
//!
//! ```text
//! k_i = g(t + c_i h, y + h sum_j a_ij k_j)        i = 1 .. S,  j < i
//! y(t + theta h) = y + h sum_i b_i(theta) k_i     0 <= theta <= 1
//! ```
//!
//! All methods have the first-same-as-last (FSAL) property: the last stage of the step is evaluated at
//! the solution (`c = 1`, `a = b`), and its slope is the first slope of the next step. Later stages
//! serve dense output only and are evaluated on demand.

mod dop853;

pub(super) use dop853::DOP853;

use super::error_control::MethodTraits;

/// The most stages of a method.
pub(super) const MAX_STAGES: usize = 16;

/// Coefficients of a method in first-same-as-last form.
#[derive(Debug)]
pub(super) struct Tableau {
    /// Nodes `c_i`.
    pub nodes: &'static [f64],
    /// Index of the stage at the end of the step; later stages serve dense output only.
    pub end: usize,
    /// Weights `a_ij` of each stage, at least those below the diagonal; row `end` contains the weights `b_j` of the
    /// solution.
    pub stages: &'static [&'static [f64]],
    /// Difference between the weights of the solution and those of an embedded method of lower order;
    /// zero in a method without error estimate.
    pub error: &'static [f64],
    /// The same for a second embedded method of still lower order, if there is one. With the norms `e`
    /// and `f` of the two estimates, the error is `e^2 / sqrt(e^2 + (f / 10)^2)`.
    pub coarse_error: Option<&'static [f64]>,
    /// Dense output: `b_i(theta) = sum_k dense[k][i] theta^(k + 1)`.
    pub dense: &'static [&'static [f64]],
    /// Properties used by step control and event location.
    pub traits: MethodTraits,
}

impl Tableau {
    /// Weights `b_i(theta)` of the dense output; zero beyond the last stage.
    pub fn weights(&self, theta: f64) -> [f64; MAX_STAGES] {
        let mut weights = [0.0; MAX_STAGES];
        for power in self.dense.iter().rev() {
            for (weight, coefficient) in weights.iter_mut().zip(*power) {
                *weight = (*weight + coefficient) * theta;
            }
        }
        weights
    }
}

/// Properties of pairs of order 5(4), with the constants of DOPRI5.
pub(super) const TRAITS_54: MethodTraits = MethodTraits {
    gain: [0.17, 0.04, 0.2],
    pieces: 1,
    is_stiff: false,
};

/// The pair of order 5(4) with dense output of order 4 from the same stages: C. Tsitouras,
/// Runge–Kutta pairs of order 5(4) satisfying only the first column simplifying assumption,
/// Comput. Math. Appl. 62 (2011) 770–775, Table 1 and its interpolant.
#[rustfmt::skip] // One row of the table to a line.
pub(super) static TSIT5: Tableau = Tableau {
    nodes: &[0.0, 0.161, 0.327, 0.9, 0.980_025_540_904_509_7, 1.0, 1.0],
    end: 6,
    stages: &[
        &[],
        &[0.161],
        &[-0.008_480_655_492_356_989, 0.335_480_655_492_357],
        &[2.897_153_057_105_493_5, -6.359_448_489_975_075, 4.362_295_432_869_581_5],
        &[5.325_864_828_439_257, -11.748_883_564_062_828, 7.495_539_342_889_836_5, -0.092_495_066_361_755_25],
        &[
            5.861_455_442_946_42, -12.920_969_317_847_11, 8.159_367_898_576_159, -0.071_584_973_281_401,
            -0.028_269_050_394_068_383,
        ],
        &[
            0.096_460_766_818_065_23, 0.01, 0.479_889_650_414_499_6, 1.379_008_574_103_742,
            -3.290_069_515_436_081, 2.324_710_524_099_774,
        ],
    ],
    error: &[
        -0.001_780_011_052_225_777, -0.000_816_434_459_656_746_9, 0.007_880_878_010_261_995,
        -0.144_711_007_173_262_9, 0.582_357_165_452_555_2, -0.458_082_105_929_186_97, 1.0 / 66.0,
    ],
    coarse_error: None,
    dense: &[
        &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        &[
            -2.763_706_197_274_826, 0.1317, 3.930_296_236_894_751_6, -12.411_077_166_933_676,
            37.509_313_416_511_04, -27.896_526_289_197_286, 1.5,
        ],
        &[
            2.913_255_461_821_912_6, -0.2234, -5.941_033_872_131_505, 30.338_188_630_282_32,
            -88.178_904_894_766_4, 65.091_894_674_793_66, -4.0,
        ],
        &[
            -1.053_088_497_729_021_6, 0.1017, 2.490_627_285_651_253, -16.548_102_889_244_902,
            47.379_521_962_819_28, -34.870_657_861_496_61, 2.5,
        ],
    ],
    traits: TRAITS_54,
};

/// The classical method of order 4 (W. Kutta, Z. Math. Phys. 46 (1901) 435–453). The dense output is the
/// cubic Hermite polynomial through both ends of the step, with error `O(h^4)`, like the global error of
/// the method.
#[rustfmt::skip] // One row of the table to a line.
pub(super) static RK4: Tableau = Tableau {
    nodes: &[0.0, 0.5, 0.5, 1.0, 1.0],
    end: 4,
    stages: &[&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0], &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0]],
    error: &[0.0; 5],
    coarse_error: None,
    dense: &[
        &[1.0, 0.0, 0.0, 0.0, 0.0],
        &[-1.5, 1.0, 1.0, 0.5, -1.0],
        &[2.0 / 3.0, -2.0 / 3.0, -2.0 / 3.0, -1.0 / 3.0, 1.0],
    ],
    traits: TRAITS_54,
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of the order conditions for a weight vector `b`, each with its order. The right-hand
    /// sides are `1 / gamma` (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd
    /// ed., Table II.2.1: the rooted trees with up to five vertices).
    fn residuals(tableau: &Tableau, b: &[f64], theta: f64) -> Vec<(usize, f64)> {
        let mut c = [0.0; MAX_STAGES];
        c[..tableau.nodes.len()].copy_from_slice(tableau.nodes);
        let one = [1.0; MAX_STAGES];
        let times = |x: [f64; MAX_STAGES], y: [f64; MAX_STAGES]| {
            std::array::from_fn::<f64, MAX_STAGES, _>(|i| x[i] * y[i])
        };
        let sum = |x: [f64; MAX_STAGES]| {
            let mut sums = [0.0; MAX_STAGES];
            for (sum, row) in sums.iter_mut().zip(tableau.stages) {
                *sum = row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>();
            }
            sums
        };
        let c2 = times(c, c);
        let c3 = times(c2, c);
        let (ac, ac2) = (sum(c), sum(c2));
        [
            (1, one, 1.0),
            (2, c, 2.0),
            (3, c2, 3.0),
            (3, ac, 6.0),
            (4, c3, 4.0),
            (4, times(c, ac), 8.0),
            (4, ac2, 12.0),
            (4, sum(ac), 24.0),
            (5, times(c3, c), 5.0),
            (5, times(c2, ac), 10.0),
            (5, times(c, ac2), 15.0),
            (5, times(c, sum(ac)), 30.0),
            (5, times(ac, ac), 20.0),
            (5, sum(c3), 20.0),
            (5, sum(times(c, ac)), 40.0),
            (5, sum(ac2), 60.0),
            (5, sum(sum(ac)), 120.0),
        ]
        .into_iter()
        .map(|(order, elementary, gamma)| {
            let left: f64 = b.iter().zip(&elementary).map(|(b, e)| b * e).sum();
            (order, (left - theta.powi(order as i32) / gamma).abs())
        })
        .collect()
    }

    /// Largest residual of the conditions up to `order`.
    fn worst(tableau: &Tableau, b: &[f64], theta: f64, order: usize) -> f64 {
        let all = residuals(tableau, b, theta);
        all.iter()
            .filter(|(o, _)| *o <= order)
            .fold(0.0, |worst, (_, r)| r.max(worst))
    }

    /// `a - b`, where rows end at their last non-zero element.
    fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
        let at = |row: &[f64], i: usize| row.get(i).copied().unwrap_or(0.0);
        (0..MAX_STAGES).map(|i| at(a, i) - at(b, i)).collect()
    }

    fn assert_consistent(tableau: &Tableau) {
        for (i, row) in tableau.stages.iter().enumerate() {
            let size = row.iter().fold(1.0_f64, |max, a| max.max(a.abs()));
            assert!(
                (row.iter().sum::<f64>() - tableau.nodes[i]).abs() < 1e-15 * size,
                "row {i}"
            );
            assert!(
                row.iter().skip(i).all(|&a| a == 0.0),
                "row {i} is not explicit"
            );
        }
        assert_eq!(tableau.nodes[tableau.end], 1.0);
        for (i, (at_end, b)) in tableau
            .weights(1.0)
            .iter()
            .zip(tableau.stages[tableau.end])
            .enumerate()
        {
            assert!(
                (at_end - b).abs() < 1e-13,
                "dense output differs from the solution in weight {i}"
            );
        }
    }

    #[test]
    fn rows_sum_to_nodes_and_the_last_stage_is_the_solution() {
        assert_consistent(&TSIT5);
        assert_consistent(&RK4);
        assert_consistent(&DOP853);
    }

    #[test]
    fn tsit5_has_order_five_with_an_embedded_method_of_order_four() {
        let b = TSIT5.stages[TSIT5.end];
        assert!(
            worst(&TSIT5, b, 1.0, 5) < 2e-15,
            "{:?}",
            residuals(&TSIT5, b, 1.0)
        );
        let embedded = difference(b, TSIT5.error);
        assert!(worst(&TSIT5, &embedded, 1.0, 4) < 2e-15);
        assert!(
            worst(&TSIT5, &embedded, 1.0, 5) > 1e-5,
            "an embedded method of order five gives no error estimate"
        );
    }

    #[test]
    fn tsit5_dense_output_has_order_four() {
        for k in 0..=20 {
            let theta = f64::from(k) / 20.0;
            assert!(
                worst(&TSIT5, &TSIT5.weights(theta), theta, 4) < 1e-13,
                "theta = {theta}"
            );
        }
        assert!(worst(&TSIT5, &TSIT5.weights(0.5), 0.5, 5) > 1e-6);
    }

    #[test]
    fn dop853_satisfies_the_order_conditions_with_embedded_orders_five_and_three() {
        let b = DOP853.stages[DOP853.end];
        assert!(worst(&DOP853, b, 1.0, 5) < 1e-13);
        // Conditions of order up to 8 for a method with stage order 3 from its sixth stage on, and the
        // quadrature conditions.
        let quadrature = |order: i32| {
            let moments = b
                .iter()
                .zip(DOP853.nodes)
                .map(|(b, c)| b * c.powi(order - 1));
            (moments.sum::<f64>() - 1.0 / f64::from(order)).abs()
        };
        assert!((1..=8).all(|order| quadrature(order) < 1e-14));
        assert!(quadrature(9) > 1e-6);
        for (error, order) in [(DOP853.error, 5), (DOP853.coarse_error.unwrap(), 3)] {
            let embedded = difference(b, error);
            assert!(worst(&DOP853, &embedded, 1.0, order) < 1e-13);
            assert!(error.iter().any(|e| e.abs() > 1e-3));
        }
        for k in 0..=20 {
            let theta = f64::from(k) / 20.0;
            let weights = DOP853.weights(theta);
            assert!(
                worst(&DOP853, &weights, theta, 5) < 1e-12,
                "theta = {theta}"
            );
        }
    }

    #[test]
    fn rk4_has_order_four_with_dense_output_of_order_three() {
        let b = RK4.stages[RK4.end];
        assert!(worst(&RK4, b, 1.0, 4) < 1e-15);
        assert!(worst(&RK4, b, 1.0, 5) > 1e-3);
        for k in 0..=20 {
            let theta = f64::from(k) / 20.0;
            assert!(
                worst(&RK4, &RK4.weights(theta), theta, 3) < 1e-15,
                "theta = {theta}"
            );
        }
    }
}
