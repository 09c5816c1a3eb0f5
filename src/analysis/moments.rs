//! How far samples stray from their mean.

/// Standard deviation `sqrt(sum_n (x_n - mean)^2 / N)` of a population, in the samples' unit; NaN
/// without any.
pub fn deviation(samples: &[f64]) -> f64 {
    let mean_of = |sum: f64| sum / samples.len() as f64;
    let mean = mean_of(samples.iter().sum());
    mean_of(samples.iter().map(|x| (x - mean) * (x - mean)).sum()).sqrt()
}
