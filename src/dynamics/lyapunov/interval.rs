//! How sure a mean growth is: 95 % intervals from growth by batches.
//!
//! The growth of a chaotic direction wanders about its trend as a random walk does, and the mean
//! over batches that are long enough is as good as a mean of independent numbers: Student's
//! interval holds (G. S. Fishman, Discrete-Event Simulation, 2001, Chapter 6). The growth of a
//! direction that is neutral, or that a cycle or a torus contracts, stays near its trend for ever;
//! batch means then are anti-correlated, and the error is that of the two ends alone.

/// Below this, Watson's statistic is that of a walk that stays near its trend, not that of a random
/// walk: the lower 1 % point of its limit distribution (G. S. Watson, Biometrika 48 (1961) 109-114).
const BOUNDED: f64 = 0.0197;

/// Fewer batches tell nothing of the error.
const FEWEST: usize = 8;

/// How the growth of a vector goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Course {
    /// As a random walk about its trend.
    Random,
    /// Within bounds about its trend.
    Bounded,
}

/// Half the width of an interval, and on what it rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    /// Half the width of the 95 % interval of the mean growth by batch; infinite where it is unknown.
    pub half_width: f64,
    /// The course of the growth.
    pub course: Course,
}

/// The 95 % interval of the mean of the growth by batch.
pub(super) fn spread(growth: &[f64]) -> Spread {
    if growth.len() < FEWEST {
        return Spread {
            half_width: f64::INFINITY,
            course: Course::Random,
        };
    }
    let count = growth.len() as f64;
    let (variance, _) = moments(growth);
    let walk = Walk::of(growth);
    let watson = walk.variance / (count * variance);
    // An even growth has nothing but rounding errors to judge.
    if variance == 0.0 || watson < BOUNDED {
        return Spread {
            half_width: walk.range / count,
            course: Course::Bounded,
        };
    }
    Spread {
        half_width: independent(growth),
        course: Course::Random,
    }
}

/// Half the width of Student's interval, from batches long enough to be independent: 16 to 31 of
/// them, or half as many where neighbours still go together. Where they do so even then, the
/// interval is widened by what the correlation adds to the variance of a mean.
fn independent(growth: &[f64]) -> f64 {
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

/// The sum of a growth about its trend, at the batches' borders.
struct Walk {
    /// Its largest less its smallest value.
    range: f64,
    /// Its mean square about its mean.
    variance: f64,
}

impl Walk {
    fn of(growth: &[f64]) -> Self {
        let count = growth.len() as f64;
        let trend = growth.iter().sum::<f64>() / count;
        let (mut place, mut low, mut high) = (0.0_f64, 0.0_f64, 0.0_f64);
        let (mut sum, mut squares) = (0.0, 0.0);
        for x in growth {
            place += x - trend;
            low = low.min(place);
            high = high.max(place);
            sum += place;
            squares += place * place;
        }
        Self {
            range: high - low,
            variance: squares / count - (sum / count).powi(2),
        }
    }
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
