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
pub(super) const PARAMETERS: [f64; 2] = [0.78, 2.31];

/// Limit of the confidence: the rule of succession for the 24 families of the calibration.
pub(super) const LIMIT: f64 = 25.0 / 26.0;

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
