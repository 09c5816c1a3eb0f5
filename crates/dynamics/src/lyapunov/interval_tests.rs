//! Confidence intervals of sequences with known distributions.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

fn noise(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Fraction of 2000 intervals that contain the true mean of zero.
fn coverage(mut make: impl FnMut(&mut ChaCha8Rng) -> Vec<f64>) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut inside = 0;
    for _ in 0..2000 {
        let growth = make(&mut rng);
        let mean = growth.iter().sum::<f64>() / growth.len() as f64;
        inside += u32::from(mean.abs() <= half_width(&growth));
    }
    f64::from(inside) / 2000.0
}

/// Batches of ten increments each from a sequence of positions.
fn batches(positions: &[f64]) -> Vec<GrowthInterval> {
    let growth: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let even = growth.iter().map(|&growth| GrowthInterval {
        growth,
        low: growth.min(0.0),
        high: growth.max(0.0),
    });
    let even: Vec<GrowthInterval> = even.collect();
    let join = |parts: &[GrowthInterval]| {
        parts
            .iter()
            .copied()
            .fold(GrowthInterval::default(), GrowthInterval::then)
    };
    even.chunks_exact(10).map(join).collect()
}

#[test]
fn students_quantiles_agree_with_tables() {
    for (degrees_of_freedom, table) in [
        (7, 2.3646),
        (10, 2.2281),
        (15, 2.1314),
        (31, 2.0395),
        (127, 1.9788),
    ] {
        assert!(
            (student(degrees_of_freedom) - table).abs() < 1e-3,
            "{degrees_of_freedom}"
        );
    }
}

#[test]
fn intervals_of_independent_growth_have_95_percent_coverage() {
    for count in [8, 64, 127] {
        let inside = coverage(|rng| (0..count).map(|_| noise(rng)).collect());
        assert!((0.92..0.98).contains(&inside), "{count}: {inside}");
    }
}

/// A lag-1 correlation of 0.5 leaves 33 effectively independent values in 100 batches, one of 0.8 leaves
/// eleven. In the latter case the time is too short, and only 87 % of the intervals contain the mean (49
/// % without the correction).
#[test]
fn intervals_of_correlated_growth_are_widened() {
    for (correlation, least) in [(0.5, 0.91), (0.8, 0.85)] {
        let inside = coverage(|rng| {
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
fn a_random_walk_is_rarely_classified_as_neutral() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let neutral = (0..2000).filter(|_| {
        let mut position = 0.0;
        let positions: Vec<f64> = (0..=1000)
            .map(|_| {
                position += noise(&mut rng);
                position
            })
            .collect();
        bounded_range(&batches(&positions)).is_some()
    });
    let share = neutral.count() as f64 / 2000.0;
    assert!(share < 0.02, "{share}");
}

/// For any ratio of the period to the batch length, including nearly integer ones.
#[test]
fn a_bounded_wave_is_neutral() {
    for k in 1..200 {
        let rate = 0.02 * f64::from(k);
        let wave: Vec<f64> = (0..=1000).map(|n| (rate * f64::from(n)).sin()).collect();
        let range = bounded_range(&batches(&wave));
        // Fewer than sixteen periods may leave it undetermined.
        assert!(
            range.is_some() || rate * 1000.0 < 32.0 * std::f64::consts::PI,
            "{rate}"
        );
        assert!(range.is_none_or(|range| range <= 2.0));
    }
}

#[test]
fn a_trend_larger_than_the_wave_is_not_neutral() {
    for (trend, neutral) in [(0.001, true), (0.02, false)] {
        let position = |n: u32| (0.7 * f64::from(n)).sin() - trend * f64::from(n);
        let positions: Vec<f64> = (0..=1000).map(position).collect();
        assert_eq!(
            bounded_range(&batches(&positions)).is_some(),
            neutral,
            "{trend}"
        );
    }
}

#[test]
fn too_few_batches_give_no_estimate() {
    assert_eq!(half_width(&[1.0; 7]), f64::INFINITY);
    assert_eq!(half_width(&[1.0; 8]), 0.0);
    assert_eq!(bounded_range(&[GrowthInterval::default(); 15]), None);
}
