//! Non-negative least squares with few non-zero weights.
//!
//! The problem is `min |A w - b|` with `w >= 0` and a limited number of non-zero weights. The active set grows
//! by one column at a time as in C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, SIAM 1995,
//! ch. 23; stopping early gives the sparse solution of C. Farhat et al., Int. J. Numer. Meth. Engng 102
//! (2015) 1077 (ECSW) and of J. A. Hernandez et al., Comput. Methods Appl. Mech. Engrg. 313 (2017) 687
//! (empirical cubature). A greedy choice is not the best one: [`Problem::exchange`] then replaces single
//! columns as long as that reduces the residual.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

/// Candidates tried for each exchange, in the order of their residuals.
const CANDIDATES: usize = 4;

/// Relative decrease of the squared residual for which a column is exchanged.
const MIN_GAIN: f64 = 1e-2;

/// Maximum number of passes over all columns of the active set.
const MAX_PASSES: usize = 12;

/// A least-squares problem: `A` and `b`.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    rows: usize,
    /// `A`, column by column.
    columns: Vec<f64>,
    target: Vec<f64>,
}

/// Columns with positive weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ActiveSet {
    pub columns: Vec<usize>,
    /// One weight per column of the set.
    pub weights: Vec<f64>,
}

impl Problem {
    /// A problem with the matrix column by column; its number of rows is the length of the target.
    pub fn new(columns: Vec<f64>, target: Vec<f64>) -> Self {
        let rows = target.len();
        assert!(rows > 0 && columns.len().is_multiple_of(rows));
        Self {
            rows,
            columns,
            target,
        }
    }

    fn count(&self) -> usize {
        self.columns.len() / self.rows
    }

    fn column(&self, k: usize) -> &[f64] {
        &self.columns[k * self.rows..][..self.rows]
    }

    /// `b - A w`.
    pub fn residual(&self, set: &ActiveSet) -> Vec<f64> {
        let mut residual = self.target.clone();
        for (&k, weight) in set.columns.iter().zip(&set.weights) {
            subtract(&mut residual, *weight, self.column(k));
        }
        residual
    }

    /// `|b - A w|`.
    pub fn residual_norm(&self, set: &ActiveSet) -> f64 {
        norm(&self.residual(set))
    }

    /// Least-squares weights of some columns, of any sign.
    fn weights(&self, columns: &[usize]) -> Vec<f64> {
        let matrix = Mat::from_fn(self.rows, columns.len(), |i, j| self.column(columns[j])[i]);
        let mut target = Mat::from_fn(self.rows, 1, |i, _| self.target[i]);
        let qr = matrix.qr();
        qr.solve_lstsq_in_place(&mut target);
        (0..columns.len()).map(|j| target[(j, 0)]).collect()
    }

    /// Adds columns to the set until it has `size` of them, the residual is at most `tolerance`, or no
    /// column reduces the residual.
    pub fn grow(&self, set: &mut ActiveSet, size: usize, tolerance: f64) {
        let norms: Vec<f64> = (0..self.count()).map(|k| norm(self.column(k))).collect();
        // A column that was removed as soon as it entered is not tried again before the set has changed.
        let mut barred = vec![false; self.count()];
        let size = size.min(self.rows).min(self.count());
        while set.columns.len() < size {
            let residual = self.residual(set);
            if norm(&residual) <= tolerance {
                return;
            }
            let free = (0..self.count())
                .filter(|&k| !barred[k] && norms[k] > 0.0 && !set.columns.contains(&k));
            let gains = free.map(|k| (k, dot(self.column(k), &residual) / norms[k]));
            let Some((entering, gain)) = gains.max_by(|a, b| a.1.total_cmp(&b.1)) else {
                return;
            };
            if gain <= 1e-14 * norm(&self.target) {
                return;
            }
            set.columns.push(entering);
            set.weights.push(0.0);
            self.restore_signs(set);
            if set.columns.contains(&entering) {
                barred.fill(false);
            } else {
                barred[entering] = true;
            }
        }
    }

    /// The inner loop of Lawson and Hanson: moves the weights towards the least-squares solution of the set
    /// and removes each column whose weight vanishes on the way.
    fn restore_signs(&self, set: &mut ActiveSet) {
        while !set.columns.is_empty() {
            let solution = self.weights(&set.columns);
            let limits = set.weights.iter().zip(&solution);
            let fraction = limits
                .filter(|(_, to)| **to <= 0.0)
                .map(|(from, to)| if *from > 0.0 { from / (from - to) } else { 0.0 })
                .fold(f64::INFINITY, f64::min);
            if fraction == f64::INFINITY {
                set.weights = solution;
                return;
            }
            let mut kept = ActiveSet::default();
            for (k, (from, to)) in set.columns.iter().zip(set.weights.iter().zip(&solution)) {
                let weight = from + fraction * (to - from);
                if *to > 0.0 || weight > 1e-12 * from {
                    kept.columns.push(*k);
                    kept.weights.push(weight);
                }
            }
            *set = kept;
        }
    }

    /// The set with the least-squares weights that satisfy equations `E w = e` to rounding, if the set has
    /// more columns than there are equations and all weights remain positive. `exact` is `[E | e]`, one row
    /// of `n + 1` numbers per equation.
    ///
    /// The equations enter the least-squares problem with a large factor and as its first rows, for which
    /// Householder triangularisation is stable (Lawson and Hanson, ch. 22).
    pub fn with_exact(&self, set: &ActiveSet, exact: &[f64]) -> Option<ActiveSet> {
        const FACTOR: f64 = 1e7;
        let width = self.count() + 1;
        let equations = exact.len() / width;
        if equations >= set.columns.len() {
            return None;
        }
        let entry = |i: usize, column: Option<usize>| match i.checked_sub(equations) {
            None => FACTOR * exact[i * width + column.unwrap_or(width - 1)],
            Some(i) => column.map_or(self.target[i], |k| self.column(k)[i]),
        };
        let rows = equations + self.rows;
        let matrix = Mat::from_fn(rows, set.columns.len(), |i, j| {
            entry(i, Some(set.columns[j]))
        });
        let mut target = Mat::from_fn(rows, 1, |i, _| entry(i, None));
        matrix.qr().solve_lstsq_in_place(&mut target);
        let columns = set.columns.clone();
        let weights: Vec<f64> = (0..columns.len()).map(|j| target[(j, 0)]).collect();
        let positive = weights.iter().all(|weight| *weight > 0.0);
        positive.then_some(ActiveSet { columns, weights })
    }

    /// Replaces single columns of the set by others as long as the residual decreases and all weights remain
    /// positive. The number of columns stays the same.
    pub fn exchange(&self, set: &mut ActiveSet) {
        let mut square = self.residual_norm(set).powi(2);
        for _ in 0..MAX_PASSES {
            let mut changed = false;
            for place in 0..set.columns.len() {
                if let Some(better) = self.replaced(set, place, (1.0 - MIN_GAIN) * square) {
                    *set = better;
                    square = self.residual_norm(set).powi(2);
                    changed = true;
                }
            }
            if !changed {
                return;
            }
        }
    }

    /// The set with another column at `place` that reduces the squared residual below `limit`, if there is
    /// one.
    fn replaced(&self, set: &ActiveSet, place: usize, limit: f64) -> Option<ActiveSet> {
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(set.columns.len());
        for (k, &column) in set.columns.iter().enumerate() {
            if k == place {
                continue;
            }
            let mut next = self.column(column).to_vec();
            // Twice, since the columns are nearly dependent.
            remove_projection(&mut next, &basis);
            remove_projection(&mut next, &basis);
            let length = norm(&next);
            if length > 0.0 {
                next.iter_mut().for_each(|x| *x /= length);
                basis.push(next);
            }
        }
        let mut residual = self.target.clone();
        remove_projection(&mut residual, &basis);
        let square = dot(&residual, &residual);
        let mut found: Vec<(f64, usize)> = Vec::new();
        let mut rest = vec![0.0; self.rows];
        for candidate in (0..self.count()).filter(|k| !set.columns.contains(k)) {
            rest.copy_from_slice(self.column(candidate));
            let length = dot(&rest, &rest);
            remove_projection(&mut rest, &basis);
            let left = dot(&rest, &rest);
            if left > 1e-20 * length {
                let remaining = square - dot(&rest, &residual).powi(2) / left;
                if remaining < limit {
                    found.push((remaining, candidate));
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().take(CANDIDATES).find_map(|(_, column)| {
            let mut columns = set.columns.clone();
            columns[place] = column;
            let weights = self.weights(&columns);
            let other = ActiveSet { columns, weights };
            let positive = other.weights.iter().all(|weight| *weight > 0.0);
            (positive && self.residual_norm(&other).powi(2) < limit).then_some(other)
        })
    }
}

/// Removes from a vector its components along orthonormal vectors.
fn remove_projection(vector: &mut [f64], basis: &[Vec<f64>]) {
    for direction in basis {
        let along = dot(vector, direction);
        subtract(vector, along, direction);
    }
}

/// `vector -= factor * other`.
pub(super) fn subtract(vector: &mut [f64], factor: f64, other: &[f64]) {
    for (x, y) in vector.iter_mut().zip(other) {
        *x -= factor * y;
    }
}

/// Scalar product, in eight partial sums for speed.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_parts, b_parts) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a_parts.remainder().iter().zip(b_parts.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (x, y) in a_parts.zip(b_parts) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}

pub(super) fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn random(rows: usize, count: usize, seed: u64) -> Problem {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut numbers =
            |count| -> Vec<f64> { (0..count).map(|_| rng.random_range(-1.0..1.0)).collect() };
        Problem::new(numbers(rows * count), numbers(rows))
    }

    fn solved(problem: &Problem) -> ActiveSet {
        let mut set = ActiveSet::default();
        problem.grow(&mut set, usize::MAX, 0.0);
        set
    }

    /// The unconstrained solution has a negative weight, which is zero in the solution.
    #[test]
    fn a_negative_weight_becomes_zero() {
        let problem = Problem::new(vec![1.0, 0.0, 1.0, 1.0], vec![2.0, -1.0]);
        let set = solved(&problem);
        assert_eq!(set.columns, [0]);
        assert!((set.weights[0] - 2.0).abs() < 1e-15);
        assert!((problem.residual_norm(&set) - 1.0).abs() < 1e-15);
    }

    /// The residual is the smallest of all subsets of columns with positive weights.
    #[test]
    fn the_solution_is_the_best_of_all_subsets() {
        for seed in 0..40 {
            let problem = random(8, 7, seed);
            let best = (0_u32..1 << 7)
                .map(|bits| {
                    let columns: Vec<_> = (0..7).filter(|k| bits >> k & 1 == 1).collect();
                    let weights = if columns.is_empty() {
                        vec![]
                    } else {
                        problem.weights(&columns)
                    };
                    ActiveSet { columns, weights }
                })
                .filter(|set| set.weights.iter().all(|weight| *weight > 0.0))
                .map(|set| problem.residual_norm(&set))
                .fold(f64::INFINITY, f64::min);
            let found = problem.residual_norm(&solved(&problem));
            assert!((found - best).abs() < 1e-12, "seed {seed}: {found} {best}");
        }
    }

    /// A target that is a sum of few columns is found exactly.
    #[test]
    fn a_sparse_solution_is_found() {
        let mut problem = random(12, 40, 3);
        let exact = ActiveSet {
            columns: vec![4, 17, 30],
            weights: vec![0.5, 2.0, 1.0],
        };
        problem.target.fill(0.0);
        problem.target = problem.residual(&exact).iter().map(|x| -x).collect();
        assert!(problem.residual_norm(&solved(&problem)) < 1e-12);
    }

    #[test]
    fn exchanges_reduce_the_residual() {
        let mut improved = 0;
        for seed in 0..10 {
            let problem = random(12, 60, seed);
            let mut set = ActiveSet::default();
            problem.grow(&mut set, 5, 0.0);
            let (before, size) = (problem.residual_norm(&set), set.columns.len());
            problem.exchange(&mut set);
            assert_eq!(set.columns.len(), size);
            assert!(set.weights.iter().all(|weight| *weight > 0.0));
            assert!(problem.residual_norm(&set) <= before);
            improved += usize::from(problem.residual_norm(&set) < 0.99 * before);
        }
        assert!(improved >= 3, "{improved}");
    }

    #[test]
    fn equations_are_satisfied_to_rounding() {
        let mut problem = random(12, 6, 5);
        let set = ActiveSet {
            columns: (0..6).collect(),
            weights: vec![-10.0; 6],
        };
        // Near the solution with weights of 10.
        problem.target = problem.residual(&set);
        // The sum of all weights, and a weighted sum.
        let exact = [
            1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 60.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 210.0,
        ];
        let set = problem.with_exact(&set, &exact).expect("positive weights");
        for equation in exact.chunks_exact(7) {
            let error = dot(&equation[..6], &set.weights) - equation[6];
            assert!(error.abs() < 1e-11, "{error:e}");
        }
        assert_eq!(problem.with_exact(&set, &exact.repeat(3)), None);
    }
}
