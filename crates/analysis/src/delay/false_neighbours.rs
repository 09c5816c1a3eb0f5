//! False nearest neighbours: neighbours that a further coordinate separates.
//!
//! In too few dimensions an attractor overlaps itself in projection: distant states appear close, and
//! the next coordinate separates them. The attractor is unfolded once no such false neighbours remain
//! (M. B. Kennel, R. Brown and H. D. I. Abarbanel, Phys. Rev. A 45, 3403, 1992). For a deterministic
//! signal their share falls to 0. For noise, which fills every dimension, it does not.

use schemars::JsonSchema;
use serde::Serialize;

use rayon::prelude::*;

use crate::{
    AnalysisError,
    delay::DelayVectors,
    neighbours::{Neighbour, NeighbourTree},
    norm::Norm,
    stats::deviation,
};

/// Resolution of distances as a share of the standard deviation of the samples.
const RESOLUTION: f64 = 1e-6;

/// Parameters of [`false_neighbours`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseNeighbourSearch {
    /// Lag, samples.
    pub lag: usize,
    /// Largest dimension; all dimensions from 1 are tried.
    pub largest_dimension: usize,
    /// Theiler window, samples: pairs closer in time are not neighbours.
    pub theiler: usize,
    /// Limit of the first criterion: growth of the distance over the distance (Kennel's R_tol, 15).
    pub distance_ratio: f64,
    /// Limit of the second criterion: new distance over the standard deviation of the signal (Kennel's
    /// A_tol, 2).
    pub size_ratio: f64,
}

impl FalseNeighbourSearch {
    /// Parameters with the limits of Kennel, Brown and Abarbanel, 15 and 2.
    pub fn new(lag: usize, largest_dimension: usize, theiler: usize) -> Self {
        Self {
            lag,
            largest_dimension,
            theiler,
            distance_ratio: 15.0,
            size_ratio: 2.0,
        }
    }

    /// Number of samples needed: in the largest dimension at least one vector has a neighbour outside
    /// the Theiler window, both with a next coordinate.
    fn samples_needed(&self) -> usize {
        let next = self.largest_dimension.saturating_mul(self.lag);
        next.saturating_add(self.theiler.max(1)).saturating_add(1)
    }
}

/// Share of false nearest neighbours by dimension.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FalseNeighbours {
    /// Lag, samples.
    #[serde(rename = "lag_samples")]
    pub lag: usize,
    /// Share of false neighbours (either criterion), 0 to 1, for dimension 1, 2, ...
    pub share: Vec<f64>,
    /// Number of vectors with a neighbour outside the Theiler window, for dimension 1, 2, ...
    pub evaluated: Vec<usize>,
}

impl FalseNeighbours {
    /// Smallest dimension with a share of at most `limit`.
    pub fn dimension(&self, limit: f64) -> Option<usize> {
        let place = self.share.iter().position(|&share| share <= limit);
        place.map(|index| index + 1)
    }
}

/// Computes the share of false nearest neighbours in the dimensions `m` = 1 to the largest.
///
/// For every vector `i` that has a next coordinate `x[i + m lag]`, the nearest neighbour `j` with
/// `|i - j| >= theiler` that has one too is tested. With `R_m` their Euclidean distance in `m`
/// dimensions, `d = |x[i + m lag] - x[j + m lag]|` its growth, and `sigma` the standard deviation of the
/// samples, `j` is false if
///
/// ```text
/// d > distance_ratio R_m     or     sqrt(R_m^2 + d^2) > size_ratio sigma
/// ```
///
/// In the first criterion `R_m` is at least `1e-6 sigma`: coincident neighbours are false if the next
/// coordinate separates them by more than that limit allows. If it does not, the state has recurred
/// exactly and carries no information; the nearest neighbour farther away than `1e-6 sigma` is tested
/// instead. (Otherwise a computed periodic signal with an integer number of samples per period would
/// appear unfolded in one dimension.) A constant signal has no false neighbours.
///
/// The computation uses all cores. The result does not depend on their number.
///
/// # Errors
/// [`AnalysisError::InvalidDelay`] for a lag or dimension of 0; [`AnalysisError::TooShort`] if no vector
/// of the largest dimension has a neighbour.
pub fn false_neighbours(
    samples: &[f64],
    search: &FalseNeighbourSearch,
) -> Result<FalseNeighbours, AnalysisError> {
    let &FalseNeighbourSearch { lag, theiler, .. } = search;
    AnalysisError::check_length("false neighbours", samples.len(), search.samples_needed())?;
    DelayVectors::new(samples, lag, search.largest_dimension)?;
    let sigma = deviation(samples);
    let (resolution, size) = (RESOLUTION * sigma, search.size_ratio * sigma);
    let mut found = FalseNeighbours {
        lag,
        share: Vec::with_capacity(search.largest_dimension),
        evaluated: Vec::with_capacity(search.largest_dimension),
    };
    for dimension in 1..=search.largest_dimension {
        // All vectors that have a next coordinate.
        let vectors = DelayVectors::new(&samples[..samples.len() - lag], lag, dimension)?;
        let next = &samples[dimension * lag..];
        let tree = NeighbourTree::new(vectors, Norm::Euclidean);
        let nearest = tree.nearest_all(theiler);
        let tested = nearest.par_iter().enumerate().filter_map(|(i, neighbour)| {
            let is_false = |neighbour: Neighbour| {
                let growth = (next[i] - next[neighbour.index]).abs();
                growth > search.distance_ratio * neighbour.distance.max(resolution)
                    || (neighbour.distance * neighbour.distance + growth * growth).sqrt() > size
            };
            let neighbour = (*neighbour)?;
            if is_false(neighbour) || neighbour.distance > resolution {
                return Some(is_false(neighbour));
            }
            let other = tree.nearest_beyond(i, resolution, theiler);
            Some(other.is_some_and(is_false))
        });
        let tested: Vec<bool> = tested.collect();
        let wrong = tested.iter().filter(|is_false| **is_false).count();
        found.share.push(wrong as f64 / tested.len() as f64);
        found.evaluated.push(tested.len());
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};

    /// Initial states of Lorenz trajectories.
    const STARTS: [[f64; 3]; 6] = [
        [1.0, 1.0, 1.0],
        [-5.0, 3.0, 20.0],
        [0.1, 0.0, 0.0],
        [10.0, -4.0, 30.0],
        [2.0, 7.0, 5.0],
        [-1.0, -8.0, 27.0],
    ];

    /// The definition with all pairwise distances; the numbers of tested and false neighbours.
    fn direct(samples: &[f64], search: &FalseNeighbourSearch, m: usize) -> (usize, usize) {
        let sigma = deviation(samples);
        let count = samples.len() - m * search.lag;
        let at = |i: usize, c: usize| samples[i + c * search.lag];
        let (mut evaluated, mut wrong) = (0, 0);
        for i in 0..count {
            let squared = |j: usize| {
                let squares = (0..m).map(|c| (at(i, c) - at(j, c)) * (at(i, c) - at(j, c)));
                squares.fold(0.0, |a, b| a + b)
            };
            let nearest = |beyond: f64| {
                (0..count)
                    .filter(|&j| i.abs_diff(j) >= search.theiler.max(1))
                    .filter(|&j| squared(j).sqrt() > beyond)
                    .min_by(|&a, &b| squared(a).total_cmp(&squared(b)))
            };
            let is_false = |j: usize| {
                let (r, d) = (squared(j).sqrt(), (at(i, m) - at(j, m)).abs());
                d > search.distance_ratio * r.max(1e-6 * sigma)
                    || (r * r + d * d).sqrt() > search.size_ratio * sigma
            };
            let Some(j) = nearest(-1.0) else { continue };
            evaluated += 1;
            let coincident = squared(j).sqrt() <= 1e-6 * sigma && !is_false(j);
            let verdict = if coincident {
                nearest(1e-6 * sigma).is_some_and(is_false)
            } else {
                is_false(j)
            };
            wrong += usize::from(verdict);
        }
        (evaluated, wrong)
    }

    #[test]
    fn shares_match_the_definition() {
        let chaos = coordinate(&lorenz(800, 0.02, STARTS[0]), 0);
        let steps: Vec<f64> = noise(1, 500, 1.0).iter().map(|x| x.round()).collect();
        for (samples, lag, theiler) in [(chaos, 8, 40), (noise(2, 300, 1.0), 1, 0), (steps, 2, 9)] {
            let search = FalseNeighbourSearch::new(lag, 5, theiler);
            let found = false_neighbours(&samples, &search).unwrap();
            for m in 1..=5 {
                let (evaluated, wrong) = direct(&samples, &search, m);
                assert_eq!(found.evaluated[m - 1], evaluated);
                assert_eq!(
                    found.share[m - 1],
                    wrong as f64 / evaluated as f64,
                    "{lag}, {m}"
                );
            }
        }
    }

    #[test]
    fn each_criterion_works_alone() {
        let samples = [0.0, 5.0, 1.0, 10.0, 6.0];
        let share = |distance_ratio, size_ratio| {
            let search = FalseNeighbourSearch {
                distance_ratio,
                size_ratio,
                ..FalseNeighbourSearch::new(1, 1, 0)
            };
            false_neighbours(&samples, &search).unwrap().share[0]
        };
        // The neighbours of 0, 5, 1, 10 are 1, 1, 0, 5 with distances 1, 4, 1, 5. The next samples
        // differ by 5, 9, 5, 5. New distances are 5.10, 9.85, 5.10, 7.07; sigma is the root of 13.04.
        for (ratio, expected) in [(5.1, 0.0), (4.9, 0.5), (2.2, 0.75), (0.9, 1.0)] {
            assert_eq!(share(ratio, 100.0), expected, "{ratio}");
        }
        for (size, expected) in [(10.0, 0.0), (8.0, 0.25), (6.0, 0.5), (5.0, 1.0)] {
            assert_eq!(share(100.0, size / 13.04_f64.sqrt()), expected, "{size}");
        }
    }

    #[test]
    fn the_lorenz_system_unfolds_in_three_dimensions() {
        // Reference values from one trajectory: 99.7, 6.8, 0.03, 0 %. Six trajectories of this test give
        // 99.76 to 99.87, 6.5 to 7.4, 0 to 0.07, 0.
        for start in &STARTS[..3] {
            let x = coordinate(&lorenz(50_000, 0.01, *start), 0);
            let search = FalseNeighbourSearch::new(17, 4, 50);
            let found = false_neighbours(&x, &search).unwrap();
            assert!((found.share[0] - 0.998).abs() < 0.001, "{found:?}");
            assert!((found.share[1] - 0.068).abs() < 0.006, "{found:?}");
            assert!((found.share[2] - 0.0003).abs() < 0.0005, "{found:?}");
            assert_eq!(found.share[3], 0.0);
            assert_eq!(found.dimension(0.01), Some(3));
            assert_eq!(found.evaluated[0], 50_000 - 17);
        }
    }

    #[test]
    fn the_roessler_system_unfolds_in_three_dimensions() {
        let x = coordinate(&roessler(20_000, 0.1, [0.2, 0.2, 5.7], [1.0, 1.0, 0.0]), 0);
        let found = false_neighbours(&x, &FalseNeighbourSearch::new(14, 5, 60)).unwrap();
        assert_eq!(found.dimension(0.01), Some(3), "{found:?}");
        assert_eq!(found.share[3..], [0.0, 0.0]);
    }

    #[test]
    fn a_closed_curve_unfolds_in_two_dimensions() {
        // The first signal repeats after 50 samples: states coincide except for rounding errors.
        for frequency in [1.0, 0.1_f64.exp()] {
            let signal = sines(50.0, 5000, &[(frequency, 3.0, 0.3)]);
            let found = false_neighbours(&signal, &FalseNeighbourSearch::new(10, 5, 50)).unwrap();
            assert!(found.share[0] > 0.2, "{found:?}");
            assert_eq!(found.share[1..], [0.0; 4], "{found:?}");
        }
    }

    #[test]
    fn noise_never_unfolds() {
        for count in [1000, 20_000] {
            let signal = noise(3, count, 1.0);
            let found = false_neighbours(&signal, &FalseNeighbourSearch::new(1, 8, 1)).unwrap();
            assert!(found.share.iter().all(|&share| share > 0.1), "{found:?}");
        }
    }

    #[test]
    fn a_constant_signal_has_no_false_neighbours() {
        let found = false_neighbours(&[0.1; 500], &FalseNeighbourSearch::new(3, 4, 10)).unwrap();
        assert_eq!(found.share, [0.0; 4]);
        assert_eq!(found.evaluated, [497, 494, 491, 488]);
    }

    #[test]
    fn scale_does_not_change_the_shares() {
        let signal = noise(4, 500, 1.0);
        let scaled: Vec<f64> = signal.iter().map(|x| x * 2.0_f64.powi(-60)).collect();
        let search = FalseNeighbourSearch::new(2, 4, 3);
        let (a, b) = (
            false_neighbours(&signal, &search),
            false_neighbours(&scaled, &search),
        );
        assert_eq!(a, b);
    }

    #[test]
    fn too_few_samples_are_rejected() {
        let search = FalseNeighbourSearch::new(5, 3, 10);
        let signal = noise(5, 26, 1.0);
        let found = false_neighbours(&signal, &search).unwrap();
        assert_eq!(found.evaluated, [21, 12, 2]);
        assert_eq!(
            false_neighbours(&signal[1..], &search).unwrap_err(),
            AnalysisError::TooShort {
                what: "false neighbours",
                have: 25,
                need: 26
            }
        );
        for (lag, dimension) in [(0, 3), (5, 0)] {
            let error = false_neighbours(&signal, &FalseNeighbourSearch::new(lag, dimension, 1));
            assert_eq!(
                error.unwrap_err(),
                AnalysisError::InvalidDelay { lag, dimension }
            );
        }
        assert!(false_neighbours(&signal, &FalseNeighbourSearch::new(usize::MAX, 9, 1)).is_err());
    }
}
