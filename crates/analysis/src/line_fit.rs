//! Least-squares line through a stream of points in bounded memory.

/// Maximum number of stored points.
const MAX_POINTS: usize = 128;

/// Minimum number of stored points for a fit.
const MIN_POINTS: usize = 8;

/// Least-squares line through a stream of points with evenly spaced abscissas. When the storage of 128
/// points is full, neighbouring points are merged into their mean.
#[derive(Clone, Debug, Default)]
pub struct LineFit {
    points: Vec<[f64; 2]>,
    /// Sum of the samples not yet merged into a stored point, and their number.
    pending_sum: [f64; 2],
    pending: usize,
    /// Samples per stored point, minus one. Zero until the first merge.
    merged: usize,
    /// First abscissa.
    from: Option<f64>,
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
        let mut points = std::mem::take(&mut self.points);
        points.clear();
        *self = Self {
            points,
            ..Self::default()
        };
    }

    /// Adds a point.
    pub fn push(&mut self, x: f64, y: f64) {
        self.from.get_or_insert(x);
        self.pending_sum[0] += x;
        self.pending_sum[1] += y;
        self.pending += 1;
        if self.pending <= self.merged {
            return;
        }
        if self.points.len() == MAX_POINTS {
            self.merge_pairs();
        }
        if self.pending > self.merged {
            let pending = self.pending as f64;
            self.points.push(self.pending_sum.map(|sum| sum / pending));
            (self.pending_sum, self.pending) = ([0.0; 2], 0);
        }
    }

    fn merge_pairs(&mut self) {
        let pairs = self.points.chunks_exact(2);
        let mean = |pair: &[[f64; 2]]| [0, 1].map(|c| 0.5 * (pair[0][c] + pair[1][c]));
        self.points = pairs.map(mean).collect();
        self.merged = 2 * self.merged + 1;
    }

    /// Fits the line. The error of the slope follows from the scatter about the line, widened by the
    /// correlation of neighbouring residuals. `None` for fewer than eight points.
    pub fn fit(&self) -> Option<Fit> {
        let count = self.points.len() as f64;
        let from = self.from.filter(|_| self.points.len() >= MIN_POINTS)?;
        let mean = [0, 1].map(|c| self.points.iter().map(|p| p[c]).sum::<f64>() / count);
        let about = self.points.iter().map(|p| [p[0] - mean[0], p[1] - mean[1]]);
        let spread: f64 = about.clone().map(|[x, _]| x * x).sum();
        let slope = about.clone().map(|[x, y]| x * y).sum::<f64>() / spread;
        let off: Vec<f64> = about.map(|[x, y]| y - slope * x).collect();
        let squares: f64 = off.iter().map(|r| r * r).sum();
        let together: f64 = off.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let correlation = if squares > 0.0 {
            (together / squares).clamp(0.0, 0.9)
        } else {
            0.0
        };
        let widened = (1.0 + correlation) / (1.0 - correlation);
        let error = (squares / (count - 2.0) / spread * widened).sqrt();
        Some(Fit {
            slope,
            half_width: 2.0 * error,
            intercept: mean[1] - slope * mean[0],
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
                assert_eq!(line.fit().is_some(), line.points.len() >= MIN_POINTS);
                line.push(x, 3.0 - 0.25 * x);
            }
            let fit = line.fit().unwrap();
            assert!((fit.slope + 0.25).abs() < 1e-12, "{count}: {fit:?}");
            assert!((fit.intercept - 3.0).abs() < 1e-9 && fit.half_width < 1e-9);
            assert_eq!(fit.from, 2.0);
            assert!(line.points.len() <= MAX_POINTS);
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
