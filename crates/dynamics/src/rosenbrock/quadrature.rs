//! First-order components that no other equation depends on, integrated along the dense output of the
//! rest.
//!
//! The Jacobian omits them, so the implicit method cannot integrate them. They are integrals of
//! functions of time. The Lobatto rule of order 6 (M. Abramowitz and I. A. Stegun, Handbook of
//! Mathematical Functions, 1964, 25.4.32) uses the integrand at both ends of the step, which is known,
//! and at two points between them, which costs two evaluations. The cubic through the four values
//! provides the dense output.

use crate::error_control::sharpened;

/// Nodes of the rule: the ends and `(1 -+ 1 / sqrt 5) / 2`.
pub(super) const NODES: [f64; 4] = [0.0, 0.276_393_202_250_021, 0.723_606_797_749_979, 1.0];

const SQRT_5: f64 = 2.236_067_977_499_79;

/// Third difference of the integrand: the difference between this rule and one of order 3.
const FINE: [f64; 4] = [-1.0 / 12.0, SQRT_5 / 12.0, -SQRT_5 / 12.0, 1.0 / 12.0];

/// Error estimate of the rule from the integrand at the nodes, divided by the length of the step. The
/// third difference decreases too slowly with the step for a rule of order 6. It is combined with the
/// first difference, as in DOP853.
pub(super) fn error(integrand: [f64; 4]) -> f64 {
    let fine: f64 = FINE.iter().zip(integrand).map(|(e, g)| e * g).sum();
    sharpened(fine, (integrand[3] - integrand[0]) / 12.0)
}

/// Weights of the integrand at the nodes for the integral from the start to `theta`.
pub(super) fn weights(theta: f64) -> [f64; 4] {
    let inner = |other: f64| {
        let bracket = 0.5 * other - theta * ((1.0 + other) / 3.0 - 0.25 * theta);
        5.0 * SQRT_5 * theta * theta * bracket
    };
    [
        theta * (1.0 - theta * (3.0 - theta * (10.0 / 3.0 - 1.25 * theta))),
        inner(NODES[2]),
        -inner(NODES[1]),
        theta * theta * (0.5 - theta * (5.0 / 3.0 - 1.25 * theta)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_to_its_degree() {
        let integral = |theta: f64, power: i32| -> f64 {
            let terms = weights(theta).into_iter().zip(NODES);
            terms.map(|(b, c)| b * c.powi(power)).sum()
        };
        for power in 0..=5 {
            let exact = 1.0 / f64::from(power + 1);
            assert!((integral(1.0, power) - exact).abs() < 1e-15, "{power}");
        }
        assert!((integral(1.0, 6) - 1.0 / 7.0).abs() > 1e-4);
        for power in 0..=3 {
            let exact = 0.3_f64.powi(power + 1) / f64::from(power + 1);
            assert!((integral(0.3, power) - exact).abs() < 1e-15, "{power}");
        }
        let integrand = |power: i32| NODES.map(|c| c.powi(power));
        assert!((0..=2).all(|power| error(integrand(power)).abs() < 1e-30));
        assert!(error(integrand(3)) > 1e-3);
        assert!(error([f64::NAN, 0.0, 0.0, 0.0]).is_nan());
    }
}
