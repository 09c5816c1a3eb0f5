use proptest::prelude::*;

use super::*;
use crate::test_signals::{coordinate, lorenz, noise, sines};

const NORMS: [Norm; 3] = [Norm::Euclidean, Norm::Maximum, Norm::Manhattan];

/// The sum by which two vectors are compared.
fn sum(vectors: &DelayVectors<'_>, norm: Norm, i: usize, j: usize) -> f64 {
    let pairs = vectors.vector(i).zip(vectors.vector(j)).map(|(a, b)| a - b);
    match norm {
        Norm::Euclidean => pairs.map(|d| d * d).fold(0.0, |a, b| a + b),
        Norm::Maximum => pairs.map(f64::abs).fold(0.0, f64::max),
        Norm::Manhattan => pairs.map(f64::abs).fold(0.0, |a, b| a + b),
    }
}

fn distance(vectors: &DelayVectors<'_>, norm: Norm, i: usize, j: usize) -> f64 {
    match norm {
        Norm::Euclidean => sum(vectors, norm, i, j).sqrt(),
        _ => sum(vectors, norm, i, j),
    }
}

/// Vectors that count as neighbours of `i`.
fn candidates(
    vectors: &DelayVectors<'_>,
    i: usize,
    theiler: usize,
    limit: usize,
) -> impl Iterator<Item = usize> {
    (0..limit.min(vectors.len())).filter(move |&j| i.abs_diff(j) >= theiler.max(1))
}

fn assert_matches_brute_force(
    samples: &[f64],
    lag: usize,
    dimension: usize,
    theiler: usize,
    limit: usize,
) {
    let vectors = DelayVectors::new(samples, lag, dimension).unwrap();
    for norm in NORMS {
        let tree = NeighbourTree::new(vectors, norm);
        let each = tree.nearest_each(0..vectors.len(), theiler, limit);
        let all = tree.nearest_all(theiler);
        if limit >= vectors.len() {
            assert_eq!(each, all);
        }
        for (i, &in_turn) in each.iter().enumerate() {
            // The first of the smallest, as returned by `min_by`.
            let nearest = candidates(&vectors, i, theiler, limit)
                .min_by(|&a, &b| sum(&vectors, norm, i, a).total_cmp(&sum(&vectors, norm, i, b)))
                .map(|index| Neighbour {
                    index,
                    distance: distance(&vectors, norm, i, index),
                });
            assert_eq!(in_turn, nearest, "{norm:?}, {i}");
            let alone = tree.nearest_each(std::iter::once(i), theiler, limit);
            assert_eq!(alone, [nearest], "{norm:?}, {i}");
            // A radius that is exactly the distance of some vector, and one just below.
            let far = distance(&vectors, norm, i, (7 * i + 3) % vectors.len());
            for radius in [far, far.next_down()] {
                let mut found = Vec::new();
                tree.within(i, radius, theiler, limit, |n| found.push(n));
                found.sort_unstable();
                let expected: Vec<usize> = candidates(&vectors, i, theiler, limit)
                    .filter(|&j| distance(&vectors, norm, i, j) <= radius)
                    .collect();
                assert_eq!(found, expected, "{norm:?}, {i}, {radius}");
                let next = candidates(&vectors, i, theiler, usize::MAX)
                    .filter(|&j| distance(&vectors, norm, i, j) > radius)
                    .min_by(|&a, &b| {
                        sum(&vectors, norm, i, a).total_cmp(&sum(&vectors, norm, i, b))
                    });
                let beyond = tree.nearest_beyond(i, radius, theiler);
                assert_eq!(beyond.map(|n| n.index), next, "{norm:?}, {i}, {radius}");
            }
        }
    }
}

#[test]
fn results_match_brute_force() {
    let chaos = coordinate(&lorenz(400, 0.02, [1.0, 1.0, 1.0]), 0);
    for (signal, lag) in [(chaos, 8), (noise(1, 400, 1e-3), 1)] {
        for dimension in [1, 2, 3, 5, 9] {
            assert_matches_brute_force(&signal, lag, dimension, 30, usize::MAX);
        }
        assert_matches_brute_force(&signal, lag, 3, 0, 200);
    }
}

#[test]
fn ties_go_to_the_smallest_index() {
    // Few different values: most distances occur many times, most vectors coincide with others.
    let steps: Vec<f64> = noise(2, 400, 1.0).iter().map(|x| x.round()).collect();
    let repeated: Vec<f64> = (0..400).map(|k| f64::from(k % 7)).collect();
    for signal in [steps, repeated, vec![2.5; 400]] {
        for (dimension, theiler) in [(1, 1), (2, 20), (4, 5)] {
            assert_matches_brute_force(&signal, 2, dimension, theiler, 350);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]
    #[test]
    fn results_are_exact_for_any_signal(
        samples in prop::collection::vec(
            prop_oneof![-1e3..1e3f64, (-3..3i32).prop_map(f64::from), -1e-9..1e-9f64],
            1..200,
        ),
        lag in 1..6usize,
        dimension in 1..7usize,
        theiler in 0..40usize,
        limit in 0..200usize,
    ) {
        prop_assume!(samples.len() > (dimension - 1) * lag);
        assert_matches_brute_force(&samples, lag, dimension, theiler, limit);
    }
}

#[test]
fn sizes_near_those_of_buckets_and_boxes_are_valid() {
    for n in [1, 2, 15, 16, 17, 127, 128, 129, 1023, 1024, 1025] {
        let signal = noise(n as u64, n, 1.0);
        let vectors = DelayVectors::new(&signal, 1, 1).unwrap();
        let tree = NeighbourTree::new(vectors, Norm::Euclidean);
        let mut count = 0;
        tree.within(n / 2, f64::INFINITY, 0, usize::MAX, |_| count += 1);
        assert_eq!(count, n - 1);
        let nearest = |theiler, limit| tree.nearest_each(0..1, theiler, limit);
        assert_eq!(nearest(n, usize::MAX), [None]);
        assert_eq!(nearest(1, 0), [None]);
        assert_eq!(nearest(usize::MAX, usize::MAX), [None]);
        assert_eq!(tree.nearest_all(1).len(), n);
    }
}

#[test]
fn infinite_distances_are_valid() {
    let signal = [1e300, -1e300, 1e300, -1e300, 0.0];
    assert_matches_brute_force(&signal, 1, 2, 1, usize::MAX);
}

#[test]
fn many_duplicates_do_not_slow_the_search() {
    // A quadratic search would compute 4e10 distances.
    let n = 200_000;
    let constant = vec![1.0; n];
    let periodic = sines(1.0, n, &[(0.25, 1.0, 0.0)]);
    for signal in [constant, periodic] {
        let vectors = DelayVectors::new(&signal, 1, 3).unwrap();
        let tree = NeighbourTree::new(vectors, Norm::Euclidean);
        let nearest = tree.nearest_all(100);
        assert!(nearest.iter().all(|n| n.is_some_and(|n| n.distance < 1e-9)));
        // In the periodic signal, the next nearest state is one of the other three.
        for i in (0..vectors.len()).step_by(10) {
            let other = tree.nearest_beyond(i, 1e-6, 100);
            assert_eq!(other.is_some(), signal[0] != 1.0);
        }
    }
}
