//! Intervals of sequences whose law is known.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

fn noise(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// How many of 2000 intervals hold the mean, which is zero, and how many call the course bounded.
fn covered(mut make: impl FnMut(&mut ChaCha8Rng) -> Vec<f64>) -> (f64, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut inside, mut bounded) = (0, 0);
    for _ in 0..2000 {
        let growth = make(&mut rng);
        let mean = growth.iter().sum::<f64>() / growth.len() as f64;
        let spread = spread(&growth);
        inside += u32::from(mean.abs() <= spread.half_width);
        bounded += u32::from(spread.course == Course::Bounded);
    }
    (f64::from(inside) / 2000.0, f64::from(bounded) / 2000.0)
}

#[test]
fn the_points_of_student_are_those_of_the_tables() {
    for (freedom, table) in [
        (7, 2.3646),
        (10, 2.2281),
        (15, 2.1314),
        (31, 2.0395),
        (127, 1.9788),
    ] {
        assert!((student(freedom) - table).abs() < 1e-3, "{freedom}");
    }
}

#[test]
fn intervals_of_independent_growth_hold_the_mean_in_95_of_100() {
    for count in [8, 64, 127] {
        let (inside, bounded) = covered(|rng| (0..count).map(|_| noise(rng)).collect());
        assert!((0.92..0.98).contains(&inside), "{count}: {inside}");
        assert!(count == 8 || bounded < 0.03, "{count}: {bounded}");
    }
}

/// Neighbours correlated by 0.5 leave 33 independent numbers in 100 batches, by 0.8 eleven: so few
/// are too short a time, and only 87 of 100 intervals hold the mean (of those of independent numbers
/// it would be 49).
#[test]
fn intervals_of_correlated_growth_are_widened() {
    for (correlation, least) in [(0.5, 0.91), (0.8, 0.85)] {
        let (inside, _) = covered(|rng| {
            let mut x = 0.0;
            let step = |_| {
                x = correlation * x + noise(rng);
                x
            };
            (0..100).map(step).collect()
        });
        assert!((least..0.98).contains(&inside), "{correlation}: {inside}");
    }
}

#[test]
fn growth_within_bounds_is_known_to_one_over_the_time() {
    let (inside, bounded) = covered(|rng| {
        let ends: Vec<f64> = (0..101).map(|_| noise(rng)).collect();
        ends.windows(2).map(|pair| pair[1] - pair[0]).collect()
    });
    assert!(inside > 0.95 && bounded > 0.99, "{inside}, {bounded}");
    let ends: Vec<f64> = (0..101).map(|k| (2.1 * f64::from(k)).sin()).collect();
    let growth: Vec<f64> = ends.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let spread = spread(&growth);
    assert_eq!(spread.course, Course::Bounded);
    // The sine has a range of 2, and its trend adds at most half as much again.
    assert!(spread.half_width < 3.0 / 100.0, "{spread:?}");
}

#[test]
fn few_batches_tell_nothing() {
    assert_eq!(spread(&[1.0; 7]).half_width, f64::INFINITY);
    assert_eq!(spread(&[1.0; 8]).half_width, 0.0);
}
