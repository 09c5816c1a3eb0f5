//! From the share of belief to the probability of a right verdict.
//!
//! The rule of Dempster assumes independent evidence, so that its shares are no probabilities. On signals of known
//! regime the probability of a right verdict is close to a logistic function of the logarithm of the odds of the
//! share (J. Platt, in *Advances in Large Margin Classifiers*, MIT Press 2000). Its two parameters are fitted by
//! maximum likelihood, with Platt's correction for their finite number, to textbook signals
//! (`test_signals/textbook.rs`, numbers from `CALIBRATION` on; the test
//! `the_confidence_is_fitted_to_its_signals` repeats the fit). Verdicts on signals of one family are not
//! independent: for a new family the rule of succession limits the probability to `(n + 1) / (n + 2)` after `n`
//! families, which is the factor [`LIMIT`]. Limits and weights were chosen with other signals, and reliability is
//! judged with others again, among them families used for neither.

/// Probability of a right verdict at equal odds, as the logarithm of its odds, and its slope.
const PARAMETERS: [f64; 2] = [0.78, 2.31];

/// Limit of the confidence: the rule of succession for the 24 families of the calibration.
const LIMIT: f64 = 25.0 / 26.0;

/// Largest logarithm of the odds of a share that is distinguished.
pub(super) const MAX_ODDS: f64 = 6.0;

/// Estimated probability that a verdict with this share of all belief is right.
pub(super) fn confidence(share: f64) -> f64 {
    LIMIT * logistic(PARAMETERS, share)
}

/// `1 / (1 + exp(-a - b ln(share / (1 - share))))`.
pub(super) fn logistic([a, b]: [f64; 2], share: f64) -> f64 {
    let odds = (share / (1.0 - share)).ln().clamp(-MAX_ODDS, MAX_ODDS);
    1.0 / (1.0 + (-a - b * odds).exp())
}

#[cfg(test)]
pub(super) mod fitting {
    use super::*;

    /// Logarithm of the odds of the share that has this confidence.
    pub fn odds(confidence: f64) -> f64 {
        let [a, b] = PARAMETERS;
        let p = confidence / LIMIT;
        (((p / (1.0 - p)).ln() - a) / b).clamp(-MAX_ODDS, MAX_ODDS)
    }

    /// Share with these odds.
    pub fn share(odds: f64) -> f64 {
        1.0 / (1.0 + (-odds).exp())
    }

    /// Maximum-likelihood parameters for verdicts with these logarithms of odds, by Newton's method.
    pub fn parameters(verdicts: &[(f64, bool)]) -> [f64; 2] {
        let right = verdicts.iter().filter(|(_, right)| *right).count() as f64;
        let wrong = verdicts.len() as f64 - right;
        let target = |is_right| match is_right {
            true => (right + 1.0) / (right + 2.0),
            false => 1.0 / (wrong + 2.0),
        };
        let mut parameters = [0.0, 1.0];
        for _ in 0..50 {
            let (mut gradient, mut curvature) = ([0.0; 2], [[1e-9, 0.0], [0.0, 1e-9]]);
            for (odds, is_right) in verdicts {
                let x = [1.0, *odds];
                let p = logistic(parameters, share(*odds));
                for r in 0..2 {
                    gradient[r] += x[r] * (target(*is_right) - p);
                    for c in 0..2 {
                        curvature[r][c] += x[r] * x[c] * p * (1.0 - p);
                    }
                }
            }
            let [[a, b], [c, d]] = curvature;
            let determinant = a * d - b * c;
            parameters[0] += (d * gradient[0] - b * gradient[1]) / determinant;
            parameters[1] += (a * gradient[1] - c * gradient[0]) / determinant;
        }
        parameters
    }

    pub const FITTED: [f64; 2] = PARAMETERS;
}
