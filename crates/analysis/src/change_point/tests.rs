//! False alarms, detected changes and intermittency, on maps with known behaviour.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::test_signals::noise;

/// Number of blocks in the tests of single series.
const BLOCKS: usize = 100;

fn channel(values: Vec<f64>) -> Channel {
    Channel {
        values,
        min_change: 0.0,
        min_sum: 0.0,
    }
}

fn changes(values: Vec<f64>) -> Vec<usize> {
    change_points(&[channel(values)])
}

/// Number of seeds with a change among the given number.
fn count(seeds: u64, series: impl Fn(u64) -> Vec<f64>) -> usize {
    let found = (0..seeds).filter(|&seed| !changes(series(seed)).is_empty());
    found.count()
}

/// Means of a local exponent over blocks of `length` iterations. `map` takes `x` and
/// returns the next `x` and the logarithm of the slope.
fn local_exponents(seed: u64, length: usize, map: impl Fn(f64) -> [f64; 2]) -> Vec<f64> {
    let mut x: f64 = ChaCha8Rng::seed_from_u64(seed).random();
    let mut logarithm = || {
        let [next, logarithm] = map(x);
        // The slope is zero at the maximum of a map: a logarithm of minus infinity is possible.
        x = next;
        logarithm.max(-40.0)
    };
    let mut block = || (0..length).map(|_| logarithm()).sum::<f64>() / length as f64;
    (0..BLOCKS).map(|_| block()).collect()
}

fn logistic(r: f64) -> impl Fn(f64) -> [f64; 2] {
    move |x| [r * x * (1.0 - x), (r * (1.0 - 2.0 * x)).abs().ln()]
}

/// The map of Y. Pomeau and P. Manneville, Commun. Math. Phys. 74 (1980) 189: `x + x^z` modulo 1.
fn intermittent(z: f64) -> impl Fn(f64) -> [f64; 2] {
    move |x: f64| {
        let next = (x + x.powf(z)).fract();
        [next, (1.0 + z * x.powf(z - 1.0)).ln()]
    }
}

/// The map of M. Henon with parameter `a` and `b = 0.3`: local exponents per block of ten iterations, and
/// the values of `x`.
fn henon(a: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut x, mut y): (f64, f64) = (0.2 * rng.random::<f64>(), 0.2 * rng.random::<f64>());
    let (mut u, mut v) = (1.0_f64, 0.0_f64);
    let mut past = Vec::new();
    let mut block = || {
        let mut sum = 0.0;
        for _ in 0..10 {
            (u, v) = (-2.0 * a * x * u + v, 0.3 * u);
            (x, y) = (1.0 - a * x * x + y, 0.3 * x);
            past.push(x);
            let norm = u.hypot(v);
            sum += norm.ln();
            (u, v) = (u / norm, v / norm);
        }
        sum / 10.0
    };
    let values: Vec<f64> = (0..BLOCKS).map(|_| block()).collect();
    (values, past)
}

/// Values of `x` of the logistic map from the same start as [`local_exponents`].
fn logistic_orbit(r: f64, seed: u64, count: usize) -> Vec<f64> {
    let mut x: f64 = ChaCha8Rng::seed_from_u64(seed).random();
    let mut next = || {
        x = r * x * (1.0 - x);
        x
    };
    (0..count).map(|_| next()).collect()
}

/// The first block of `length` values from which the values have a period.
fn end_of_chaos(past: &[f64], period: usize, length: usize) -> usize {
    let chaotic = (period..past.len())
        .rev()
        .find(|&k| (past[k] - past[k - period]).abs() > 0.01);
    chaotic.map_or(0, |k| k / length + 1)
}

#[test]
fn independent_blocks_keep_the_stated_rate() {
    // Ten channels, 1000 series: 1 expected, more than 6 with a probability below 1e-4.
    let found = (0..1000).filter(|&seed| {
        let channels = (0..10).map(|k| channel(noise(10 * seed + k, BLOCKS, 1.0)));
        !change_points(&channels.collect::<Vec<_>>()).is_empty()
    });
    let found = found.count();
    println!("{found} of 1000");
    assert!(found <= 6, "{found}");
}

#[test]
fn the_critical_value_has_the_stated_rate() {
    let series = 50_000;
    for count in [64, 128] {
        let above = (0..series).filter(|&k| {
            // Without the tests of the change found, whose effect would be smaller than stated.
            let values = noise(k, count, 1.0);
            let windows = WINDOWS.map(|w| w.map(|quarter| quarter * count / 4));
            windows
                .iter()
                .any(|&[from, to]| cusum(&values[from..to], MIN_SEGMENT) > CRITICAL)
        });
        let above = above.count();
        println!("{count} blocks: {above} of {series}");
        // 5 expected; 1 to 13 with a probability of 0.992.
        assert!((1..=13).contains(&above), "{count} blocks: {above}");
    }
}

#[test]
fn correlated_blocks_seldom_change() {
    // Correlation 0.6 of neighbours: a block is only one correlation time long.
    let found = count(2000, |seed| {
        let mut x = 0.0;
        let random = noise(seed, BLOCKS, 1.0).into_iter();
        let walk = random.map(|step| {
            x = 0.6 * x + step;
            x
        });
        walk.collect()
    });
    println!("{found} of 2000");
    assert!(found <= 10, "{found}");
}

#[test]
fn stationary_chaos_does_not_change() {
    for length in [1, 3, 10, 100] {
        let chaos = count(1000, |seed| local_exponents(seed, length, logistic(3.99)));
        let banded = count(1000, |seed| local_exponents(seed, length, logistic(3.6)));
        println!("blocks of {length}: {chaos}, {banded} of 1000");
        assert!(chaos <= 4 && banded <= 4, "{length}: {chaos} {banded}");
    }
    let found = (0..1000).filter(|&seed| !changes(henon(1.4, seed).0).is_empty());
    let found = found.count();
    println!("Henon: {found}");
    assert!(found <= 4, "{found}");
}

/// Laminar and chaotic phases alternate: type I before the window of period three, and the map of Pomeau
/// and Manneville. In the shortest series only two or three laminar phases occur.
#[test]
fn intermittency_is_not_a_change() {
    let onset = 1.0 + 8.0_f64.sqrt();
    for length in [10, 100] {
        for below in [1e-3, 1e-4, 1e-5] {
            let found = count(500, |seed| {
                local_exponents(seed, length, logistic(onset - below))
            });
            println!("type I, {below}, blocks of {length}: {found} of 500");
            let phases = BLOCKS as f64 * length as f64 * below.sqrt();
            let most = if phases < 5.0 { 20 } else { 5 };
            assert!(found <= most, "{below} {length}: {found}");
        }
        // From z = 1.5 on the lengths of the laminar phases have no finite variance: in any series the longest
        // is a large part of it.
        for (z, most) in [(1.3, 5), (1.5, 10), (1.7, 40)] {
            let found = count(500, |seed| local_exponents(seed, length, intermittent(z)));
            println!("z = {z}, blocks of {length}: {found} of 500");
            assert!(found <= most, "{z} {length}: {found}");
        }
    }
}

/// In a periodic window beyond a crisis or a tangent bifurcation the former attractor remains as a chaotic
/// transient. Its end is known from the orbit.
#[test]
fn a_chaotic_transient_ends_where_the_orbit_becomes_periodic() {
    let logistic = |r, period, seed| {
        let values = local_exponents(seed, 5, logistic(r));
        (
            values,
            end_of_chaos(&logistic_orbit(r, seed, 5 * BLOCKS), period, 5),
        )
    };
    let henon = |seed| {
        let (values, past) = henon(1.3, seed);
        (values, end_of_chaos(&past, 7, 10))
    };
    type Run<'a> = &'a dyn Fn(u64) -> (Vec<f64>, usize);
    let systems: [(&str, Run); 3] = [
        ("logistic map, period 4", &|seed| logistic(3.9602, 4, seed)),
        ("logistic map, period 7", &|seed| logistic(3.7017, 7, seed)),
        ("Henon map, period 7", &henon),
    ];
    for (name, run) in systems {
        let runs = (0..400).map(run);
        let runs: Vec<_> = runs.filter(|(_, end)| (15..=70).contains(end)).collect();
        let found = runs.iter().filter_map(|(values, end)| {
            let last = *changes(values.clone()).last()?;
            Some(last.abs_diff(*end) <= 4)
        });
        let found: Vec<bool> = found.collect();
        let right = found.iter().filter(|right| **right).count();
        println!(
            "{name}: {} transients, {} found, {right} in time",
            runs.len(),
            found.len()
        );
        assert!(
            runs.len() >= 50 && 10 * found.len() >= 9 * runs.len(),
            "{name}"
        );
        assert!(20 * right >= 19 * found.len(), "{name}");
    }
}

/// Delay of the detection: blocks of the new state until a change by so many standard deviations of a block
/// is found in nine of ten series.
#[test]
fn the_delay_is_a_fraction_of_the_series() {
    for (step, most) in [(3.0, 0.33), (5.0, 0.2), (10.0, 0.12)] {
        let detected = |after: usize| {
            let seeds = 0..200_u64;
            let found = seeds.filter(|&seed| {
                let random = noise(seed, BLOCKS, 1.0).into_iter().enumerate();
                // The new state is a tone: its exponents hardly fluctuate.
                let values = random.map(|(k, x)| {
                    if k < BLOCKS - after {
                        step + x
                    } else {
                        0.01 * x
                    }
                });
                let changes = changes(values.collect());
                changes
                    .last()
                    .is_some_and(|&at| at.abs_diff(BLOCKS - after) <= 1)
            });
            found.count() >= 180
        };
        let delay = (4..60).find(|&after| detected(after)).unwrap() as f64 / BLOCKS as f64;
        println!("{step} standard deviations: {delay}");
        assert!(delay <= most, "{step}: {delay}");
    }
}

#[test]
fn several_changes_are_found() {
    let random = noise(3, 120, 1.0).into_iter().enumerate();
    let level = |k: usize| match k {
        0..30 => 30.0,
        30..70 => 10.0,
        _ => 0.0,
    };
    let values = random.map(|(k, x)| level(k) + x).collect();
    let found = changes(values);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found[0].abs_diff(30) <= 1 && found[1].abs_diff(70) <= 1,
        "{found:?}"
    );
}

#[test]
fn a_motion_that_returns_has_not_changed() {
    let random = noise(4, 120, 1.0).into_iter().enumerate();
    let there = |k: usize| (25..50).contains(&k);
    let back = random
        .clone()
        .map(|(k, x)| x + if there(k) { 20.0 } else { 0.0 });
    assert!(changes(back.collect()).is_empty());
    // The same, and then another state until the end.
    let on = random.map(|(k, x)| match k {
        95.. => x - 30.0,
        _ => x + if there(k) { 20.0 } else { 0.0 },
    });
    let found = changes(on.collect());
    assert!(found.len() == 1 && found[0].abs_diff(95) <= 1, "{found:?}");
}

#[test]
fn small_changes_do_not_matter() {
    let random = noise(5, BLOCKS, 1e-3).into_iter().enumerate();
    let values: Vec<f64> = random
        .map(|(k, x)| x + if k < 60 { 0.1 } else { 0.0 })
        .collect();
    let with = |min_change, min_sum| {
        let values = values.clone();
        change_points(&[Channel {
            values,
            min_change,
            min_sum,
        }])
    };
    assert_eq!(with(0.09, 3.9), [60]);
    assert!(with(0.11, 0.0).is_empty());
    // The shorter side has 40 blocks.
    assert!(with(0.0, 4.1).is_empty());
}

#[test]
fn a_drift_is_not_a_change() {
    let drift = |noise: Vec<f64>| {
        let values = noise
            .into_iter()
            .enumerate()
            .map(|(k, x)| x - 0.3 * k as f64);
        values.collect()
    };
    for seed in 0..100 {
        assert!(changes(drift(noise(seed, BLOCKS, 0.01))).is_empty());
        assert!(changes(drift(noise(seed, BLOCKS, 1.0))).is_empty());
    }
}

/// Settling: an exponential approach within the first tenth is cut off, the rest is one state.
#[test]
fn a_settling_start_is_cut_off() {
    let mut late = 0;
    for seed in 0..100 {
        let random = noise(seed, BLOCKS, 1.0).into_iter().enumerate();
        let values = random.map(|(k, x)| x - 30.0 * (-(k as f64) / 4.0).exp());
        let found = changes(values.collect());
        assert!(
            found.len() <= 2 && found.iter().all(|&at| at <= 20),
            "{found:?}"
        );
        late += usize::from(found.is_empty());
    }
    println!("{late} of 100 not seen");
    assert!(late <= 2, "{late}");
}

#[test]
fn degenerate_series_have_no_change() {
    assert!(change_points(&[]).is_empty());
    for series in [
        vec![],
        vec![7.0; 100],
        vec![0.1 + 0.2; 64],
        noise(1, 31, 1.0),
    ] {
        assert!(changes(series).is_empty());
    }
    // A channel that is not finite is ignored, another still counts.
    let step = |k: usize| if k < 50 { 5.0 } else { 0.0 } + noise(2, 100, 0.1)[k];
    let values: Vec<f64> = (0..100).map(step).collect();
    let collapsed = vec![f64::NEG_INFINITY; 100];
    assert_eq!(change_points(&[channel(collapsed), channel(values)]), [50]);
}

#[test]
fn blocks_are_merged_in_bounded_memory() {
    let mut blocks = crate::stats::BlockMeans::new(2);
    for k in 0..5000 {
        blocks.push(&[f64::from(k), 3.0]);
        assert!(blocks.count() <= 128);
    }
    assert_eq!((blocks.length(), blocks.count()), (64, 78));
    let means = blocks.channel(0);
    assert!(
        means
            .iter()
            .enumerate()
            .all(|(k, mean)| *mean == 64.0 * k as f64 + 31.5)
    );
    assert!(blocks.channel(1).iter().all(|mean| *mean == 3.0));
}
