//! Intervals of sequences whose law is known.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

fn noise(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// How many of 2000 intervals hold the mean, which is zero.
fn covered(mut make: impl FnMut(&mut ChaCha8Rng) -> Vec<f64>) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut inside = 0;
    for _ in 0..2000 {
        let growth = make(&mut rng);
        let mean = growth.iter().sum::<f64>() / growth.len() as f64;
        inside += u32::from(mean.abs() <= independent(&growth));
    }
    f64::from(inside) / 2000.0
}

/// Batches of ten even growths each, from the places at the ends of these.
fn batches(places: &[f64]) -> Vec<Part> {
    let growth: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let even = growth.iter().map(|&growth| Part {
        growth,
        low: growth.min(0.0),
        high: growth.max(0.0),
    });
    let even: Vec<Part> = even.collect();
    let join = |parts: &[Part]| parts.iter().copied().fold(Part::default(), Part::then);
    even.chunks_exact(10).map(join).collect()
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
        let inside = covered(|rng| (0..count).map(|_| noise(rng)).collect());
        assert!((0.92..0.98).contains(&inside), "{count}: {inside}");
    }
}

/// Neighbours correlated by 0.5 leave 33 independent numbers in 100 batches, by 0.8 eleven: so few
/// are too short a time, and only 87 of 100 intervals hold the mean (of those of independent numbers
/// it would be 49).
#[test]
fn intervals_of_correlated_growth_are_widened() {
    for (correlation, least) in [(0.5, 0.91), (0.8, 0.85)] {
        let inside = covered(|rng| {
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
fn a_random_walk_is_hardly_ever_taken_for_neutral() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let neutral = (0..2000).filter(|_| {
        let mut place = 0.0;
        let places: Vec<f64> = (0..=1000)
            .map(|_| {
                place += noise(&mut rng);
                place
            })
            .collect();
        bounded(&batches(&places)).is_some()
    });
    let share = neutral.count() as f64 / 2000.0;
    assert!(share < 0.02, "{share}");
}

/// Whatever the period is to the batch: also where a batch is nearly a whole number of periods.
#[test]
fn a_wave_is_neutral_and_known_to_one_over_the_time() {
    for k in 1..200 {
        let rate = 0.02 * f64::from(k);
        let wave: Vec<f64> = (0..=1000).map(|n| (rate * f64::from(n)).sin()).collect();
        let range = bounded(&batches(&wave));
        // Fewer than sixteen periods leave it open.
        assert!(
            range.is_some() || rate * 1000.0 < 32.0 * std::f64::consts::PI,
            "{rate}"
        );
        assert!(range.is_none_or(|range| range <= 2.0));
    }
}

#[test]
fn a_trend_beyond_its_wave_is_not_neutral() {
    for (trend, neutral) in [(0.001, true), (0.02, false)] {
        let place = |n: u32| (0.7 * f64::from(n)).sin() - trend * f64::from(n);
        let places: Vec<f64> = (0..=1000).map(place).collect();
        assert_eq!(bounded(&batches(&places)).is_some(), neutral, "{trend}");
    }
}

#[test]
fn few_batches_tell_nothing() {
    assert_eq!(independent(&[1.0; 7]), f64::INFINITY);
    assert_eq!(independent(&[1.0; 8]), 0.0);
    assert_eq!(bounded(&[Part::default(); 15]), None);
}
