//! Covariance matrix adaptation evolution strategy (CMA-ES) for the minimum of a noisy function: N. Hansen, The CMA
//! Evolution Strategy: A Tutorial, arXiv:1604.00772. The equation numbers are those of the tutorial.
//!
//! The caller evaluates the points, so that a search can be logged, interrupted and replayed.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// State of the strategy: the normal distribution of the next points.
#[derive(Clone, Debug)]
pub(super) struct Cma {
    mean: DVector<f64>,
    /// Step size, the standard deviation beside the covariance.
    width: f64,
    covariance: DMatrix<f64>,
    /// Evolution paths of the covariance and of the step size.
    path: DVector<f64>,
    width_path: DVector<f64>,
    generations: i32,
}

impl Cma {
    /// Starts at a point with a standard deviation in all directions.
    pub fn new(start: &[f64], width: f64) -> Self {
        let n = start.len();
        Self {
            mean: DVector::from_column_slice(start),
            width,
            covariance: DMatrix::identity(n, n),
            path: DVector::zeros(n),
            width_path: DVector::zeros(n),
            generations: 0,
        }
    }

    /// Points of the next generation, Eq. (5).
    pub fn points(&self, count: usize, rng: &mut impl Rng) -> Vec<DVector<f64>> {
        let [root, _] = self.roots();
        let n = self.mean.len();
        let mut point = || {
            let normal = DVector::from_fn(n, |_, _| StandardNormal.sample(rng));
            &self.mean + self.width * (&root * normal)
        };
        (0..count).map(|_| point()).collect()
    }

    /// Square root of the covariance and its inverse.
    fn roots(&self) -> [DMatrix<f64>; 2] {
        let SymmetricEigen {
            eigenvectors,
            eigenvalues,
        } = self.covariance.clone().symmetric_eigen();
        let with = |of: &dyn Fn(f64) -> f64| {
            let diagonal = DMatrix::from_diagonal(&eigenvalues.map(|x| of(x.max(1e-20).sqrt())));
            &eigenvectors * diagonal * eigenvectors.transpose()
        };
        [with(&|x| x), with(&|x| 1.0 / x)]
    }

    /// Moves and shapes the distribution by a generation of at least four points, best first.
    pub fn update(&mut self, ranked: &[DVector<f64>]) {
        let n = self.mean.len() as f64;
        let count = ranked.len() as f64;
        // Weights of the better half, Eq. (49) to (53) without negative weights.
        let parents = ranked.len() / 2;
        let raw = (1..=parents).map(|i| ((count + 1.0) / 2.0).ln() - (i as f64).ln());
        let raw: Vec<f64> = raw.collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let mass = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        // Learning rates, Eq. (54) to (58).
        let c_width = (mass + 2.0) / (n + mass + 5.0);
        let damping = 1.0 + 2.0 * (((mass - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_width;
        let c_path = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
        let rank_one = 2.0 / ((n + 1.3).powi(2) + mass);
        let rank_mu = 2.0 * (0.25 + mass + 1.0 / mass - 2.0) / ((n + 2.0).powi(2) + mass);
        let rank_mu = rank_mu.min(1.0 - rank_one);
        let [_, inverse_root] = self.roots();
        let steps: Vec<_> = ranked[..parents]
            .iter()
            .map(|point| (point - &self.mean) / self.width)
            .collect();
        let zero = DVector::zeros(self.mean.len());
        let pairs = || weights.iter().zip(&steps);
        let step = pairs().fold(zero, |sum, (w, y)| sum + *w * y);
        // Mean and paths, Eq. (9), (43) and (45).
        self.mean += self.width * &step;
        let gain = (c_width * (2.0 - c_width) * mass).sqrt();
        self.width_path = (1.0 - c_width) * &self.width_path + gain * (&inverse_root * &step);
        self.generations += 1;
        let settled = (1.0 - (1.0 - c_width).powi(2 * self.generations)).sqrt();
        let expected = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
        let length = self.width_path.norm();
        let stalled = length / settled < (1.4 + 2.0 / (n + 1.0)) * expected;
        let gain = match stalled {
            true => (c_path * (2.0 - c_path) * mass).sqrt(),
            false => 0.0,
        };
        self.path = (1.0 - c_path) * &self.path + gain * &step;
        // Covariance and step size, Eq. (47) and (44).
        let lost = match stalled {
            true => 0.0,
            false => c_path * (2.0 - c_path),
        };
        let kept = 1.0 + rank_one * lost - rank_one - rank_mu;
        self.covariance = kept * &self.covariance + rank_one * &self.path * self.path.transpose();
        for (w, y) in pairs() {
            self.covariance += rank_mu * *w * y * y.transpose();
        }
        self.width *= (c_width / damping * (length / expected - 1.0)).exp();
    }

    #[cfg(test)]
    fn mean(&self) -> &DVector<f64> {
        &self.mean
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// The minimum of a function found from a start after some generations.
    fn minimum(
        function: impl Fn(&DVector<f64>, &mut ChaCha8Rng) -> f64,
        start: &[f64],
        generations: usize,
    ) -> DVector<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut search = Cma::new(start, 0.3);
        for _ in 0..generations {
            let points = search.points(12, &mut rng);
            let mut valued: Vec<_> = points
                .into_iter()
                .map(|point| (function(&point, &mut rng), point))
                .collect();
            valued.sort_by(|a, b| a.0.total_cmp(&b.0));
            let ranked: Vec<_> = valued.into_iter().map(|(_, point)| point).collect();
            search.update(&ranked);
        }
        search.mean().clone()
    }

    /// An ellipsoid with axes of a ratio of 1000, turned against the coordinates.
    #[test]
    fn an_ill_conditioned_minimum_is_found() {
        let function = |x: &DVector<f64>, _: &mut ChaCha8Rng| {
            let along = x.sum();
            let across = x.norm_squared() - along * along / x.len() as f64;
            (along - 5.0).powi(2) + 1e6 * across
        };
        let found = minimum(function, &[0.2, -0.1, 0.4, 0.0, 0.3], 250);
        assert!(found.iter().all(|x| (x - 1.0).abs() < 1e-6), "{found}");
    }

    #[test]
    fn rosenbrocks_valley_is_followed() {
        let function = |x: &DVector<f64>, _: &mut ChaCha8Rng| {
            let pairs = x.as_slice().windows(2);
            let terms = pairs.map(|x| 100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2));
            terms.sum::<f64>()
        };
        let found = minimum(function, &[-0.5, 0.5, 0.0, 0.5], 400);
        assert!(found.iter().all(|x| (x - 1.0).abs() < 1e-4), "{found}");
    }

    /// Values with noise as large as their differences at a distance of 0.3.
    #[test]
    fn noise_does_not_prevent_progress() {
        let function = |x: &DVector<f64>, rng: &mut ChaCha8Rng| {
            let noise: f64 = StandardNormal.sample(rng);
            (x - DVector::from_element(x.len(), 1.0)).norm_squared() + 0.1 * noise
        };
        let found = minimum(function, &[0.0; 5], 60);
        let off = (found - DVector::from_element(5, 1.0)).norm();
        assert!(off < 0.5, "{off}");
    }
}
