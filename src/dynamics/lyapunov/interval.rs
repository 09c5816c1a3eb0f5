//! How sure a mean growth is: 95 % intervals from growth by batches.
//!
//! The growth of most directions wanders about its trend as a random walk does, and the mean over
//! batches that are long enough is as good as a mean of independent numbers: Student's interval holds
//! (G. S. Fishman, Discrete-Event Simulation, 2001, Chapter 6). The growth of a neutral direction
//! stays within bounds for ever. Its error is that of the two ends alone, at most the range seen over
//! the time.

use super::batches::Part;

/// Parts of the time that the range of a neutral direction's growth is judged by.
const PARTS: usize = 16;

/// A random walk's range over sixteen parts of a time is four times that over one part, and less
/// than twice in one walk of a hundred; a range that is bounded is about the same.
const BOUNDED: f64 = 2.0;

/// Fewer batches tell nothing of the error.
const FEWEST: usize = 8;

/// The range of a growth that stays within bounds; `None` for one that does not.
///
/// A direction that is neutral is told from one that grows or shrinks only as far as its trend stands
/// out of its range.
pub(super) fn bounded(batches: &[Part]) -> Option<f64> {
    let join = |parts: &[Part]| parts.iter().copied().fold(Part::default(), Part::then);
    let length = batches.len() / PARTS;
    if length == 0 {
        return None;
    }
    let parts = batches.chunks_exact(length);
    let count = parts.len() as f64;
    let mean = parts.map(|part| join(part).range()).sum::<f64>() / count;
    let range = join(batches).range();
    (range.is_finite() && range <= BOUNDED * mean).then_some(range)
}

/// Half the width of the 95 % interval of the mean growth by batch, infinite where it is unknown. It
/// reaches at least to the mean of the later half: where a transient is still in the growth (vectors
/// that turn slowly to directions whose rates are alike), no scatter tells of it. Without one, the
/// two means differ as much as the mean errs, and the interval is hardly ever widened.
pub(super) fn independent(growth: &[f64]) -> f64 {
    scatter(growth).max(drift(growth))
}

/// How far the mean of the later half is from the mean of all.
fn drift(growth: &[f64]) -> f64 {
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    (mean(&growth[growth.len() / 2..]) - mean(growth)).abs()
}

/// Student's interval, from batches long enough to be independent: 16 to 31 of
/// them, or half as many where neighbours still go together. Where they do so even then, the
/// interval is widened by what the correlation adds to the variance of a mean.
fn scatter(growth: &[f64]) -> f64 {
    if growth.len() < FEWEST || growth.iter().any(|x| !x.is_finite()) {
        return f64::INFINITY;
    }
    let mut merged = growth.to_vec();
    let mut length = 1.0;
    loop {
        let count = merged.len();
        let (variance, correlation) = moments(&merged);
        // By more than its own standard error, where there is none.
        let significant = correlation > 1.0 / (count as f64).sqrt();
        if count < 2 * FEWEST || (count < 4 * FEWEST && !significant) {
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

/// Variance, and correlation of neighbours.
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

/// The 97.5 % point of Student's distribution (M. Abramowitz and I. A. Stegun, Eq. 26.7.5), to 1e-3
/// from seven degrees of freedom on.
fn student(freedom: usize) -> f64 {
    let (n, z) = (freedom as f64, 1.959_963_984_540_054_f64);
    let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
    z + (z3 + z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n.powi(3))
}

#[cfg(test)]
#[path = "interval_tests.rs"]
mod tests;
