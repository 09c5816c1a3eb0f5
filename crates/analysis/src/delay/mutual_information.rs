//! Average mutual information: how much the signal now determines the signal one lag later.
//!
//! Each coordinate of a delay vector should add information. At the first minimum of the mutual
//! information between the signal and its delayed copy, the second coordinate is most independent before
//! the two become unrelated (A. M. Fraser and H. L. Swinney, Phys. Rev. A 33, 1134, 1986). Unlike the
//! autocorrelation it includes nonlinear dependence.

use schemars::JsonSchema;
use serde::Serialize;

use rayon::prelude::*;

use super::LagReason;
use crate::{AnalysisError, stats::range};

/// Maximum number of bins per axis.
const MAX_BINS: usize = 1024;

/// Counts below this value take `c log2 c` from a table.
const TABLE_SIZE: u32 = 4096;

/// Average mutual information of `x[n]` and `x[n + lag]` by lag.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MutualInformation {
    /// Bins per axis of the joint histogram.
    pub bins: usize,
    /// `I(lag)` in bits for lag 0, 1, ..., the largest lag.
    pub bits: Vec<f64>,
}

impl MutualInformation {
    /// First clear minimum, samples: the first lag `l` with a value below all before that is not
    /// undercut up to lag `1.5 l`, rounded up, or up to `2 l` while more than half of `I(0)` remains.
    /// `None` if there is none within the computed lags.
    ///
    /// The bins cause a ripple on the slowly decreasing curve of a pure tone, with many local minima
    /// before the one near a quarter period. On a smooth curve the first minimum is also the first clear
    /// minimum.
    pub fn first_clear_minimum(&self) -> Option<usize> {
        let mut lowest = 0;
        for (lag, &bits) in self.bits.iter().enumerate() {
            let more_than_half_remains = 2.0 * self.bits[lowest] > self.bits[0];
            let stretch = if more_than_half_remains {
                lowest
            } else {
                lowest.div_ceil(2)
            };
            if bits < self.bits[lowest] {
                lowest = lag;
            } else if lowest > 0 && lag >= lowest + stretch {
                return Some(lowest);
            }
        }
        None
    }

    /// The lag of a delay vector, samples: the first clear minimum, else the first value below 1/e of that at lag 0, else
    /// the largest lag.
    pub fn lag(&self) -> (usize, LagReason) {
        if let Some(lag) = self.first_clear_minimum() {
            (lag, LagReason::FirstMinimum)
        } else if let Some(lag) = self.first_below((-1.0_f64).exp()) {
            (lag, LagReason::FirstDecay)
        } else {
            (self.bits.len() - 1, LagReason::Largest)
        }
    }

    /// First lag (samples) with a value below `share` of that at lag 0; `None` if there is none.
    pub fn first_below(&self, share: f64) -> Option<usize> {
        let limit = share * self.bits[0];
        self.bits.iter().position(|&bits| bits < limit)
    }
}

/// Average mutual information at the lags 0 to `largest_lag`, bits:
///
/// ```text
/// I(lag) = sum_ij p_ij log2(p_ij / (p_i p_j))
/// ```
///
/// `p_ij` is the share of the `N - lag` pairs `(x[n], x[n + lag])` in cell `(i, j)` of a histogram with
/// `bins` times `bins` cells of equal width over the range of the samples. `p_i` and `p_j` are its row
/// and column sums, from the same pairs. `I(0)` is therefore the entropy of the histogram: at most
/// `log2(bins)`, and never below `I(lag)` except for end effects. A constant signal has 0 at all lags.
///
/// For few samples the estimate is biased: independent samples give not 0 but about
/// `(b - 1)^2 / (2 (N - lag) ln 2)`, with `b` the number of occupied bins (G. A. Miller 1955).
///
/// Lags are distributed over all cores. The result does not depend on their number.
///
/// # Errors
/// [`AnalysisError::Bins`] unless `bins` is 2 to 1024; [`AnalysisError::TooShort`] if there is no pair
/// at the largest lag.
pub fn mutual_information(
    samples: &[f64],
    largest_lag: usize,
    bins: usize,
) -> Result<MutualInformation, AnalysisError> {
    if !(2..=MAX_BINS).contains(&bins) {
        return Err(AnalysisError::Bins {
            bins,
            most: MAX_BINS,
        });
    }
    AnalysisError::check_length("mutual information", samples.len(), largest_lag + 1)?;
    let binned = bin(samples, bins);
    let table: Vec<f64> = (0..TABLE_SIZE).map(count_log_count).collect();
    let at = |joint: &mut Vec<u32>, lag: usize| {
        count(&binned[..binned.len() - lag], &binned[lag..], bins, joint);
        bits(joint, bins, &table)
    };
    let bits = (0..=largest_lag)
        .into_par_iter()
        .map_init(|| vec![0; bins * bins], at)
        .collect();
    Ok(MutualInformation { bins, bits })
}

/// Bin of each sample, with `bins` bins of equal width from the minimum to the maximum.
fn bin(samples: &[f64], bins: usize) -> Vec<u16> {
    let [low, high] = range(samples.iter().copied());
    if low == high {
        return vec![0; samples.len()];
    }
    let last = (bins - 1) as u16;
    let place = |x: &f64| ((x - low) / (high - low) * bins as f64) as u16;
    samples.iter().map(|x| place(x).min(last)).collect()
}

/// Counts the pairs in each cell, row-major in the first of a pair.
///
/// Consecutive samples mostly fall into the same cell, where each increment has to wait for the previous
/// one. The pairs are therefore taken from four distant sections in turn.
fn count(now: &[u16], later: &[u16], bins: usize, joint: &mut [u32]) {
    joint.fill(0);
    let mut put = |now: u16, later: u16| joint[usize::from(now) * bins + usize::from(later)] += 1;
    let quarter = now.len() / 4;
    for n in 0..quarter {
        for section in 0..4 {
            let n = section * quarter + n;
            put(now[n], later[n]);
        }
    }
    for n in 4 * quarter..now.len() {
        put(now[n], later[n]);
    }
}

/// Mutual information of a joint histogram of counts. With counts `c` and their sum `N` it is
/// `(sum c_ij log c_ij - sum c_i log c_i - sum c_j log c_j) / N + log N`.
fn bits(joint: &[u32], bins: usize, table: &[f64]) -> f64 {
    let term = |count: u32| match table.get(count as usize) {
        Some(&term) => term,
        None => count_log_count(count),
    };
    let mut columns = vec![0; bins];
    let (mut pairs, mut sum) = (0, 0.0);
    for row in joint.chunks_exact(bins) {
        let in_row: u32 = row.iter().sum();
        if in_row == 0 {
            continue;
        }
        for (column, &cell) in columns.iter_mut().zip(row) {
            *column += cell;
        }
        sum += row.iter().map(|&cell| term(cell)).sum::<f64>() - term(in_row);
        pairs += in_row;
    }
    sum -= columns.iter().map(|&column| term(column)).sum::<f64>();
    let pairs = f64::from(pairs);
    // Rounding can make the result slightly negative.
    (sum / pairs + pairs.log2()).max(0.0)
}

/// `c log2 c`, 0 for 0.
fn count_log_count(count: u32) -> f64 {
    let c = f64::from(count.max(1));
    c * c.log2()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::LN_2;

    use super::*;
    use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};

    /// The definition, written out.
    fn direct(samples: &[f64], lag: usize, bins: usize) -> f64 {
        let binned = bin(samples, bins);
        let pairs: Vec<_> = binned.iter().zip(&binned[lag..]).collect();
        let share = |hit: &dyn Fn(usize, usize) -> bool| {
            let hits = pairs.iter().filter(|p| hit((*p.0).into(), (*p.1).into()));
            hits.count() as f64 / pairs.len() as f64
        };
        let mut information = 0.0;
        for i in 0..bins {
            for j in 0..bins {
                let p = share(&|a, b| a == i && b == j);
                if p > 0.0 {
                    let (row, column) = (share(&|a, _| a == i), share(&|_, b| b == j));
                    information += p * (p / (row * column)).log2();
                }
            }
        }
        information
    }

    #[test]
    fn two_alternating_values_give_one_bit() {
        let signal: Vec<f64> = (0..41).map(|n| f64::from(n % 2)).collect();
        let mutual = mutual_information(&signal, 4, 2).unwrap();
        // For even lags of an odd number of samples: 21 to 20, 20 to 19, ...
        let entropy = |p: f64| -p * p.log2() - (1.0 - p) * (1.0 - p).log2();
        for (lag, bits) in mutual.bits.iter().enumerate() {
            let pairs = 41 - lag;
            let zeros = pairs.div_ceil(2) as f64 / pairs as f64;
            assert!((bits - entropy(zeros)).abs() < 1e-14, "{lag}: {bits}");
        }
        assert_eq!(mutual.bits[1], 1.0);
    }

    #[test]
    fn counts_match_the_definition() {
        let signal = noise(1, 403, 1.0);
        let mutual = mutual_information(&signal, 6, 7).unwrap();
        for (lag, bits) in mutual.bits.iter().enumerate() {
            assert!((bits - direct(&signal, lag, 7)).abs() < 1e-13, "{lag}");
        }
    }

    #[test]
    fn at_lag_zero_it_is_the_entropy() {
        // Each of 64 values equally often.
        let signal: Vec<f64> = (0..6400).map(|n| f64::from(n * 37 % 64)).collect();
        let mutual = mutual_information(&signal, 0, 64).unwrap();
        assert!((mutual.bits[0] - 6.0).abs() < 1e-12);
    }

    #[test]
    fn independent_samples_give_the_expected_bias() {
        // Uniform distribution, which occupies all bins: the bias is (b - 1)^2 / (2 N ln 2), the
        // standard deviation (b - 1) / (sqrt(2) N ln 2).
        let (n, bins) = (50_000.0, 32.0);
        let uniform: Vec<f64> = noise(2, 100_000, 1.0)
            .chunks_exact(2)
            .map(|pair| pair[0].atan2(pair[1]))
            .collect();
        let mutual = mutual_information(&uniform, 20, 32).unwrap();
        let mean = mutual.bits[1..].iter().sum::<f64>() / 20.0;
        let bias = (bins - 1.0) * (bins - 1.0) / (2.0 * n * LN_2);
        let deviation = (bins - 1.0) / (2.0_f64.sqrt() * n * LN_2);
        let standard_error = deviation / 20.0_f64.sqrt();
        assert!((mean - bias).abs() < 4.0 * standard_error, "{mean} {bias}");
    }

    #[test]
    fn scale_does_not_change_the_information() {
        let signal = noise(3, 1000, 1.0);
        let other: Vec<f64> = signal.iter().map(|x| x * 2.0_f64.powi(-60)).collect();
        assert_eq!(
            mutual_information(&signal, 9, 16),
            mutual_information(&other, 9, 16)
        );
    }

    #[test]
    fn a_constant_signal_has_no_information() {
        let mutual = mutual_information(&[0.1; 300], 20, 64).unwrap();
        assert_eq!(mutual.bits, [0.0; 21]);
        assert_eq!(mutual.first_clear_minimum(), None);
        assert_eq!(mutual.first_below(0.5), None);
    }

    #[test]
    fn a_clear_minimum_holds_over_half_its_lag() {
        let first = |bits: &[f64]| {
            let bits = bits.to_vec();
            MutualInformation { bins: 2, bits }.first_clear_minimum()
        };
        // Less than half remains at lag 3: the minimum must hold up to lag 5.
        assert_eq!(first(&[9.0, 6.0, 5.0, 4.0, 4.0, 4.0, 3.0]), Some(3));
        assert_eq!(first(&[9.0, 6.0, 5.0, 4.0, 4.0]), None);
        // More than half remains: up to lag 6.
        assert_eq!(first(&[9.0, 8.0, 7.0, 6.0, 6.0, 6.0, 6.0]), Some(3));
        assert_eq!(first(&[9.0, 8.0, 7.0, 6.0, 6.0, 6.0, 5.0]), None);
        // Ripple on a decreasing curve.
        let rippled = [9.0, 7.0, 6.0, 8.0, 5.5, 6.0, 3.0, 5.0, 5.0, 5.0];
        assert_eq!(first(&rippled), Some(6));
        assert_eq!(first(&[3.0, 3.0, 4.0, 4.0]), None);
        assert_eq!(first(&[3.0]), None);
    }

    #[test]
    fn a_pure_tone_has_its_clear_minimum_about_a_quarter_period_away() {
        for period in [23.3, 40.5, 162.0, 311.7] {
            for (count, bins) in [(4000, 18), (20_000, 40)] {
                let signal = sines(period, count, &[(1.0, 1.0, 0.3)]);
                let mutual = mutual_information(&signal, 200, bins).unwrap();
                let lag = mutual.first_clear_minimum().unwrap() as f64;
                assert!((0.1..0.4).contains(&(lag / period)), "{period}, {lag}");
            }
        }
    }

    #[test]
    fn the_lorenz_system_has_its_first_minimum_at_lag_16() {
        for start in [[1.0, 1.0, 1.0], [-5.0, 3.0, 20.0], [0.1, 0.0, 0.0]] {
            let x = coordinate(&lorenz(50_000, 0.01, start), 0);
            let mutual = mutual_information(&x, 60, 64).unwrap();
            assert_eq!(mutual.first_clear_minimum(), Some(16));
        }
    }

    #[test]
    fn the_roessler_system_has_its_first_minimum_at_a_quarter_turn() {
        for start in [[1.0, 1.0, 0.0], [-3.0, 2.0, 0.1]] {
            let x = coordinate(&roessler(50_000, 0.1, [0.2, 0.2, 5.7], start), 0);
            let lag = mutual_information(&x, 60, 64)
                .unwrap()
                .first_clear_minimum();
            assert!((12..=16).contains(&lag.unwrap()), "{lag:?}");
        }
    }

    #[test]
    fn invalid_bins_and_lags_are_rejected() {
        let signal = sines(50.0, 20, &[(1.0, 1.0, 0.0)]);
        for bins in [0, 1, 1025] {
            let error = mutual_information(&signal, 5, bins).unwrap_err();
            assert_eq!(error, AnalysisError::Bins { bins, most: 1024 });
        }
        let error = mutual_information(&signal, 20, 8).unwrap_err();
        let (have, need) = (20, 21);
        let what = "mutual information";
        assert_eq!(error, AnalysisError::TooShort { what, have, need });
        assert!(mutual_information(&signal, 19, 1024).is_ok());
    }
}
