//! How far samples stray: their range, and their deviation from the mean.

/// The smallest and the largest of some values, in their unit; infinity and minus infinity without
/// any.
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let wider = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
    values.into_iter().fold(none, wider)
}

/// Standard deviation `sqrt(sum_n (x_n - mean)^2 / N)` of a population, in the samples' unit; NaN
/// without any.
pub fn deviation(samples: &[f64]) -> f64 {
    let mean_of = |sum: f64| sum / samples.len() as f64;
    let mean = mean_of(samples.iter().sum());
    mean_of(samples.iter().map(|x| (x - mean) * (x - mean)).sum()).sqrt()
}
