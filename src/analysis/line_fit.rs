//! A straight line through points that come one after another, in bounded memory.

/// The most points kept.
const MOST: usize = 128;

/// Fewer points than these give no line.
const FEWEST: usize = 8;

/// A straight line fitted to points evenly spaced along the abscissa, as they come. When all places are
/// taken, neighbours are merged into their mean.
#[derive(Clone, Debug, Default)]
pub struct LineFit {
    points: Vec<[f64; 2]>,
    /// Sum of the points that are yet to be merged into one, and how many they are.
    filling: [f64; 2],
    filled: usize,
    /// How many points make one, less one: zero as long as all are kept.
    more: usize,
    /// The first abscissa.
    from: Option<f64>,
}

/// A straight line through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// By least squares.
    pub slope: f64,
    /// Half the width of the slope's 95 % interval.
    pub half_width: f64,
    /// The ordinate at zero.
    pub intercept: f64,
    /// The first abscissa.
    pub from: f64,
}

impl LineFit {
    /// Forgets all points.
    pub fn clear(&mut self) {
        let mut points = std::mem::take(&mut self.points);
        points.clear();
        *self = Self {
            points,
            ..Self::default()
        };
    }

    /// Takes the next point.
    pub fn push(&mut self, x: f64, y: f64) {
        self.from.get_or_insert(x);
        self.filling[0] += x;
        self.filling[1] += y;
        self.filled += 1;
        if self.filled <= self.more {
            return;
        }
        if self.points.len() == MOST {
            self.merge();
        }
        if self.filled > self.more {
            let filled = self.filled as f64;
            self.points.push(self.filling.map(|sum| sum / filled));
            (self.filling, self.filled) = ([0.0; 2], 0);
        }
    }

    fn merge(&mut self) {
        let pairs = self.points.chunks_exact(2);
        let mean = |pair: &[[f64; 2]]| [0, 1].map(|c| 0.5 * (pair[0][c] + pair[1][c]));
        self.points = pairs.map(mean).collect();
        self.more = 2 * self.more + 1;
    }

    /// The line, and the error of its slope: by the scatter about the line, widened by the correlation of
    /// neighbours. `None` for fewer than eight points.
    pub fn fit(&self) -> Option<Fit> {
        let count = self.points.len() as f64;
        let from = self.from.filter(|_| self.points.len() >= FEWEST)?;
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
    fn a_line_is_found_however_many_its_points() {
        for count in [8, 100, 128, 129, 1000, 12_345] {
            let mut line = LineFit::default();
            for k in 0..count {
                let x = 2.0 + 0.5 * f64::from(k);
                assert_eq!(line.fit().is_some(), line.points.len() >= FEWEST);
                line.push(x, 3.0 - 0.25 * x);
            }
            let fit = line.fit().unwrap();
            assert!((fit.slope + 0.25).abs() < 1e-12, "{count}: {fit:?}");
            assert!((fit.intercept - 3.0).abs() < 1e-9 && fit.half_width < 1e-9);
            assert_eq!(fit.from, 2.0);
            assert!(line.points.len() <= MOST);
        }
    }

    #[test]
    fn the_interval_holds_the_slope_in_about_95_of_100() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut inside = 0;
        for _ in 0..1000 {
            let mut line = LineFit::default();
            let mut noise = 0.0;
            for k in 0..100 {
                let random: f64 = StandardNormal.sample(&mut rng);
                // Neighbours go together.
                noise = 0.5 * noise + random;
                line.push(f64::from(k), 0.1 * f64::from(k) + noise);
            }
            let fit = line.fit().unwrap();
            inside += u32::from((fit.slope - 0.1).abs() <= fit.half_width);
        }
        assert!((900..=980).contains(&inside), "{inside}");
    }
}
