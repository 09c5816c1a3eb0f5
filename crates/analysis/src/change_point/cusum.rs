//! The self-normalised CUSUM statistic of a change of the mean.

use crate::stats::mean;

/// The maximum of `T(k)^2 / V(k)` over all `k` with at least `min` values on each side.
///
/// `T(k)` is the CUSUM `n^-1/2 sum_{t <= k} (x_t - mean)`, and `V(k)` is `n^-2` times the sum of squares of
/// the partial sums within each side about the side's own mean, forwards before `k` and backwards after
/// it. The unknown long-run variance cancels. If one side is shorter than a quarter, `V(k)` is also estimated
/// from the other alone, scaled by its length, and the smaller value counts: a short side may still drift,
/// for example while a motion settles. Zero for fewer than `2 min` values or for a constant series.
pub(super) fn cusum(values: &[f64], min: usize) -> f64 {
    let n = values.len();
    let mean = mean(values);
    let mut sums = vec![0.0];
    for x in values {
        sums.push(sums[sums.len() - 1] + (x - mean));
    }
    let before = bridges(&sums);
    // Backwards the partial sums are minus the remaining ones, because the whole sum is zero.
    let reversed: Vec<f64> = sums.iter().rev().map(|sum| -sum).collect();
    let after = bridges(&reversed);
    let scale = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    // Rounding of a constant series is no scatter.
    let least = (1e-12 * scale).powi(2).max(f64::MIN_POSITIVE);
    let ratio = |k: usize| {
        let (one, other) = (before[k], after[n - k]);
        let (longer, length) = if 2 * k > n { (one, k) } else { (other, n - k) };
        let mut squares = one + other;
        if 4 * length > 3 * n {
            squares = squares.min(longer * (n as f64 / length as f64).powi(2));
        }
        sums[k] * sums[k] * n as f64 / squares.max(least)
    };
    (min..=n.saturating_sub(min)).map(ratio).fold(0.0, f64::max)
}

/// For each `k`, the sum over `t <= k` of `(s_t - t/k s_k)^2`.
fn bridges(sums: &[f64]) -> Vec<f64> {
    let (mut squares, mut products, mut times) = (0.0, 0.0, 0.0);
    let bridge = |(k, sum): (usize, &f64)| {
        let t = k as f64;
        squares += sum * sum;
        products += t * sum;
        times += t * t;
        let slope = if k == 0 { 0.0 } else { sum / t };
        squares - 2.0 * slope * products + slope * slope * times
    };
    sums.iter().enumerate().map(bridge).collect()
}
