use proptest::prelude::*;

use super::*;
use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};

/// Values of a map after 1000 steps.
fn map(n: usize, mut next: impl FnMut() -> f64) -> Vec<f64> {
    (0..1000).for_each(|_| _ = next());
    (0..n).map(|_| next()).collect()
}

/// The logistic map at 4; largest exponent ln 2.
fn logistic(n: usize) -> Vec<f64> {
    let mut x = 0.3;
    map(n, || {
        x = 4.0 * x * (1.0 - x);
        x
    })
}

/// The Henon map (1.4, 0.3); largest exponent 0.419 (Sprott).
fn henon(n: usize) -> Vec<f64> {
    let (mut x, mut y) = (0.1, 0.1);
    map(n, || {
        (x, y) = (1.0 - 1.4 * x * x + y, 0.3 * x);
        x
    })
}

fn kantz(search: DivergenceSearch, radius: f64) -> DivergenceSearch {
    DivergenceSearch {
        method: DivergenceMethod::Kantz { radius },
        ..search
    }
}

/// Within `share` of the true exponent and within three standard errors.
fn assert_agrees(samples: &[f64], search: &DivergenceSearch, truth: f64, share: f64) {
    let region = divergence(samples, search).unwrap().region;
    let region = region.expect("a scaling region");
    let (slope, error) = (region.slope / truth, region.error / truth);
    let off = (slope - 1.0).abs();
    assert!(off <= share && off <= 3.0 * error, "{slope} +- {error}");
}

#[test]
fn maps_have_their_exponents() {
    let logistic = logistic(5000);
    let henon = henon(5000);
    for dimension in [1, 2, 3] {
        let search = DivergenceSearch::for_delay(1, dimension, 1, 5000);
        assert_agrees(&logistic, &search, 2f64.ln(), 0.01);
        assert_agrees(&logistic, &kantz(search, 0.005), 2f64.ln(), 0.05);
    }
    for dimension in [2, 3] {
        let search = DivergenceSearch::for_delay(1, dimension, 1, 5000);
        assert_agrees(&henon, &search, 0.419, 0.05);
    }
    let search = DivergenceSearch::for_delay(1, 2, 1, 5000);
    assert_agrees(&henon, &kantz(search, 0.005), 0.419, 0.05);
}

#[test]
fn the_lorenz_exponent_is_found_within_a_tenth() {
    // Ratios to the true exponent: 0.94, 0.96 and 0.93, each with an error of 0.04 to 0.06.
    let x = coordinate(&lorenz(30_000, 0.01, [1.0, 1.0, 1.0]), 0);
    for dimension in [3, 4, 5] {
        let search = DivergenceSearch::for_delay(16, dimension, 75, x.len());
        assert_agrees(&x, &search, 0.009_056, 0.1);
    }
}

#[test]
fn the_roessler_exponent_is_found_within_fifteen_percent() {
    // Ratio 0.90 with an error of 0.07; other trajectories give 0.86 to 0.96.
    let x = coordinate(&roessler(50_000, 0.1, [0.2, 0.2, 5.7], [1.0, 1.0, 0.0]), 0);
    for dimension in [3, 5] {
        let search = DivergenceSearch::for_delay(14, dimension, 60, x.len());
        assert_agrees(&x, &search, 0.007_14, 0.15);
    }
}

#[test]
fn kantz_finds_the_lorenz_exponent_in_many_samples() {
    // Ratio 1.06; three trajectories give 1.05 to 1.10.
    let x = coordinate(&lorenz(50_000, 0.01, [1.0, 1.0, 1.0]), 0);
    let search = kantz(DivergenceSearch::for_delay(16, 5, 75, x.len()), 0.02);
    assert_agrees(&x, &search, 0.009_056, 0.1);
}

#[test]
fn regular_signals_and_noise_have_no_region() {
    let golden = 1.3 * 1.618_034;
    let sine = sines(100.0, 10_000, &[(1.3, 1.0, 0.1)]);
    let torus = sines(100.0, 10_000, &[(1.3, 1.0, 0.1), (golden, 0.7, 0.0)]);
    let white = noise(4, 10_000, 1.0);
    let noisy: Vec<f64> = sine.iter().zip(&white).map(|(s, n)| s + 0.02 * n).collect();
    // Noise through one and two low-pass filters: distances grow slowly.
    let low_pass = |input: &[f64]| -> Vec<f64> {
        let mut sum = 0.0;
        let mut next = |x: &f64| {
            sum = 0.98 * sum + x;
            sum
        };
        input.iter().map(&mut next).collect()
    };
    let red = low_pass(&white);
    let redder = low_pass(&red);
    for (signal, lag, dimension, theiler) in [
        (&sine, 19, 3, 77),
        (&torus, 14, 4, 77),
        (&noisy, 19, 3, 77),
        (&white, 1, 3, 1),
        (&white, 1, 10, 1),
        (&red, 20, 4, 100),
        (&redder, 50, 4, 200),
        (&redder, 2, 4, 200),
    ] {
        let search = DivergenceSearch {
            horizon: if theiler == 1 { 30 } else { 1000 },
            ..DivergenceSearch::for_delay(lag, dimension, theiler, signal.len())
        };
        for search in [search, kantz(search, 0.1)] {
            let found = divergence(signal, &search).unwrap();
            assert_eq!(found.region, None, "{search:?}");
        }
    }
}

/// Curve and counts by the definition, following all states.
fn by_definition(samples: &[f64], search: &DivergenceSearch) -> (Vec<f64>, Vec<usize>) {
    let span = (search.dimension - 1) * search.lag;
    let limit = samples.len() - span - search.horizon;
    let coordinates = || (0..=span).step_by(search.lag);
    let differences =
        |i: usize, j: usize| coordinates().map(move |c| (samples[i + c] - samples[j + c]).abs());
    let euclid = |i, j| differences(i, j).map(|d| d * d).sum::<f64>().sqrt();
    let others = |i: usize| (0..limit).filter(move |j| i.abs_diff(*j) >= search.theiler.max(1));
    let mut curve = Vec::new();
    let mut counted = Vec::new();
    for k in 0..=search.horizon {
        let after = |i: usize| match search.method {
            DivergenceMethod::Rosenstein => {
                let neighbours = others(i).min_by(|a, b| euclid(i, *a).total_cmp(&euclid(i, *b)));
                neighbours.map(|j| euclid(i + k, j + k))
            }
            DivergenceMethod::Kantz { radius } => {
                let radius = radius * deviation(samples);
                let neighbours: Vec<usize> = others(i)
                    .filter(|j| differences(i, *j).fold(0.0, f64::max) <= radius)
                    .collect();
                let newest = |j: usize| (samples[i + k + span] - samples[j + k + span]).abs();
                let mean =
                    neighbours.iter().map(|j| newest(*j)).sum::<f64>() / neighbours.len() as f64;
                (neighbours.len() >= MIN_NEIGHBOURS).then_some(mean)
            }
        };
        let logarithms: Vec<f64> = (0..limit).filter_map(after).map(f64::ln).collect();
        curve.push(logarithms.iter().sum::<f64>() / logarithms.len() as f64);
        counted.push(logarithms.len());
    }
    (curve, counted)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn the_curve_matches_the_definition(
        seed in 0..1000_u64,
        lag in 1..4_usize,
        dimension in 1..4_usize,
        theiler in 0..20_usize,
        radius in 0.5..1.5,
    ) {
        let samples = noise(seed, 150, 2.0);
        let search = DivergenceSearch {
            lag,
            dimension,
            theiler,
            horizon: 5,
            method: DivergenceMethod::Rosenstein,
            max_references: 1000,
        };
        for search in [search, kantz(search, radius)] {
            let found = divergence(&samples, &search).unwrap();
            let (curve, counted) = by_definition(&samples, &search);
            prop_assert_eq!(&found.counted, &counted);
            for (a, b) in found.curve.iter().zip(&curve) {
                prop_assert!((a - b).abs() < 1e-12, "{} {}", a, b);
            }
        }
    }
}

#[test]
fn many_neighbours_are_sampled_evenly() {
    // Uniform phases: the mean over every fourth neighbour is close to that over all. The exact mean of
    // |x_i - x_j| at step 0 over a band of the sine is computed directly.
    let sine = sines(1000.0, 9000, &[(7.318, 1.0, 0.0)]);
    let mut search = kantz(DivergenceSearch::for_delay(35, 2, 137, sine.len()), 0.4);
    search.horizon = 10;
    search.max_references = 40;
    let found = divergence(&sine, &search).unwrap();
    let limit = sine.len() - 35 - 10;
    let neighbours = |i: usize| {
        let radius = 0.4 * deviation(&sine);
        let sine = &sine;
        (0..limit).filter(move |&j| {
            i.abs_diff(j) >= 137
                && (sine[i] - sine[j]).abs() <= radius
                && (sine[i + 35] - sine[j + 35]).abs() <= radius
        })
    };
    let mean = |i: usize| {
        assert!(neighbours(i).count() > MAX_NEIGHBOURS);
        neighbours(i)
            .map(|j| (sine[i + 35] - sine[j + 35]).abs())
            .sum::<f64>()
            / neighbours(i).count() as f64
    };
    let references = (0..40).map(|r| r * limit / 40);
    let expected = references.map(|i| mean(i).ln()).sum::<f64>() / 40.0;
    assert!(
        (found.curve[0] - expected).abs() < 0.02,
        "{} {expected}",
        found.curve[0]
    );
}

#[test]
fn signals_that_repeat_exactly_have_an_empty_curve() {
    let constant = vec![0.1; 500];
    let period: Vec<f64> = (0..500).map(|i| f64::from(i % 5)).collect();
    for signal in [constant, period] {
        let search = DivergenceSearch::for_delay(1, 3, 1, signal.len());
        for search in [search, kantz(search, 0.1)] {
            let found = divergence(&signal, &search).unwrap();
            assert!(found.curve.is_empty() && found.counted.is_empty());
            assert_eq!(found.region, None);
        }
    }
    // No neighbour lies within this radius.
    let search = kantz(DivergenceSearch::for_delay(1, 10, 1, 500), 0.01);
    assert!(
        divergence(&noise(1, 500, 1.0), &search)
            .unwrap()
            .curve
            .is_empty()
    );
}

#[test]
fn invalid_searches_are_rejected() {
    let search = DivergenceSearch::for_delay(3, 4, 10, 400);
    assert_eq!(search.horizon, 100);
    let short = |have| AnalysisError::TooShort {
        what: "divergence",
        have,
        need: 9 + 100 + 2 * 10 + 1,
    };
    let rejection = |n: usize, search| divergence(&vec![0.0; n], &search).unwrap_err();
    assert_eq!(rejection(129, search), short(129));
    assert!(divergence(&noise(1, 130, 1.0), &search).is_ok());
    let endless = DivergenceSearch {
        theiler: usize::MAX,
        ..search
    };
    assert!(matches!(
        rejection(400, endless),
        AnalysisError::TooShort { .. }
    ));
    let no_lag = DivergenceSearch { lag: 0, ..search };
    assert!(matches!(
        rejection(400, no_lag),
        AnalysisError::InvalidDelay { .. }
    ));
}

#[test]
fn threads_do_not_change_the_result() {
    let signal = henon(3000);
    let search = DivergenceSearch::for_delay(1, 2, 1, signal.len());
    for search in [search, kantz(search, 0.02)] {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| divergence(&signal, &search).unwrap())
        };
        assert_eq!(with(1), with(3));
    }
}

#[test]
fn unit_and_offset_of_the_signal_do_not_matter() {
    let signal = henon(3000);
    let search = DivergenceSearch::for_delay(1, 2, 1, signal.len());
    let region = |scale: f64, offset: f64| {
        let other: Vec<f64> = signal.iter().map(|x| scale * x + offset).collect();
        divergence(&other, &search).unwrap().region.unwrap()
    };
    let (here, there) = (region(1.0, 0.0), region(-250.0, 3.0));
    assert_eq!((here.from, here.to), (there.from, there.to));
    assert!((here.slope - there.slope).abs() < 1e-6);
    assert!((here.intercept + 250_f64.ln() - there.intercept).abs() < 1e-6);
}
