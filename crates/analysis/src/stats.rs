//! Statistics that several analyses use: range, moments and order statistics of samples; means and a line of a stream
//! in bounded memory.

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

/// Least-squares line through equally spaced values: its slope per step, and the sum of squares of the residuals.
pub fn trend(values: &[f64]) -> [f64; 2] {
    let (n, mean) = (values.len() as f64, mean(values));
    let places = || (0..values.len()).map(|k| k as f64 - 0.5 * (n - 1.0));
    let product: f64 = places().zip(values).map(|(x, y)| x * y).sum();
    let slope = product * 12.0 / (n * (n * n - 1.0));
    let off = places().zip(values).map(|(x, y)| y - mean - slope * x);
    [slope, off.map(|off| off * off).sum()]
}

/// The largest of the `count` smallest values, or of all if there are fewer; 0 without any.
pub(crate) fn order_statistic(mut values: Vec<f64>, count: usize) -> f64 {
    let last = count.min(values.len()).checked_sub(1);
    last.map_or(0.0, |last| {
        *values.select_nth_unstable_by(last, f64::total_cmp).1
    })
}

/// The median of values, of an even number the upper one; 0 without any.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let middle = values.len() / 2 + 1;
    order_statistic(values, middle)
}

/// Maximum number of blocks. When it is reached, blocks are merged in pairs.
const MAX_BLOCKS: usize = 128;

/// Means of several quantities over successive blocks of equal length. When the storage is full, adjacent
/// blocks are merged: after the first 64 blocks there are always 64 to 128, for any length of the stream.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockMeans {
    width: usize,
    /// Means of each full block, block by block.
    full: Vec<f64>,
    /// Sums of the incomplete block, and its entries so far.
    sums: Vec<f64>,
    entries: usize,
    /// Entries per block.
    length: usize,
}

impl BlockMeans {
    /// Creates blocks of one entry, for `width` quantities.
    pub fn new(width: usize) -> Self {
        Self {
            width,
            full: Vec::new(),
            sums: vec![0.0; width],
            entries: 0,
            length: 1,
        }
    }

    /// Adds an entry: one value of each quantity.
    ///
    /// # Panics
    /// If the number of values differs from the width.
    pub fn push(&mut self, values: &[f64]) {
        assert_eq!(values.len(), self.width, "values per entry");
        if self.count() == MAX_BLOCKS {
            self.merge();
        }
        for (sum, x) in self.sums.iter_mut().zip(values) {
            *sum += x;
        }
        self.entries += 1;
        if self.entries == self.length {
            let length = self.length as f64;
            self.full.extend(self.sums.iter().map(|sum| sum / length));
            self.sums.fill(0.0);
            self.entries = 0;
        }
    }

    /// Number of full blocks.
    pub fn count(&self) -> usize {
        self.full.len() / self.width
    }

    /// Entries per block.
    pub fn length(&self) -> usize {
        self.length
    }

    /// The means of a quantity in all full blocks.
    pub fn channel(&self, quantity: usize) -> Vec<f64> {
        let blocks = self.full.chunks_exact(self.width);
        blocks.map(|block| block[quantity]).collect()
    }

    /// Merges adjacent blocks. Their number is even, and no block is incomplete.
    fn merge(&mut self) {
        let pairs = self.full.chunks_exact(2 * self.width);
        let merged = pairs.flat_map(|pair| {
            let (one, other) = pair.split_at(self.width);
            one.iter().zip(other).map(|(a, b)| 0.5 * (a + b))
        });
        self.full = merged.collect();
        self.length *= 2;
    }
}

/// Minimum number of blocks for a line.
const MIN_FITTED: usize = 8;

/// Least-squares line through a stream of points with evenly spaced abscissas, of which [`BlockMeans`] are kept.
#[derive(Clone, Debug)]
pub struct LineFit {
    points: BlockMeans,
    /// First abscissa.
    from: Option<f64>,
}

impl Default for LineFit {
    fn default() -> Self {
        Self {
            points: BlockMeans::new(2),
            from: None,
        }
    }
}

/// A least-squares line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Slope.
    pub slope: f64,
    /// Half-width of the 95 % confidence interval of the slope.
    pub half_width: f64,
    /// Ordinate at abscissa 0.
    pub intercept: f64,
    /// First abscissa.
    pub from: f64,
}

impl LineFit {
    /// Removes all points.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Adds a point.
    pub fn push(&mut self, x: f64, y: f64) {
        self.from.get_or_insert(x);
        self.points.push(&[x, y]);
    }

    /// Fits the line. The error of the slope follows from the scatter about the line, widened by the
    /// correlation of neighbouring residuals. `None` for fewer than eight points.
    pub fn fit(&self) -> Option<Fit> {
        let from = self.from.filter(|_| self.points.count() >= MIN_FITTED)?;
        let [x, y] = [0, 1].map(|c| self.points.channel(c));
        let [x_mean, y_mean] = [&x, &y].map(|values| mean(values));
        let about = || x.iter().zip(&y).map(|(x, y)| [x - x_mean, y - y_mean]);
        let spread: f64 = about().map(|[x, _]| x * x).sum();
        let slope = about().map(|[x, y]| x * y).sum::<f64>() / spread;
        let off: Vec<f64> = about().map(|[x, y]| y - slope * x).collect();
        let squares: f64 = off.iter().map(|r| r * r).sum();
        let together: f64 = off.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let correlation = if squares > 0.0 {
            (together / squares).clamp(0.0, 0.9)
        } else {
            0.0
        };
        let widened = (1.0 + correlation) / (1.0 - correlation);
        let error = (squares / (off.len() as f64 - 2.0) / spread * widened).sqrt();
        Some(Fit {
            slope,
            half_width: 2.0 * error,
            intercept: y_mean - slope * x_mean,
            from,
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn the_fit_is_exact_for_any_number_of_points() {
        for count in [8, 100, 128, 129, 1000, 12_345] {
            let mut line = LineFit::default();
            for k in 0..count {
                let x = 2.0 + 0.5 * f64::from(k);
                assert_eq!(line.fit().is_some(), line.points.count() >= MIN_FITTED);
                line.push(x, 3.0 - 0.25 * x);
            }
            let fit = line.fit().unwrap();
            assert!((fit.slope + 0.25).abs() < 1e-12, "{count}: {fit:?}");
            assert!((fit.intercept - 3.0).abs() < 1e-9 && fit.half_width < 1e-9);
            assert_eq!(fit.from, 2.0);
            assert!(line.points.count() <= MAX_BLOCKS);
        }
    }

    #[test]
    fn the_interval_contains_the_slope_in_about_95_percent_of_runs() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut inside = 0;
        for _ in 0..1000 {
            let mut line = LineFit::default();
            let mut noise = 0.0;
            for k in 0..100 {
                let random: f64 = StandardNormal.sample(&mut rng);
                // Correlate neighbouring samples.
                noise = 0.5 * noise + random;
                line.push(f64::from(k), 0.1 * f64::from(k) + noise);
            }
            let fit = line.fit().unwrap();
            inside += u32::from((fit.slope - 0.1).abs() <= fit.half_width);
        }
        assert!((900..=980).contains(&inside), "{inside}");
    }
}
