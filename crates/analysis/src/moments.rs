//! Range, mean and standard deviation of samples.

/// Minimum and maximum of the values, in their unit. Infinity and minus infinity for no values.
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let wider = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
    values.into_iter().fold(none, wider)
}

/// Mean of the samples, in their unit. NaN for no samples.
pub fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}

/// Population standard deviation `sqrt(sum_n (x_n - mean)^2 / N)`, in the samples' unit. NaN for no
/// samples.
pub fn deviation(samples: &[f64]) -> f64 {
    let mean = mean(samples);
    let squares: f64 = samples.iter().map(|x| (x - mean) * (x - mean)).sum();
    (squares / samples.len() as f64).sqrt()
}
