//! 95 % confidence intervals of a mean growth rate from growth in batches.
//!
//! In most directions the growth fluctuates about its trend like a random walk. The means over
//! sufficiently long batches are then independent, and Student's interval holds (G. S. Fishman,
//! Discrete-Event Simulation, 2001, Chapter 6). The growth of a neutral direction remains bounded. The
//! error of its rate comes only from the two ends: at most the observed range divided by the time.

use super::batches::GrowthInterval;

/// Number of parts of the time in which the range of the growth is compared with the total range.
const PARTS: usize = 16;

/// Maximum ratio of the total range to the mean range of the parts for a bounded growth. For a random
/// walk the range over sixteen parts is four times that of one part, and less than twice in one walk of
/// a hundred. For a bounded growth the two are about equal.
const MAX_BOUNDED_RATIO: f64 = 2.0;

/// Minimum number of batches for an error estimate.
const MIN_BATCHES: usize = 8;

/// The range of a growth that remains bounded; `None` if it does not.
///
/// A neutral direction is distinguished from a growing or decaying one only if the trend of the latter
/// exceeds its range.
pub(super) fn bounded_range(batches: &[GrowthInterval]) -> Option<f64> {
    let join = |parts: &[GrowthInterval]| {
        parts
            .iter()
            .copied()
            .fold(GrowthInterval::default(), GrowthInterval::then)
    };
    let length = batches.len() / PARTS;
    if length == 0 {
        return None;
    }
    let parts = batches.chunks_exact(length);
    let count = parts.len() as f64;
    let mean = parts.map(|part| join(part).range()).sum::<f64>() / count;
    let range = join(batches).range();
    (range.is_finite() && range <= MAX_BOUNDED_RATIO * mean).then_some(range)
}

/// Half-width of the 95 % interval of the mean growth per batch; infinite if unknown. The interval
/// reaches at least to the mean of the second half. A remaining transient (vectors that converge slowly
/// to directions with similar rates) is not visible in the scatter of the batches. Without a transient
/// the two means differ by about the standard error, and this rule hardly ever widens the interval.
pub(super) fn half_width(growth: &[f64]) -> f64 {
    student_half_width(growth).max(drift(growth))
}

/// Distance between the mean of the second half and the mean of all.
fn drift(growth: &[f64]) -> f64 {
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    (mean(&growth[growth.len() / 2..]) - mean(growth)).abs()
}

/// Student's interval from batches long enough to be independent: 16 to 31 of them, or half as many if
/// adjacent batches are still correlated. If they remain correlated, the interval is widened by the
/// contribution of the correlation to the variance of the mean.
fn student_half_width(growth: &[f64]) -> f64 {
    if growth.len() < MIN_BATCHES || growth.iter().any(|x| !x.is_finite()) {
        return f64::INFINITY;
    }
    let mut merged = growth.to_vec();
    let mut length = 1.0;
    loop {
        let count = merged.len();
        let (variance, correlation) = moments(&merged);
        // Significant if it exceeds the standard error of the correlation of independent values.
        let significant = correlation > 1.0 / (count as f64).sqrt();
        if count < 2 * MIN_BATCHES || (count < 4 * MIN_BATCHES && !significant) {
            let widened = if significant {
                1.0 + 2.0 * correlation
            } else {
                1.0
            };
            return student(count - 1) * (variance * widened / count as f64).sqrt() / length;
        }
        merged = merged
            .chunks_exact(2)
            .map(|pair| pair[0] + pair[1])
            .collect();
        length *= 2.0;
    }
}

/// Variance and lag-1 correlation.
fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let products = values
        .windows(2)
        .map(|pair| (pair[0] - mean) * (pair[1] - mean));
    let correlation = if squares > 0.0 {
        products.sum::<f64>() / squares
    } else {
        0.0
    };
    (squares / (count - 1.0), correlation)
}

/// The 97.5 % point of Student's t distribution (M. Abramowitz and I. A. Stegun, Eq. 26.7.5), accurate
/// to 1e-3 from seven degrees of freedom on.
pub fn student(degrees_of_freedom: usize) -> f64 {
    let (n, z) = (degrees_of_freedom as f64, 1.959_963_984_540_054_f64);
    let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
    z + (z3 + z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n.powi(3))
}

#[cfg(test)]
#[path = "interval_tests.rs"]
mod tests;
